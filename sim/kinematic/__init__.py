"""The kinematic plant: servos that do what they are told, contact, tipping, falling."""
