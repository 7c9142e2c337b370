"""The environment of a worker: how many threads its libraries may start."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "MOTES_THREADS")
"""Variables that limit the threads of libraries, and of motes (`motes.video.prefetch`)."""


def thread_limits(threads: int = 1) -> dict[str, str]:
    """Return the environment of a worker, with a limit for the threads of its libraries."""
    return dict.fromkeys(THREADS, str(threads))


@contextlib.contextmanager
def environment(variables: dict[str, str]) -> Iterator[None]:
    """Set variables for processes that are started meanwhile."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
