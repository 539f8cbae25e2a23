"""How a decided step moves."""
