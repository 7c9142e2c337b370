"""Saved trackers, and ways to break them: `mutate` one, and `check` that nobody is harmed.

`python broken_states.py SEED COUNT` checks so many; any harm ends it, by an exception or a signal.
"""

from __future__ import annotations

import faulthandler
import math
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from msgspec.structs import replace

from motes.core.errors import FormatError
from motes.core.frame import Frame
from motes.cues.color import Color
from motes.cues.color_posterior import Posterior
from motes.cues.correlation_filter import Correlation
from motes.cues.gradients import Edges, Hog
from motes.cues.structure_tensor import Orientation
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.motion import SecondOrder
from motes.sot.filtering.resampling import KldSampling
from motes.sot.known_target import KnownTarget
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import PRESETS, TrackerConfig, configure
from motes.sot.tracker import Tracker
from oracles import region, scene

ALL = ParticleFilter(
    particles=20,
    color=Color(bins=(4, 4, 4)),
    orientation=Orientation(),
    edges=Edges(),
    hog=Hog(),
    correlation=Correlation(),
    posterior=Posterior(),
    presence=AppearanceRule(max_positions=50),
    budget=KldSampling(min=10, max=40),
)
KALMAN, GAUSSIAN = {"type": "kalman", "frames": 2}, {"type": "gaussian"}
FORGETTING = {"type": "forgetting", "learning_rate": 0.1}
BY_CUE = {"type": "per_cue", "cues": {"color": KALMAN, "hog": GAUSSIAN, "edges": FORGETTING}}
CONFIGS: dict[str, TrackerConfig] = {
    **PRESETS,
    "all": configure(ALL, {"adaptation": FORGETTING}),
    "all, kalman": configure(ALL, {"adaptation": KALMAN, "fusion": {"type": "fixed"}}),
    "all, gaussian": configure(ALL, {"adaptation": GAUSSIAN, "motion": {"type": "ellipse_walk"}}),
    "all, by cue": configure(ALL, {"adaptation": BY_CUE, "motion": {"type": "autoregressive"}}),
    "all, fourier": configure(
        ALL, {"orientation": {"form": "fourier"}, "motion": {"type": "random_walk"}}
    ),
    "all, second order": replace(ALL, motion=SecondOrder(), budget=None),
}
MOMENTS = ("started", "tracking", "lost", "searching")
EXAMPLES = [
    (name, moment)
    for name, config in CONFIGS.items()
    for moment in MOMENTS
    if moment != "searching" or (list(config.cues) == ["color"] and "mean" not in name)
]
"""A configuration, and when its tracker was saved."""
ABSURD = (math.nan, math.inf, -math.inf, 1e300, -1e300, 1e13, 9e11, -9e11, 1e-300)
NUMBERS = (*ABSURD, -1.0, 0.0, 0.3, 2.0)
OTHERS: tuple[Any, ...] = (None, True, "x", "", b"x", [], {}, [[[]]])
PLAIN = (*NUMBERS, *OTHERS, -1, 0, 7, 1 << 63, (1 << 64) - 1)
DTYPES = ("<f8", "<f4", "<c8", "<i8", "|u1", ">f8", "|O", "<U9", "|V0", "f8,(", "", "((", "<M8[D]")


def _picture(index: int, *, there: bool = True) -> Frame:
    return scene(index, (30.0 + index, 36) if there else None)


@cache
def example(name: str, moment: str) -> bytes:
    """Return a saved tracker."""
    config, tracker = CONFIGS[name], Tracker(CONFIGS[name], 3)
    target = region((30, 36))
    if moment == "searching":
        assert isinstance(config, ParticleFilter)
        assert config.color is not None
        known = KnownTarget.learn(config.color, _picture(0), target)
        tracker.search(_picture(0, there=False), known)
    else:
        tracker.init(_picture(0), target)
    for index in range(1, {"started": 1, "tracking": 5, "lost": 12, "searching": 3}[moment]):
        tracker.update(_picture(index, there=moment == "tracking"))
    return _saved(tracker)


def _saved(tracker: Tracker) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        tracker.save(Path(folder, "tracker"))
        return Path(folder, "tracker").read_bytes()


def places(value: Any, where: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the keys that lead to each part of what is saved; an array is one part."""
    yield where
    if isinstance(value, dict) or (isinstance(value, list) and not is_array(value)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from places(value[key], (*where, key))


def is_array(value: Any) -> bool:
    """Tell whether a part is an array, as [dtype, shape, bytes]."""
    return isinstance(value, list) and len(value) == 3 and isinstance(value[2], bytes)


def part(value: Any, where: tuple[Any, ...]) -> Any:
    """Return the part to which keys lead."""
    for key in where:
        value = value[key]
    return value


def changed(saved: bytes, where: tuple[Any, ...], value: Any) -> bytes:
    """Return a saved tracker with another value somewhere."""
    whole = msgspec.msgpack.decode(saved)
    if not where:
        return msgspec.msgpack.encode(value)
    part(whole, where[:-1])[where[-1]] = value
    return msgspec.msgpack.encode(whole)


def broken_arrays(packed: list[Any]) -> Iterator[list[Any]]:
    """Yield what may become of an array: other shapes, types and numbers, in one place and all."""
    array = np.frombuffer(packed[2], packed[0]).reshape(packed[1])
    half = [slice(0, n // 2) for n in array.shape]
    shaped = [array.ravel(), array[None], array[..., None], array.T, array[:0], array[..., :0]]
    shaped += [array[tuple(half)], np.concatenate([array, array])]
    shaped += [array[tuple(half[:axis])] for axis in range(1, array.ndim)]
    filled = []
    with np.errstate(all="ignore"):
        typed = [array.real.astype(dtype) for dtype in ("f4", "f8", "i8", "u1", "c8", "i4")]
        for number in NUMBERS if array.dtype.kind != "u" else (0, 255):
            filled.append(np.full_like(array, number))
            filled.append(array.copy())
            filled[-1].ravel()[array.size // 3 : array.size // 3 + 1] = filled[-2].ravel()[:1]
    for other in shaped + typed + filled:
        yield [other.dtype.str, list(other.shape), np.ascontiguousarray(other).tobytes()]
    for dtype in DTYPES:
        yield [dtype, *packed[1:]]
    for shape in ([], [0], [-1], [1 << 40, 0], [1 << 62, 4], [0, 1 << 62], "x", [1.5], None):
        yield [packed[0], shape, packed[2]]
        yield [packed[0], shape, b""]


def every_broken_array(saved: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield a tracker with each of its arrays broken in each way, with the array's name."""
    whole = msgspec.msgpack.decode(saved)
    for where in places(whole):
        if is_array(part(whole, where)):
            for broken in broken_arrays(part(whole, where)):
                yield ".".join(map(str, where)), changed(saved, where, broken)


def with_other_bytes(rng: random.Random, saved: bytes) -> bytes:
    """Return a saved tracker with one byte changed, or some."""
    data = bytearray(saved)
    for _ in range(rng.choice((1, 1, 2, 20))):
        # Most bytes are pixels: half of the changes are where the configuration is.
        end = len(data) if rng.random() < 0.5 else min(len(data), 3000)
        data[rng.randrange(end)] = rng.randrange(256)
    return bytes(data)


def mutate(rng: random.Random, saved: bytes) -> bytes:
    """Return a saved tracker broken somewhere: its bytes, an array, a value, or as a tree."""
    way = rng.randrange(6)
    if way == 0:
        return with_other_bytes(rng, saved)
    if way == 1:
        first, last = sorted(rng.randrange(len(saved) + 1) for _ in "12")
        return saved[:first] + rng.choice((b"", saved[first:last] * 2)) + saved[last:]
    whole = msgspec.msgpack.decode(saved)
    everywhere = list(places(whole))
    if way in (2, 3):
        where = rng.choice([where for where in everywhere if is_array(part(whole, where))])
        return changed(saved, where, rng.choice(list(broken_arrays(part(whole, where)))))
    where = rng.choice([where for where in everywhere if where and where[0] == "state"])
    if way == 4:
        where = rng.choice([where, rng.choice(everywhere)])
        deep: list[Any] = []
        for _ in range(rng.choice((3, 300, 3000))):
            deep = [deep]
        try:
            return changed(saved, where, rng.choice((*PLAIN, deep)))
        except RecursionError:  # our own, of writing it
            return b"\x91" * 100_000
    other = msgspec.msgpack.decode(example(*rng.choice(EXAMPLES)))
    own, its = part(whole, where[:1]), other[rng.choice(("state", "config", "random"))]
    if isinstance(part(whole, where), dict) and part(whole, where) and rng.random() < 0.5:
        where = (*where, rng.choice(list(part(whole, where))))
        own = part(whole, where[:-1])
        value = own.pop(where[-1])
        if rng.random() < 0.5:  # under another name, or at another place
            own[rng.choice(("color", "hog", "x", where[-1]))] = value
        return msgspec.msgpack.encode(whole)
    if rng.random() < 0.5:
        return msgspec.msgpack.encode({**whole, "config": other["config"]})
    return changed(saved, where[:1] if rng.random() < 0.5 else where, its)


def check(data: bytes) -> str:
    """Return `refused`, or `followed` if the tracker goes on; else raise an AssertionError.

    Anything else that is raised is harm too.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "tracker")
        path.write_bytes(data)
        try:
            tracker = Tracker.load(path)
        except FormatError as error:
            return "refused" if "\n" not in str(error) else f"refused in several lines: {error}"
    assert tracker._frame is not None
    shape = tracker._frame.pixels.shape
    for index in range(5, 8):
        pixels = _picture(index).pixels
        track = tracker.update(np.resize(pixels, shape))
        numbers = np.array([*track.ellipse, *track.box, track.confidence, track.distance])
        for values in (numbers, track.covariance, tracker.info.weights, tracker.info.ellipses):
            assert np.isfinite(values).all(), f"not finite: {values}"
        assert min(track.ellipse.a, track.ellipse.b) > 0, track.ellipse
    return "followed"


def main(seed: int, count: int) -> None:
    """Check so many mutations, spread over all examples; print how many were refused."""
    faulthandler.enable()
    rng, outcomes = random.Random(seed), Counter[str]()
    for _ in range(count):
        name, moment = rng.choice(EXAMPLES)
        data = mutate(rng, example(name, moment))
        try:
            outcomes[check(data)] += 1
        except BaseException:
            with tempfile.NamedTemporaryFile(suffix=".tracker", delete=False) as file:
                file.write(data)
            print(f"{name}, {moment}: {file.name}", file=sys.stderr)
            raise
    print(*(f"{outcome}: {number}" for outcome, number in sorted(outcomes.items())))


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
