"""Experiments that repeat tables and figures of the papers; each is a generator of results."""
