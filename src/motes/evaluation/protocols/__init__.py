"""How a tracker is run over a sequence."""
