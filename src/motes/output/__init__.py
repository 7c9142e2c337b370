"""Tracks into files, pictures and plots."""
