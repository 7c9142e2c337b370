"""Saved trackers, broken in the ways of `broken_states`."""

from collections.abc import Sequence
from random import Random

import broken_states
from broken_states import check

__all__ = ["check", "mutate", "seeds"]


def seeds() -> list[bytes]:
    names = ("default", "nummiaro:adaptive", "mean_shift", "all, by cue")
    return [broken_states.example(name, "tracking") for name in names]


def mutate(rng: Random, saved: Sequence[bytes]) -> bytes:
    return broken_states.mutate(rng, rng.choice(saved))
