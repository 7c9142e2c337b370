"""Tracks drawn on frames, and plotted."""
