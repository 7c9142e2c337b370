"""A film and its keyframes become a track: stretch by stretch, forward and backward."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.track import Track
from motes.correction.join import Joined, Stretch, join
from motes.correction.keyframes import Keyframes
from motes.correction.passes import as_pass, run_pass
from motes.sot.presets import TrackerConfig


class FrameReader(Protocol):
    """Frames in any order; `motes.video.film.Film` is one."""

    def forward(self, first: int, last: int) -> Iterator[Frame]:
        """Yield the frames from `first` to `last`."""

    def backward(self, last: int, first: int) -> Iterator[Frame]:
        """Yield the frames from `last` down to `first`."""


class CorrectedTrack(Track, frozen=True, eq=False):
    """The track of a frame after smoothing.

    Where the target is absent, the ellipse is NaN.

    Attributes
    ----------
    outlier
        Whether a tracker reported a place in this frame that the other frames contradict.
    """

    outlier: bool = False


def stretches(frames: range, keys: Keyframes) -> list[Stretch]:
    """Return the stretches of the frames between neighboring keyframes, and before and after them.

    Neighboring stretches share a keyframe. Each has one at an end at least.
    """
    marked = {frame: region for frame, region in keys.items() if region is not None}
    ends: list[int] = [frames.start, *marked, frames.stop - 1]
    found = []
    for first, last in itertools.pairwise(dict.fromkeys(sorted(ends))):
        absent = frozenset(t for t in range(first, last + 1) if t in keys and keys[t] is None)
        found.append(Stretch(first, last, marked.get(first), marked.get(last), absent))
    only = next(iter(marked))
    return found or [Stretch(only, only, marked[only], None)]


def correct(film: FrameReader, stretch: Stretch, config: TrackerConfig, seed: int) -> Joined:
    """Return the track of a stretch, from passes in both directions."""
    first, last = stretch.first, stretch.last
    forward = backward = None
    if stretch.begin is not None:
        tracks = run_pass(config, seed, film.forward(first, last), stretch.begin)
        forward = as_pass(tracks)
    if stretch.end is not None:
        frames = film.backward(last, first)
        backward = as_pass(run_pass(config, seed, frames, stretch.end, backward=True))
    return join(stretch, forward, backward)


def tracks_of(stretch: Stretch, joined: Joined, times: Sequence[float]) -> list[CorrectedTrack]:
    """Return the track of each frame of a stretch; `times` has those of all frames of the film."""
    return [
        CorrectedTrack(
            frame=stretch.first + i,
            time=times[stretch.first + i],
            ellipse=Ellipse(*joined.ellipses[i].tolist()),
            covariance=np.diag(joined.variances[i]),
            confidence=float(joined.confidence[i]),
            status=joined.status[i],
            distance=float("nan"),
            effective_sample_size=float("nan"),
            outlier=bool(joined.outlier[i]),
        )
        for i in range(stretch.last - stretch.first + 1)
    ]
