"""What the walker believes about the ground."""
