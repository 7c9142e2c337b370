"""Saved trackers, and ways to break them: `mutate` one, and `check` that nobody is harmed."""

import random
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from motes import FormatError, Frame, KnownTarget, ParticleFilter, Tracker
from motes.cues.color import Color, Posterior
from motes.cues.correlation_filter import Correlation
from motes.cues.gradients import Edges, Hog
from motes.cues.structure_tensor import Orientation
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.motion import SecondOrder
from motes.sot.filtering.resampling import KldSampling
from motes.sot.presets import PRESETS, TrackerConfig, configure
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


def mutate(rng: random.Random, saved: bytes) -> bytes:
    """Return a saved tracker with some bytes changed, or its end cut off."""
    if not rng.randrange(3):
        return saved[: rng.randrange(len(saved))]
    data = bytearray(saved)
    for _ in range(rng.choice((1, 1, 2, 20))):
        # Most bytes are pixels: half of the changes are where the configuration is.
        end = len(data) if rng.random() < 0.5 else min(len(data), 3000)
        data[rng.randrange(end)] = rng.randrange(256)
    return bytes(data)


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
    for index in range(20, 23):
        assert np.isfinite(tracker.update(_picture(index)).ellipse).all()
    return "followed"
