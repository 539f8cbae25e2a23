"""Level B1 (H §3): detours round ground that cannot be stepped over."""
