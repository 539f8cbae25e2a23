"""What a walker is: legs, joints, reach, masses, limits."""
