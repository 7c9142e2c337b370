"""A film and its keyframes become a track, stretch by stretch; corrections change few of these."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.track import Status, Track
from motes.correction.coordinates import variances_told
from motes.correction.join import HALF, Stretch, fuse, tracked
from motes.correction.keyframes import Keyframes, Marks, check_keyframes, keyframes_in
from motes.correction.passes import Course, check_tracks, run_pass
from motes.sot.algorithm import StepInfo
from motes.sot.presets import TrackerConfig, preset
from motes.video.film import Film, FrameReader, shared


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
    found = followed(film, Stretch.between(film.frames, keys), tracker, seed)
    return [found[frame] for frame in film.frames]


def followed(
    film: Film, parts: Iterable[Stretch], config: TrackerConfig, seed: int
) -> dict[int, Track]:
    """Return the tracks of stretches of a film, by their frames."""
    found: dict[int, Track] = {}
    for each in parts:
        passes = passes_over(reader_of(film, each), each, config, seed)
        found |= {track.frame: track for track in each.joined(film.times, *passes)}
    return found


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
    only = Course.of(tracks)
    if any(track.smoothed for track in tracks):
        raise ConfigError(
            "These tracks are smoothed or corrected already; give those of a Tracker."
        )
    told = variances_told(only.ellipses, only.confidence, HALF)
    only = only._replace(variances=np.where(np.isnan(only.variances), told, only.variances))
    absent = only.where(Status.ABSENT)
    follows = tracked(only, absent)
    if not follows.used.any():
        return list(tracks)
    return fuse([only], follows, {}, [], absent).tracks(tracks)


def reader_of(film: Film, stretch: Stretch) -> FrameReader:
    """Return the reader of the frames of a stretch: two passes share what is decoded."""
    both = stretch.begin is not None and stretch.end is not None
    return shared(film, stretch.first, stretch.last) if both else film


def passes_over(
    film: FrameReader,
    stretch: Stretch,
    config: TrackerConfig,
    seed: int,
    so_far: list[Track] | None = None,
    observe: Callable[[StepInfo], None] | None = None,
) -> tuple[Course | None, Course | None]:
    """Return the passes over a stretch, forward and backward, each from its keyframe.

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
    return forward, backward


def _frame(film: FrameReader, index: int) -> Frame:
    (found,) = film.forward(index, index)
    return found


def refine(
    source: str | Path,
    tracks: Sequence[Track],
    marks: Marks,
    corrections: Marks,
    config: str | TrackerConfig = "default",
    seed: int = 0,
    fps: float | None = None,
) -> list[Track]:
    """Correct tracks: only stretches between corrections and neighboring keyframes are made anew.

    Parameters
    ----------
    source
        The film, a video file or images.
    tracks
        The track of each frame, as from `motes.correct`.
    marks
        The keyframes of these tracks, as for `motes.correct`.
    corrections
        Further keyframes; one of a frame that is marked already replaces it.
    config, seed
        The tracker, as in `Tracker`.
    fps
        Frames per second of images, as in `open_source`.

    Returns
    -------
    The tracks; those of other stretches are the same objects.

    Raises
    ------
    ConfigError
        If keyframes contradict each other or are outside of the tracks or the frame, or frames
        between the tracks are missing, or they are no tracks, as rows of `read_track`.
    SourceError
        If the film cannot be read.
    """
    check_tracks(tracks)
    frames = [track.frame for track in tracks]
    if not frames or frames != [*range(frames[0], frames[0] + len(frames))]:
        raise ConfigError("Give the track of every frame, in order.")
    film = Film(source, start=frames[0], end=frames[-1] + 1, fps=fps)
    old = keyframes_in(marks)
    new = dict(sorted((old | keyframes_in(corrections)).items()))
    check_keyframes(new, film.name, range(frames[0], frames[-1] + 1), film.width, film.height)
    tracker = preset(config) if isinstance(config, str) else config
    found = {track.frame: track for track in tracks}
    found |= followed(film, changed(film.frames, old, new), tracker, seed)
    return [found[frame] for frame in frames]


def changed(
    frames: range, old: Keyframes, new: Keyframes, unfinished: Iterable[tuple[int, int]] = ()
) -> list[Stretch]:
    """Return the stretches that new keyframes change, and those that are not finished."""
    before = set(Stretch.between(frames, old))
    left = set(unfinished)
    return [
        each
        for each in Stretch.between(frames, new)
        if each not in before or (each.first, each.last) in left
    ]
