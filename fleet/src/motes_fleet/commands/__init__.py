"""The commands that motes-fleet adds to motes."""
