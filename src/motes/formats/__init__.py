"""Tracks, annotations and truth in the files of other tools; `registry` lists all formats."""
