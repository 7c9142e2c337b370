"""Trained networks: what one sees in a frame around a place, in boxes and scores."""
