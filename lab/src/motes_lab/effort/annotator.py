"""A simulated annotator: keyframes are added until enough frames are right."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motes import Box, Ellipse
from motes.core import Floats, iou
from motes.correction import ranked
from motes_lab.effort.methods import Film, Method, Path, equidistant, interpolated

RIGHT, ENOUGH = 0.7, 0.95
"""Least overlap (IoU) of a frame that is right; share of the frames that must be right."""


class Effort(NamedTuple):
    """What a film has cost: the number of keyframes after the first one, and that of frames."""

    corrections: int
    frames: int

    @property
    def rate(self) -> float:
        """Corrections for each 100 frames."""
        return 100 * self.corrections / self.frames


def annotate(film: Film, truth: Floats, method: Method) -> Effort:
    """Return the effort with a method.

    The next keyframe is the frame with the largest expected gain, or the worst one if none is.

    Parameters
    ----------
    film
        The film; its first frame has the target.
    truth
        (frames, 4), the boxes of all frames; NaN where the target is absent.
    method
        What makes a region for each frame of the keyframes.
    """
    first = film.used.start
    keys: dict[int, Box | Ellipse | None] = {first: Box(*truth[first].tolist())}
    while True:
        path = method(film, dict(sorted(keys.items())))
        found = _overlaps(path, film.used, truth)
        if _enough(found):
            return Effort(len(keys) - 1, len(film.used))
        frame = _next(path, found, film.used, keys)
        box = truth[frame]
        keys[frame] = None if np.isnan(box).any() else Box(*box.tolist())


def annotate_equidistant(film: Film, truth: Floats) -> Effort:
    """Return the effort of interpolation between the fewest equidistant keyframes that do."""
    for count in range(len(film.used)):
        keys: dict[int, Box | Ellipse | None] = {
            frame: None if np.isnan(truth[frame]).any() else Box(*truth[frame].tolist())
            for frame in equidistant(film.used, count)
        }
        if _enough(_overlaps(interpolated(film, keys), film.used, truth)):
            break
    return Effort(count, len(film.used))


def _overlaps(path: Path, used: range, truth: Floats) -> Floats:
    """Return the overlap (n,) in each frame; NaN where the target is absent."""
    boxes = truth[used.start : used.stop]
    found = iou(np.nan_to_num(path.boxes), np.nan_to_num(boxes))
    return np.where(np.isnan(boxes).any(axis=1), np.nan, found)


def _enough(overlaps: Floats) -> bool:
    known = overlaps[np.isfinite(overlaps)]
    return bool(np.mean(known >= RIGHT) >= ENOUGH)


def _next(path: Path, overlaps: Floats, used: range, keys: dict[int, Box | Ellipse | None]) -> int:
    """Return the next frame to correct."""
    marked = np.isin(np.array(used), [*keys])
    if found := ranked(*path, marked, 1):
        return used[found[0].place]
    return used[int(np.where(marked | np.isnan(overlaps), np.inf, overlaps).argmin())]
