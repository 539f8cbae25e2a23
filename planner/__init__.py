"""Everything that decides: from a command and what is sensed to the next step."""
