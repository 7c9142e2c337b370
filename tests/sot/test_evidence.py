"""What the near window says of a place, and the probability of log odds."""

from __future__ import annotations

import math

import pytest

from motes.sot.discriminative.expert import Evidence, probability


@pytest.mark.parametrize("voice", ["gradients", "contrast"])
def test_each_voice_speaks_for_the_target(voice: str) -> None:
    said = {"gradients": 0.5, "contrast": 0.5}
    less, more = (said | {voice: value} for value in (0.2, 0.4))
    gained = Evidence().log_odds(**more) - Evidence().log_odds(**less)
    assert gained == pytest.approx(0.2 * getattr(Evidence(), voice))
    mute = Evidence(**{voice: 0.0})
    assert mute.log_odds(**more) == mute.log_odds(**less)


def test_probabilities_of_log_odds() -> None:
    assert probability(0.0) == 0.5
    assert probability(math.log(3)) == pytest.approx(0.75)
    assert 0 < probability(-1e9) < 1e-12 < 1 - 1e-12 < probability(1e9) <= 1
