"""How much memory a job needs, from the size of its frames."""

from __future__ import annotations

from motes.cluster.jobs import Job


def memory_of(job: Job) -> int:
    """Return the bytes that a job is expected to need."""
    return 0
