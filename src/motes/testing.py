"""Checks that a cue, an expert, a motion model or a detector keeps the rules of its interface.

They are for the tests of packages that extend motes. Each raises an AssertionError that names the
broken rule. They do not need pytest.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

import msgspec
import numpy as np

from motes.core.config import Config, from_dict
from motes.core.detection import Detection, DetectorConfig
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box, Ellipse
from motes.core.registry import tag_of
from motes.core.saved_state import pack, unpack
from motes.core.types import Bytes, Floats
from motes.cues.base import AdaptableCue, Cue
from motes.cues.color import Color
from motes.sot.discriminative.expert import Expert
from motes.sot.discriminative.tracker import Discriminative
from motes.sot.filtering.motion import Motion
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import TrackerConfig
from motes.sot.tracker import Tracker

__all__ = ["check_cue", "check_detector", "check_expert", "check_motion"]

WIDTH, HEIGHT = 200, 150
TARGET = Ellipse(70.0, 60.0, 20.0, 14.0, 0.0)
"""The target in the rendered frames: bright stripes on darker, dappled ground."""
NONE = np.array(
    [
        [70 + 1000.0, 60, 20, 14, 0],
        [70, -1e6, 20, 14, 0],
        *(np.where(np.arange(5) == i, np.nan, TARGET) for i in range(5)),
        [np.inf, 60, 20, 14, 0],
    ]
)
"""Ellipses (N, 5) outside the frame, or with NaN or infinity."""


def check_cue(cue: Cue) -> None:
    """Check that a cue keeps the rules of `motes.cues.Cue`.

    Raises
    ------
    AssertionError
        If it breaks a rule; the message names the rule.
    """
    _check_config(cue, Cue)
    frame, ellipses = _frame(), _places()
    before = frame.pixels.copy()
    model = cue.learn(frame, TARGET)
    kind = type(model)
    frozen = isinstance(model, msgspec.Struct) and kind.__struct_config__.frozen
    assert frozen, f"learn returns a {kind.__name__}; a model is a frozen msgspec.Struct"
    packed = _packed(model)
    distances = _distances(cue, model, frame, ellipses)
    assert distances[0] < 0.5, f"the target itself has distance {distances[0]:.3g}; 0 is the same"
    nearest = float(distances[1:].min())
    assert distances[0] < nearest, (
        f"another place has distance {nearest:.3g}, the target itself {distances[0]:.3g}"
    )
    again = _distances(cue, cue.learn(_frame(), TARGET), _frame(), ellipses)
    assert np.array_equal(distances, again), "the same frame gives other distances next time"
    alone = [_distances(cue, model, frame, row[None])[0] for row in ellipses]
    assert np.array_equal(distances, alone), "the distance of an ellipse depends on the others"
    outside = _distances(cue, model, frame, NONE)
    assert (outside == 1).all(), (
        f"ellipses outside the frame or with NaN have distances {outside}, not 1"
    )
    with ThreadPoolExecutor(4) as pool:
        parts = pool.map(partial(cue.distances, model, frame), np.array_split(ellipses, 4))
        together = np.concatenate(list(parts))
    assert np.array_equal(distances, together), "threads at the same time give other distances"
    for pixels in (np.full((HEIGHT, WIDTH, 3), 128, np.uint8), frame.pixels[:8, :8]):
        _distances(cue, model, Frame(0, 0.0, pixels), ellipses)
    _check_learning(cue, model, frame)
    assert np.array_equal(frame.pixels, before), "a method changes the pixels of the frame"
    assert _packed(model) == packed, "a method changes the model that it is given"
    _check_saving(cue, model, frame)
    config = ParticleFilter(particles=50, color=Color(), extra_cues={"checked": cue})
    _check_tracking(config)  # fused with color


def check_expert(expert: Expert) -> None:
    """Check that an expert keeps the rules of `motes.filtering.Expert`.

    Raises
    ------
    AssertionError
        If it breaks a rule; the message names the rule.
    """
    _check_config(expert, Expert)
    frame = _frame()
    before = frame.pixels.copy()
    model = expert.learn(frame, TARGET)
    frozen = isinstance(model, msgspec.Struct) and type(model).__struct_config__.frozen
    assert frozen, f"learn returns a {type(model).__name__}; a model is a frozen msgspec.Struct"
    packed = _packed(model)
    sight = expert.look(model, frame, TARGET)
    assert expert.serves(sight, TARGET), "a sight does not serve the place that was looked at"
    here = expert.log_odds(sight, TARGET)
    for x, y, *_ in _places()[1:].tolist():
        place = TARGET._replace(x=x, y=y)
        seen = sight if expert.serves(sight, place) else expert.look(model, frame, place)
        there = expert.log_odds(seen, place)
        assert np.isfinite(there), f"log_odds returns {there}"
        assert there <= here, (
            f"another place has log odds of {there:.3g}, the target itself {here:.3g}"
        )
    again = expert.look(expert.learn(_frame(), TARGET), _frame(), TARGET)
    assert expert.log_odds(again, TARGET) == here, "the same frame gives other log odds next time"
    for share in (0.0, 0.5, 1.0):
        after = expert.updated(model, frame, sight, TARGET, share)
        assert type(after) is type(model), f"updated returns a {type(after).__name__}"
    assert np.array_equal(frame.pixels, before), "a method changes the pixels of the frame"
    assert _packed(model) == packed, "a method changes the model that it is given"
    read = msgspec.convert(msgspec.msgpack.decode(packed), type(model), dec_hook=unpack)
    same = expert.log_odds(expert.look(read, frame, TARGET), TARGET)
    assert same == here, "a model that was saved gives other log odds"
    _check_tracking(Discriminative(extra_experts={"checked": expert}))


def check_motion(motion: Motion) -> None:
    """Check that a motion model keeps the rules of `motes.filtering.Motion`.

    Raises
    ------
    AssertionError
        If it breaks a rule; the message names the rule.
    """
    _check_config(motion, Motion, tagged=True)
    rng = np.random.default_rng(0)
    given = rng.uniform((20, 20, 20, 3, -1), (200, 200, 30, 20, 1), (40, 5))
    kept = given.copy()
    states = motion.initial(given)
    matrix = states.ndim == 2 and len(states) == len(given)
    assert matrix, f"initial has shape {states.shape}, not (N, d)"
    ellipses = motion.ellipses(states)
    assert ellipses.shape == (40, 5), f"ellipses has shape {ellipses.shape}, not (N, 5)"
    assert np.allclose(ellipses, given), "ellipses(initial(...)) does not return the given ellipses"

    def moved(seed: int, dt: float = FRAME_INTERVAL) -> Floats:
        return motion.propagate(np.random.default_rng(seed), states, dt, TARGET)

    start = states.copy()
    first = moved(1)
    assert np.array_equal(start, states), "propagate changes the states that it is given"
    assert first.shape == states.shape, (
        f"propagate returns shape {first.shape} for states of shape {states.shape}"
    )
    assert np.array_equal(first, moved(1)), "a generator of the same seed gives another result"
    assert np.allclose(moved(1, 0.0), states), "propagate changes states over 0 seconds"
    states[:] = 0.0
    assert np.array_equal(kept, given), "initial returns its argument, or changes it"
    states = motion.initial(np.tile([5.0, 5.0, 1.2, 1.1, 0.0], (500, 1)))
    for dt in (FRAME_INTERVAL, FRAME_INTERVAL, 1e-9, 1.0, 60.0, 3600.0):
        states = motion.propagate(rng, states, dt, TARGET)
        assert np.isfinite(states).all(), (
            f"propagate over {dt:g} s returns states that are not finite"
        )
        smallest = float(motion.ellipses(states)[:, 2:4].min())
        assert smallest >= 1, f"a half-axis has shrunk to {smallest:g} pixels; 1 is the least"


def check_detector(config: DetectorConfig) -> None:
    """Check that a detector and its settings keep the rules of `motes.DetectorConfig`.

    Raises
    ------
    AssertionError
        If it breaks a rule; the message names the rule.
    """
    _check_config(config, DetectorConfig, tagged=True)
    detector = config.detector()
    tiny = Frame(0, 0.0, np.zeros((2, 2, 3), np.uint8))
    for frame in (*(_frame(i) for i in range(4)), tiny):
        before = frame.pixels.copy()
        found = detector(frame)
        assert np.array_equal(frame.pixels, before), "the detector changes the pixels of the frame"
        for each in found:
            assert isinstance(each, Detection), f"the detector returns a {type(each).__name__}"
            assert isinstance(each.box, Box), (
                f"the box of a detection is {each.box!r}; it must be a Box"
            )
            assert np.isfinite([*each.box, each.score]).all(), (
                f"{each} holds a number that is not finite"
            )
            assert min(each.box[2:]) > 0, f"{each} has no area"
        if frame is tiny:
            break
    first, second = (_seen(config.detector()) for _ in range(2))
    assert first == second, "two detectors find different objects in the same frames"


def _seen(detector: Callable[[Frame], Any]) -> list[list[Detection]]:
    return [list(detector(_frame(i))) for i in range(3)]


def _check_config(config: Any, base: type, *, tagged: bool = False) -> None:
    """Check the rules for every configuration."""
    kind = type(config)
    path = f"{base.__module__}.{base.__qualname__}"
    assert isinstance(config, base), f"{kind.__name__} is not a subclass of {path}"
    assert isinstance(config, Config), (
        f"{kind.__name__} is not a subclass of motes.core.config.Config"
    )
    assert kind.__struct_config__.frozen, f"{kind.__name__} is not frozen; write frozen=True"
    assert not tagged or isinstance(tag_of(kind), str), f"{kind.__name__} has no tag; write tag=..."
    plain = msgspec.json.decode(msgspec.json.encode(config.to_dict()))
    again = from_dict(plain, kind)
    assert again == config, f"{config} comes back from a file as {again}"


def _check_learning(cue: Cue, model: Any, frame: Frame) -> None:
    """Check the update of a cue's model in a frame in which the target is found."""
    after = cue.update_reading(model, frame, TARGET)
    assert type(after) is type(model), f"update_reading returns a {type(after).__name__}"
    distance = _distances(cue, after, frame, np.array([TARGET]))[0]
    assert distance < 0.5, f"after update_reading, the target has distance {distance:.3g}"
    if not isinstance(cue, AdaptableCue):
        return
    for name in ("histogram", "anchor"):
        assert hasattr(model, name), f"the model of an AdaptableCue has no field {name}"
    seen = cue.observe(model, frame, TARGET)
    assert seen.shape == model.histogram.shape, (
        f"observe returns {seen.shape}, the model's histogram is {model.histogram.shape}"
    )
    for histogram in (seen, model.histogram):
        assert histogram.min() >= 0, f"a histogram holds {histogram.min():g}"
        assert abs(histogram.sum() - 1) < 1e-6, f"a histogram sums to {histogram.sum():g}, not 1"
    nothing = cue.observe(model, frame, TARGET._replace(x=1e4))
    assert not nothing.any(), "observe returns no zeros outside the frame"


def _check_saving(cue: Cue, model: Any, frame: Frame) -> None:
    """Check that a model can be saved and read again."""
    read = msgspec.convert(msgspec.msgpack.decode(_packed(model)), type(model), dec_hook=unpack)
    its, same = (cue.distances(each, frame, _places()) for each in (read, model))
    assert np.array_equal(its, same), "a model that was saved gives other distances"


def _check_tracking(config: TrackerConfig) -> None:
    """Check that a tracker with what is checked follows a target."""
    tracker = Tracker(config)
    tracker.init(_frame(), TARGET)
    for index in range(1, 4):
        track = tracker.update(_frame(index))
        assert np.isfinite(track.ellipse).all(), f"tracking with it ends at {track.ellipse}"


def _distances(cue: Cue, model: Any, frame: Frame, ellipses: Floats) -> Floats:
    """Return distances, after checks that hold for every cue and model."""
    before = ellipses.copy()
    found = cue.distances(model, frame, ellipses)
    assert np.array_equal(ellipses, before, equal_nan=True), "distances changes the ellipses"
    assert found.shape == (len(ellipses),), f"distances returns {found.shape}, not (N,)"
    assert found.dtype == np.float64, f"distances returns {found.dtype}, not float64"
    assert ((found >= 0) & (found <= 1)).all(), f"distances are from 0 to 1; got {found}"
    return found


def _packed(model: Any) -> bytes:
    return msgspec.msgpack.encode(model, enc_hook=pack)


def _places() -> Floats:
    """Return ellipses (N, 5): the target, then others of its size that do not overlap it."""
    y, x = np.mgrid[20:HEIGHT:30, 25:WIDTH:50]
    away = (abs(x - TARGET.x) > 2 * TARGET.a) | (abs(y - TARGET.y) > 2 * TARGET.b)
    ellipses = np.tile(np.array(TARGET), (1 + int(np.count_nonzero(away)), 1))
    ellipses[1:, 0], ellipses[1:, 1] = x[away], y[away]
    return ellipses


def _frame(index: int = 0) -> Frame:
    """Return a frame with the target, two pixels farther to the right in each frame."""
    y, x = np.mgrid[:HEIGHT, :WIDTH].astype(np.float64)
    pixels: Bytes = np.random.default_rng(5).integers(40, 90, (HEIGHT, WIDTH, 3)).astype(np.uint8)
    pixels[..., 1] += np.uint8(40)
    inside = (abs(x - TARGET.x - 2 * index) <= TARGET.a) & (abs(y - TARGET.y) <= TARGET.b)
    stripes = np.sin((x - 2 * index + y) / 2) > 0
    pixels[inside & stripes] = (250, 200, 60)
    pixels[inside & ~stripes] = (160, 20, 90)
    return Frame(index, index * FRAME_INTERVAL, pixels)
