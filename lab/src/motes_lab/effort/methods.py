"""From keyframes to a region in every frame: with a tracker, or by interpolation."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from motes import Box, Ellipse, Track, TrackerConfig
from motes.core import Floats, as_ellipse
from motes.correction import (
    Coordinates,
    Course,
    Stretch,
    passes_over,
    run_pass,
    shared_variance,
)
from motes.video import FrameReader

Keyframes = Mapping[int, Box | Ellipse | None]
"""The target's region in each marked frame; None where it is absent."""
UNSEEN_STEP = (0.1, 0.1, 0.02, 0.02)
"""Standard deviation of the motion in a frame, in sides and logarithms of sizes, that interpolation
assumes as long as there is one keyframe."""


class Path(NamedTuple):
    """A region for each frame: ellipses and variances (n, 5), and confidences (n,)."""

    ellipses: Floats
    variances: Floats
    confidence: Floats

    @property
    def boxes(self) -> Floats:
        """The boxes around the regions, (n, 4)."""
        return np.array([Ellipse(*row).box for row in self.ellipses.tolist()])


class Film:
    """A film, its tracker, and the passes that are known.

    Parameters
    ----------
    frames
        The frames.
    used
        The frames that are annotated.
    config, seed
        The tracker.
    """

    def __init__(
        self, frames: FrameReader, used: range, config: TrackerConfig, seed: int = 0
    ) -> None:
        self.used = used
        self._frames, self._config, self._seed = frames, config, seed
        self._passes: dict[int, list[Track]] = {}
        self._joined: dict[Stretch, Course] = {}

    def forward(self, key: int, region: Ellipse, last: int) -> Course:
        """Return the pass from a keyframe to a frame; part of an earlier pass if it is known."""
        known, count = self._passes.get(key, []), last - key + 1
        if len(known) < count:
            frames = self._frames.forward(key, last)
            known = self._passes[key] = run_pass(self._config, self._seed, frames, region)
        return Course.of(known[:count])

    def joined(self, stretch: Stretch) -> Course:
        """Return the smoothed track of a stretch."""
        if stretch not in self._joined:
            passes = passes_over(self._frames, stretch, self._config, self._seed)
            self._joined[stretch] = stretch.course(*passes)
        return self._joined[stretch]


def smoothed(film: Film, keys: Keyframes) -> Path:
    """Return the track from passes in both directions between keyframes."""
    parts = [(each, film.joined(each)) for each in Stretch.between(film.used, keys)]
    values = (
        np.concatenate([parts[0][1][i][:1], *(part[i][1:] for _, part in parts)]) for i in (0, 1, 2)
    )
    return Path(*values)  # neighboring stretches share a frame


def forward_only(film: Film, keys: Keyframes) -> Path:
    """Return the track of a tracker that is started anew at each keyframe."""
    marked = _marked(keys)
    paths = []
    for (key, region), following in zip(
        marked.items(), [*list(marked)[1:], film.used.stop], strict=True
    ):
        each = film.forward(key, region, following - 1)
        space = Coordinates.of([region], each.ellipses)
        drift = 2 * shared_variance(following - key, [0])
        variances = space.ellipses(space.values(each.ellipses), drift[:, : space.dimensions])[1]
        confidence = each.confidence.copy()
        confidence[0] = 1.0
        paths.append(Path(each.ellipses, variances, confidence))
    return Path(*(np.concatenate(values) for values in zip(*paths, strict=True)))


def interpolated(film: Film, keys: Keyframes) -> Path:
    """Return boxes between keyframes by linear interpolation; the last one is held to the end.

    This is what annotation tools do. The variance is that of a Brownian bridge, with the motion
    that the keyframes show.
    """
    marked = _marked(keys)
    times, frames = np.array(list(marked)), np.array(film.used)
    ellipses = np.array([*marked.values()])
    space = Coordinates.of([*marked.values()], ellipses)
    values = space.values(ellipses)[:, :4]
    steps = np.diff(values, axis=0) ** 2 / np.diff(times)[:, None]
    rate = (steps.sum(axis=0) + np.square(UNSEEN_STEP)) / (len(steps) + 1)
    path = np.stack([np.interp(frames, times, column) for column in ellipses.T], axis=1)
    before = times[np.searchsorted(times, frames, side="right") - 1]
    after = np.append(times, -1)[np.searchsorted(times, frames)]
    bridge = (after - frames) / np.maximum(after - before, 1)
    share = np.where(after < 0, 1.0, bridge)  # after the last keyframe, no other one holds the path
    spread = ((frames - before) * share)[:, None] * rate
    variances = np.zeros_like(path)
    variances[:, :2] = spread[:, :2] * space.side**2
    variances[:, 2:4] = spread[:, 2:] * path[:, 2:4] ** 2
    return Path(path, variances, np.ones(len(frames)))


Method = Callable[[Film, Keyframes], Path]
METHODS: dict[str, Method] = {
    "motes smoothed": smoothed,
    "motes forward": forward_only,
    "interpolation": interpolated,
}


def _marked(keys: Keyframes) -> dict[int, Ellipse]:
    return {frame: as_ellipse(region) for frame, region in keys.items() if region is not None}


def equidistant(used: range, count: int) -> list[int]:
    """Return the first frame and as many more, at equal distances up to the last one."""
    places = np.linspace(used.start, used.stop - 1, count + 1).round().astype(int)
    return list(dict.fromkeys(itertools.chain([used.start], places.tolist())))
