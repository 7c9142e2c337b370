"""Tracks written to files, drawn on frames and plotted."""
