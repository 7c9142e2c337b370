"""A film and its keyframes become a track: stretch by stretch, forward and backward."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.correction.coordinates import variances_told
from motes.correction.join import HALF, Stretch, fuse, join, tracked
from motes.correction.keyframes import Keyframes, Marks, check_keyframes, keyframes_in
from motes.correction.passes import Course, run_pass
from motes.sot.presets import TrackerConfig, preset
from motes.sot.step_info import StepInfo
from motes.video.film import Film
from motes.video.frame_sharing import FrameReader, shared


def correct(
    source: str | Path,
    marks: Marks,
    config: str | TrackerConfig = "default",
    seed: int = 0,
    fps: float | None = None,
) -> list[Track]:
    """Track a target between keyframes, forward and backward, and smooth the result.

    Parameters
    ----------
    source
        A video file or images.
    marks
        The keyframes: the target's box (x, y, w, h) or ellipse (x, y, a, b, theta) in a frame, or
        None for a frame without the target. One is enough.
    config, seed
        The tracker, as in `Tracker`.
    fps
        Frames per second of images, as in `open_source`.

    Returns
    -------
    The track of each frame. Where all keyframes are boxes, so are the tracks: upright ellipses.
    Frames that no pass supports, between others that one does, have the status `interpolated`; a
    frame without the target has `absent` and an ellipse of NaN.

    Raises
    ------
    ConfigError
        If the keyframes contradict each other, or are outside of the film or the frame.
    SourceError
        If the film cannot be read.
    """
    keys = keyframes_in(marks)
    film = Film(source, fps=fps)
    check_keyframes(keys, film.name, film.frames, film.width, film.height)
    tracker = preset(config) if isinstance(config, str) else config
    found: dict[int, Track] = {}
    for stretch in stretches(film.frames, keys):
        joined = correct_stretch(reader_of(film, stretch), stretch, tracker, seed)
        found |= {track.frame: track for track in tracks_of(stretch, joined, film.times)}
    return [found[frame] for frame in film.frames]


def smooth(tracks: Sequence[Track]) -> list[Track]:
    """Return tracks in hindsight: smoothed, with outliers flagged and gaps bridged.

    What the tracker has lost is bridged between frames that it has tracked, with a covariance that
    grows from both sides, and has the status `interpolated`; its confidence is not above the
    tracker's. A jump away and back is left out, and has `outlier`. What comes after the last
    tracked frame stays as it is.

    Parameters
    ----------
    tracks
        The track of each frame, in order, as from `Tracker.update`. A covariance that is not known,
        NaN, is taken to be that of the track's confidence.

    Raises
    ------
    ConfigError
        If they are no tracks, as rows of `read_track`, or are smoothed or corrected already.
    """
    if any(isinstance(track, Track) and track.smoothed for track in tracks):
        raise ConfigError(
            "These tracks are smoothed or corrected already; give those of a Tracker."
        )
    only = Course.of(tracks)
    told = variances_told(only.ellipses, only.confidence, HALF)
    only = only._replace(variances=np.where(np.isnan(only.variances), told, only.variances))
    absent = only.where(Status.ABSENT)
    follows = tracked(only, absent)
    if not follows.used.any():
        return list(tracks)
    return fuse([only], follows, {}, [], absent).tracks(tracks)


def stretches(frames: range, keys: Keyframes) -> list[Stretch]:
    """Return the stretches of the frames between neighboring keyframes, and before and after them.

    Neighboring stretches share a keyframe. Each has one at an end at least.
    """
    marked = {frame: region for frame, region in keys.items() if region is not None}
    ends = sorted({frames.start, *marked, frames.stop - 1})
    if len(ends) == 1:
        return [Stretch(ends[0], ends[0], marked[ends[0]], None)]
    found = []
    for first, last in itertools.pairwise(ends):
        absent = frozenset(t for t in range(first, last + 1) if t in keys and keys[t] is None)
        found.append(Stretch(first, last, marked.get(first), marked.get(last), absent))
    return found


def reader_of(film: Film, stretch: Stretch) -> FrameReader:
    """Return the reader of the frames of a stretch: two passes share what is decoded."""
    both = stretch.begin is not None and stretch.end is not None
    return shared(film, stretch.first, stretch.last) if both else film


def correct_stretch(
    film: FrameReader,
    stretch: Stretch,
    config: TrackerConfig,
    seed: int,
    so_far: list[Track] | None = None,
    observe: Callable[[StepInfo], None] | None = None,
) -> Course:
    """Return the track of a stretch, from passes in both directions.

    Between two keyframes, the models of both passes learn from both of them. The tracks of the
    forward pass are added to `so_far`, for a run that is interrupted. `observe` is called with the
    tracker's report of each frame of both passes.
    """
    run = functools.partial(run_pass, config, seed, observe=observe)
    first, last, begin, end, _ = stretch
    forward = backward = at_end = at_begin = None
    if begin is not None and end is not None:
        at_begin, at_end = (_frame(film, first), begin), (_frame(film, last), end)
    if begin is not None:
        frames = film.forward(first, last)
        forward = Course.of(run(frames, begin, so_far=so_far, other=at_end))
    if end is not None:
        frames = film.backward(last, first)
        backward = Course.of(run(frames, end, backward=True, other=at_begin))
    return join(stretch, forward, backward)


def _frame(film: FrameReader, index: int) -> Frame:
    (found,) = film.forward(index, index)
    return found


def partial(stretch: Stretch, so_far: Sequence[Track]) -> tuple[Stretch, Course]:
    """Return the beginning of a stretch whose forward pass was interrupted; one frame at least."""
    last = stretch.first + len(so_far) - 1
    absent = frozenset(frame for frame in stretch.absent if frame <= last)
    part = stretch._replace(last=last, end=None, absent=absent)
    return part, join(part, Course.of(so_far), None)


def tracks_of(stretch: Stretch, joined: Course, times: Sequence[float]) -> list[Track]:
    """Return the track of each frame of a stretch; `times` has those of all frames of the film."""
    nan = float("nan")
    empty = [
        Track(i, times[i], Ellipse(0, 0, 1, 1), np.eye(5), nan, Status.LOST, nan, nan)
        for i in range(stretch.first, stretch.last + 1)
    ]
    return joined.tracks(empty)
