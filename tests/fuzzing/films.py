"""Videos and pictures, a kind of input for each kind of file in `containers`.

Now and then an encoder writes other bytes of the same pictures, and so the inputs are others.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial
from random import Random

import numpy as np

from .campaign import Kind
from .containers import ANIMATIONS, STILLS, VIDEOS, check, damage, seed_files
from .outcomes import put, scratch


@cache
def _files() -> dict[str, bytes]:
    folder = scratch() / "films"
    folder.mkdir()
    return {path.name: path.read_bytes() for path in seed_files(folder)}


def seeds(name: str) -> list[bytes]:
    """Return the whole file of this name."""
    return [_files()[name]]


def read(name: str, data: bytes) -> str:
    """Read a file with the ending of this name, and return how far that came."""
    return check(put(name, data))


def mutate(rng: Random, files: Sequence[bytes]) -> bytes:
    """Return one of the files with damage."""
    return damage(np.random.default_rng(rng.getrandbits(64)), rng.choice(files))


KINDS = tuple(
    Kind(f"film-{name}", partial(seeds, name), partial(read, name), block=10, mutate=mutate)
    for name in (*VIDEOS, *ANIMATIONS, *STILLS)
)
