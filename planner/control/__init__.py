"""Level C (H §8, §9) and its conversation with Level B."""
