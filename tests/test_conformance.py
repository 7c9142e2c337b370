"""Our own cues, motion models and detectors keep the rules that others are asked to keep."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motes import Box, Config, Detection, DetectorConfig, Frame
from motes.core.types import Floats
from motes.cues.base import CUES, Cue
from motes.cues.color import Color
from motes.cues.sampling import Checkerboard, EveryPixel
from motes.cues.structure_tensor import Orientation
from motes.mot.detection.background import BackgroundConfig
from motes.mot.detection.lookalike import LookalikeConfig
from motes.sot.filtering.motion import MOTIONS, EllipseWalk, Motion
from motes.testing import check_cue, check_detector, check_motion


@pytest.mark.parametrize("name", CUES.names())
def test_cues(name: str) -> None:
    kind: Any = CUES.resolve(name)
    check_cue(kind())


@pytest.mark.parametrize(
    "cue",
    [
        Color(space="hsv+v", kernel="uniform", sampling=EveryPixel()),
        Color(sampling=Checkerboard()),
        Orientation(form="fourier"),
    ],
)
def test_variants_of_cues(cue: Cue) -> None:
    check_cue(cue)


@pytest.mark.parametrize("name", MOTIONS.names())
def test_motion_models(name: str) -> None:
    kind: Any = MOTIONS.resolve(name)
    check_motion(kind())


@pytest.mark.parametrize("config", [BackgroundConfig(), LookalikeConfig((51, 47, 40, 28))])
def test_detectors(config: DetectorConfig) -> None:
    check_detector(config)


# The checks find what is wrong.


right = Color.distances


def relative(cue: Color, model: Any, frame: Frame, ellipses: Floats) -> Floats:
    found = right(cue, model, frame, ellipses)
    return np.where(found < 1, found / len(found), 1)


def moving(cue: Color, model: Any, frame: Frame, ellipses: Floats) -> Floats:
    found = right(cue, model, frame, ellipses)
    ellipses += 1
    return found


def writing(cue: Color, model: Any, frame: Frame, ellipses: Floats) -> Floats:
    frame.pixels[0, 0] = 0
    return right(cue, model, frame, ellipses)


BROKEN: list[tuple[str, Callable[..., Any], str]] = [
    ("distances", lambda *given: np.ones(len(given[-1])), "the target itself has distance 1; 0 is"),
    ("distances", lambda *given: 9 * right(*given), "distances are from 0 to 1"),
    (
        "distances",
        lambda *given: 0.9 * right(*given),
        "ellipses outside the frame or with NaN have",
    ),
    ("distances", relative, "the distance of an ellipse depends on the others"),
    ("distances", moving, "distances changes the ellipses"),
    ("distances", lambda *given: right(*given)[:, None], "distances returns .*, not"),
    ("distances", writing, "changes the pixels of the frame"),
    ("learn", lambda *_: {"color": 3}, "learn returns a dict"),
    ("update_reading", lambda *_: (1.0, 2.0), "update_reading returns a tuple"),
]


@pytest.mark.parametrize(("method", "broken", "message"), BROKEN)
def test_cues_that_break_a_rule(
    method: str, broken: Callable[..., Any], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Color, method, broken)
    with pytest.raises(AssertionError, match=message):
        check_cue(Color())


def test_what_is_no_cue() -> None:
    motion: Any = EllipseWalk()
    with pytest.raises(AssertionError, match="EllipseWalk is not a subclass of"):
        check_cue(motion)


class Drifting(EllipseWalk, frozen=True, tag="drifting"):
    """A motion model, to be broken."""


class Untagged(Motion, Config, frozen=True):
    """A motion model that no file can name."""


walk = EllipseWalk.propagate


def shrinking(motion: EllipseWalk, rng: Any, states: Floats, dt: float, first: Any) -> Floats:
    return np.asarray(states * (1.0, 1.0, 0.5**dt, 1.0, 1.0))


def global_noise(motion: EllipseWalk, rng: Any, states: Floats, dt: float, first: Any) -> Floats:
    return walk(motion, np.random.default_rng(), states, dt, first)


def in_place(motion: EllipseWalk, rng: Any, states: Floats, dt: float, first: Any) -> Floats:
    states += dt
    return states.copy()


@pytest.mark.parametrize(
    ("broken", "message"),
    [
        (shrinking, "a half-axis has shrunk"),
        (global_noise, "a generator of the same seed gives another result"),
        (in_place, "propagate changes the states"),
    ],
)
def test_motion_models_that_break_a_rule(
    broken: Callable[..., Any], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Drifting, "propagate", broken)
    with pytest.raises(AssertionError, match=message):
        check_motion(Drifting())


def test_a_motion_model_without_a_tag() -> None:
    untagged: Any = Untagged
    with pytest.raises(AssertionError, match="Untagged has no tag"):
        check_motion(untagged())


class Everything(DetectorConfig, Config, frozen=True, tag="everything"):
    """Detectors that always find one box."""

    box: tuple[float, float, float, float] = (0.0, 0.0, 9.0, 9.0)

    def detector(self) -> Any:
        """Return the detector."""
        return lambda frame: [Detection(Box(*self.box))]


def test_a_detector_that_breaks_a_rule() -> None:
    check_detector(Everything())
    with pytest.raises(AssertionError, match="has no area"):
        check_detector(Everything((0, 0, 0, 5)))
