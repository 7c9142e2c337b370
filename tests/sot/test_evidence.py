"""The evidence of several experts, added up."""

from __future__ import annotations

import math

import pytest

from motes.sot.discriminative.evidence import Evidence, Voices, probability

TARGET = Voices(gradients=0.5, contrast=0.5, confined=0.7, colors=0.3)
NOTHING = Voices(gradients=0.0, contrast=0.0, confined=0.0, colors=1.0)


def test_a_target_is_likely_and_an_empty_place_is_not() -> None:
    assert probability(Evidence().log_odds(TARGET)) > 0.9
    assert probability(Evidence().log_odds(NOTHING)) < 0.02


@pytest.mark.parametrize("voice", ["gradients", "contrast", "confined"])
def test_each_voice_speaks_for_the_target(voice: str) -> None:
    less, more = (TARGET._replace(**{voice: value}) for value in (0.2, 0.4))
    gained = Evidence().log_odds(more) - Evidence().log_odds(less)
    assert gained == pytest.approx(0.2 * getattr(Evidence(), voice))
    assert Evidence(**{voice: 0.0}).log_odds(more) == Evidence(**{voice: 0.0}).log_odds(less)


def test_colors_that_differ_speak_against_it_up_to_a_limit() -> None:
    near, far, farther = (TARGET._replace(colors=value) for value in (0.2, 0.6, 0.9))
    assert Evidence().log_odds(near) - Evidence().log_odds(far) == pytest.approx(0.4 * 3.75)
    assert Evidence().log_odds(farther) == Evidence().log_odds(far)


@pytest.mark.parametrize("voice", ["gradients", "contrast", "confined"])
def test_no_voice_can_veto_the_others(voice: str) -> None:
    """A gray target has no color contrast, and a turned one no likeness to the first frame."""
    sure = Voices(gradients=0.7, contrast=0.5, confined=1.0, colors=0.2)
    assert Evidence().log_odds(sure._replace(**{voice: 0.0})) > 0


def test_a_voice_is_not_louder_than_its_limit() -> None:
    loud, louder = (TARGET._replace(confined=value) for value in (1.5, 20.0))
    assert Evidence().log_odds(loud) == Evidence().log_odds(louder)


def test_probabilities_of_log_odds() -> None:
    assert probability(0.0) == 0.5
    assert probability(math.log(3)) == pytest.approx(0.75)
    assert 0 < probability(-1e9) < 1e-12 < 1 - 1e-12 < probability(1e9) <= 1
