"""The effort of correcting tracks: a simulated annotator."""
