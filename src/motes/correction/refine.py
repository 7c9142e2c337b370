"""Corrections of a track: only the stretches that they change are tracked again."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from motes.core.errors import ConfigError
from motes.core.track import Track
from motes.correction.correct import followed
from motes.correction.join import Stretch
from motes.correction.keyframes import Keyframes, Marks, check_keyframes, keyframes_in
from motes.correction.passes import check_tracks
from motes.sot.presets import TrackerConfig, preset
from motes.video.film import Film


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
