"""Sequences with truth, and their files."""
