"""Which of two places is the target's, by their evidence and by where it was expected."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.sot.discriminative import placing
from motes.sot.discriminative.localization import WindowEstimate
from motes.sot.discriminative.placing import Found
from motes.sot.discriminative.prediction import Transition
from motes.sot.discriminative.redetection import Redetection
from motes.sot.discriminative.standing import Rival, Standing
from motes.sot.discriminative.tracker import Discriminative

HERE, THERE = Ellipse(50.0, 50.0, 10.0, 10.0), Ellipse(90.0, 50.0, 10.0, 10.0)
FRAME = Frame(0, 0.0, np.zeros((100, 150, 3), np.uint8))


def estimate(place: Ellipse, evidence: float) -> Any:
    return SimpleNamespace(pose=place, evidence=evidence, sights={})


@pytest.mark.parametrize(
    ("here", "there", "transition", "wins"),
    [
        (1.0, 2.5, None, True),  # nothing is known of its motion
        (1.0, 2.5, Transition(50.0, 50.0, 2.0), False),  # it would be a leap
        (1.0, 2.5, Transition(50.0, 50.0, 200.0), True),  # as it may be where motion is erratic
        (1.0, 4.5, Transition(50.0, 50.0, 2.0), True),  # the evidence is clear
        (-1.0, 1.5, Transition(50.0, 50.0, 2.0), True),  # it is not where it was expected
    ],
)
def test_a_leap_needs_more_evidence_where_the_target_may_be_as_expected(
    here: float,
    there: float,
    transition: Transition | None,
    wins: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(placing, "localize", lambda *_: estimate(THERE, there))
    state: Any = SimpleNamespace(rival=Rival(HERE))
    found = placing._compare(
        Discriminative(), np.random.default_rng(0), state, FRAME, estimate(HERE, here),
        np.zeros(2), [THERE], transition,
    )  # fmt: skip
    assert (found.look.pose == THERE) is wins
    assert found.rival.alive is not wins


def test_the_search_finds_what_looks_like_the_first_region(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two cars of one shape, as likely by all other voices; the red one was there first."""
    red, black = Ellipse(40.0, 50.0, 12.0, 8.0), Ellipse(100.0, 50.0, 12.0, 8.0)
    pixels = np.full((100, 150, 3), 120, np.uint8)
    pixels[42:59, 28:53], pixels[42:59, 88:113] = (200, 30, 30), (20, 20, 30)
    frame, redetection = Frame(0, 0.0, pixels), Redetection()
    appearance = redetection.updated(redetection.learn(frame, red), frame, red, 0.05)
    lost: Any = SimpleNamespace(
        appearance=appearance,
        search_particles=np.empty((0, 5)),
        ellipse=black,
        standing=Standing(missed=5),
    )

    def seen(place: Ellipse, evidence: float) -> Any:
        return WindowEstimate(place, *[None] * 6, place, *[None] * 3, evidence)  # type: ignore

    for there, clear in ((red, True), (black, False)):
        monkeypatch.setattr(placing, "localize", lambda *_, there=there: seen(there, 2.0))
        config = Discriminative(particles=100, redetection=redetection)
        before = Found(seen(HERE, -1.0), Rival(HERE))
        found = placing.search(config, np.random.default_rng(0), lost, frame, before)
        assert found.jumped is clear
        assert found.look.pose == (red if clear else HERE)
