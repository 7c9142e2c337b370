"""The parts that all packages use: frames, tracks, geometry, configuration, errors."""
