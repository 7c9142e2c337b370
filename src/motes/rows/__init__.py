"""Rows of tracks: one schema, its writer and its reader, and the journal of a run."""
