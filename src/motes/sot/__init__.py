"""Single-object tracking: trackers, their presets, and what they are made of."""
