"""What all parts share: frames, tracks, geometry, configuration, errors."""
