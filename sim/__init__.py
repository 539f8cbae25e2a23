"""Everything that happens: ground, contact and the walking machine itself."""
