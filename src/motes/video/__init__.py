"""Video in and out: sources, decoding, live cameras, writing."""
