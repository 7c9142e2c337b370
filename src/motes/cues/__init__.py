"""What pixels say about an ellipse: one cue a file; `base.py` has their interface."""
