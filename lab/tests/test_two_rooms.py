"""The experiment of two rooms, short, and its numbers."""

from __future__ import annotations

import numpy as np
import pytest

from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene
from motes_lab.papers import two_rooms


@pytest.mark.slow
def test_a_passage_is_kept_with_handover_and_not_without() -> None:
    rooms = two_rooms.rooms(seed=13, frames=400, people=1)
    assert len(rooms.passages) == 1
    ways = list(two_rooms.WAYS.values())
    named = two_rooms.identities(rooms, ways, lambda _: Scene(BackgroundDetector("gaussian")))
    assert [two_rooms.kept(found, rooms.passages) for found in named] == [[True], [True], [False]]
    [early], [late], none = (
        two_rooms.until_known(found, rooms.passages, rooms.clips) for found in named
    )
    assert early < late
    assert none == []


def test_kept_compares_the_last_identity_with_the_next_first() -> None:
    names = np.full((2, 8, 1), np.nan)
    names[0, :3, 0], names[1, 6:, 0] = (4, 4, 5), (5, 6)
    assert two_rooms.kept(names, [(0, 0, 3, 5)]) == [True]
    names[0, 2, 0] = 6
    assert two_rooms.kept(names, [(0, 0, 3, 5)]) == [False]
    names[1] = np.nan
    assert two_rooms.kept(names, [(0, 0, 3, 5)]) == [False]
