"""Everything that shows: the page and the scene."""
