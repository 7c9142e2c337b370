"""Which of two places is the target's, by their evidence and by where it was expected."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.track import Status
from motes.sot.discriminative.localization import WindowEstimate
from motes.sot.discriminative.placing import Placer
from motes.sot.discriminative.prediction import Transition
from motes.sot.discriminative.redetection import Redetection
from motes.sot.discriminative.rival import Rival
from motes.sot.discriminative.standing import Standing

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
    state: Any = SimpleNamespace(rival=Rival(HERE), standing=Standing())
    found = placer._compare(
        np.random.default_rng(0), state, FRAME, estimate(HERE, here), np.zeros(2), [THERE],
        transition,
    )  # fmt: skip
    assert (found.look.pose == THERE) is wins
    assert found.rival.alive is not wins


@pytest.mark.parametrize("status", Status)
def test_the_first_region_is_compared_only_where_a_target_is_found_again(status: Status) -> None:
    """Half hidden or in another light, a target is still that of the frame before."""
    red, black = Ellipse(40.0, 50.0, 12.0, 8.0), Ellipse(100.0, 50.0, 12.0, 8.0)
    pixels = np.full((100, 150, 3), 120, np.uint8)
    pixels[42:59, 28:53], pixels[42:59, 88:113] = (200, 30, 30), (20, 20, 30)
    frame, search = Frame(0, 0.0, pixels), Redetection()

    def localize(*arguments: Any) -> WindowEstimate:
        (place,) = (each for each in arguments if isinstance(each, Ellipse))
        return WindowEstimate(place, *[None] * 6, place, *[None] * 3, evidence=2.0)  # type: ignore[arg-type]

    placer = Placer(SimpleNamespace(localize=localize), search)  # type: ignore[arg-type]
    appearance = search.updated(search.learn(frame, red), frame, red, 0.05)
    state: Any = SimpleNamespace(appearance=appearance, standing=Standing(status))
    rng, followed = np.random.default_rng(0), status is Status.TRACKING
    for place, alike in ((red, True), (black, False)):
        look = placer._look(rng, state, frame, place, {})
        assert (look.evidence == 2) == (followed or alike)
        again = placer._look(rng, state, frame, place, {}, elsewhere=True)
        assert again.evidence == 2 if alike else again.evidence < 0
