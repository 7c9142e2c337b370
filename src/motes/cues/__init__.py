"""What pixels say about an ellipse: one file per cue."""
