"""Which of two places is the target's, by their evidence and by where it was expected."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.sot.discriminative.placing import Placer
from motes.sot.discriminative.prediction import Transition
from motes.sot.discriminative.redetection import Redetection
from motes.sot.discriminative.rival import Rival

HERE, THERE = Ellipse(50.0, 50.0, 10.0, 10.0), Ellipse(90.0, 50.0, 10.0, 10.0)
FRAME = Frame(0, 0.0, np.zeros((100, 150, 3), np.uint8))


def estimate(place: Ellipse, evidence: float) -> Any:
    return SimpleNamespace(pose=place, evidence=evidence, sights={})


@pytest.mark.parametrize(
    ("here", "there", "transition", "wins"),
    [
        (1.0, 3.5, None, True),  # nothing is known of its motion
        (1.0, 3.5, Transition(50.0, 50.0, 2.0), False),  # it would be a leap
        (1.0, 3.5, Transition(50.0, 50.0, 200.0), True),  # as it may be where motion is erratic
        (1.0, 5.5, Transition(50.0, 50.0, 2.0), True),  # the evidence is clear
        (-1.0, 1.5, Transition(50.0, 50.0, 2.0), True),  # it is not where it was expected
    ],
)
def test_a_leap_needs_more_evidence_where_the_target_may_be_as_expected(
    here: float, there: float, transition: Transition | None, wins: bool
) -> None:
    localizer: Any = SimpleNamespace(localize=lambda *_: estimate(THERE, there))
    placer = Placer(localizer, Redetection())
    state: Any = SimpleNamespace(rival=Rival(HERE))
    found = placer._compare(
        np.random.default_rng(0), state, FRAME, estimate(HERE, here), np.zeros(2), [THERE],
        transition,
    )  # fmt: skip
    assert (found.look.pose == THERE) is wins
    assert found.rival.alive is not wins
