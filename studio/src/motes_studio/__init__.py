"""The studio: see, correct and trust tracks in a browser."""
