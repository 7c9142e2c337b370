"""The check of a seed of random numbers."""

from __future__ import annotations

import numpy as np

from motes.core.errors import ConfigError


def checked_seed(seed: object) -> int:
    """Return a seed as an int; raise a ConfigError if it is not from 0 to 2**64 - 1."""
    if not isinstance(seed, int | np.integer) or not 0 <= seed < 1 << 64:
        raise ConfigError(f"A seed is a whole number from 0 to 2**64 - 1; got {seed!r}.")
    return int(seed)
