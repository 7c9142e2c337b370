"""Single-object tracking: algorithms, their parts, their presets, and `Tracker`."""
