"""Keyframes, as `motes track --keyframes` reads them, and the fewest that restore all rows.

A row is `frame,x,y,width,height`, or `frame,x,y,a,b,theta` in all rows of a file if an ellipse is
turned; `frame,absent` or `first:last,absent` where the target is not in the picture. Frames and
pixels count from 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import FormatError
from motes.core.geometry import Ellipse, as_ellipse
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.correction.keyframes import read_keyframes
from motes.formats.recording import UNTIMED, FilmFacts, Recording, sound
from motes.formats.shapes import Corners, visible_box
from motes.formats.text import at
from motes.formats.visibility import check_identities
from motes.rows.schema import FrameRow

KEYFRAME_ERROR = 1.0
"""Default of the largest deviation of interpolated coordinates, in pixels."""


def keyframes(
    frames: NDArray[np.int64], places: Floats, forced: NDArray[np.bool_], error: float
) -> NDArray[np.bool_]:
    """Return which rows are keyframes, shape (n,).

    From each keyframe, the next one is the last row up to which all rows in between stay within the
    error. The slopes that each row allows from the keyframe are an interval; a row can be the next
    keyframe while its slope lies in the intersection of those before it. After Tomek, Two
    algorithms for piecewise-linear continuous approximation of functions of one variable, 1974.
    Frames (n,) are in order, and places (n, k) are the coordinates in each. Rows that are `forced`
    (n,) are keyframes anyway, and so are the first and the last one. With an error of 0, each row
    is a keyframe.
    """
    chosen = forced | (error == 0)
    chosen[[0, -1]] = True
    start = 0
    while start < len(frames) - 1:
        start = _reach(frames, places, chosen, start, error)
        chosen[start] = True
    return chosen


def _reach(
    frames: NDArray[np.int64], places: Floats, forced: NDArray[np.bool_], start: int, error: float
) -> int:
    """Return the row of the next keyframe."""
    low, high = np.full(places.shape[1], -np.inf), np.full(places.shape[1], np.inf)
    best = start + 1
    for i in range(start + 1, len(frames)):
        elapsed = frames[i] - frames[start]
        step = places[i] - places[start]
        if ((low <= step / elapsed) & (step / elapsed <= high)).all():
            best = i
        low = np.maximum(low, (step - error) / elapsed)
        high = np.minimum(high, (step + error) / elapsed)
        if forced[i] or (low > high).any():
            break
    return best


def boxes_by_identity(
    recorded: Recording, chosen: Callable[[FrameRow], Iterable[Track]], what: str
) -> dict[int, list[tuple[Track, Corners]]]:
    """Return where each of the chosen objects is inside the picture, in order of the frames.

    Raises a FormatError if a box has no identity; `what` names a format of tracks.
    """
    found: dict[int, list[tuple[Track, Corners]]] = {}
    for row in recorded:
        for each in chosen(row):
            here = found.setdefault(each.identity, [])
            if (box := visible_box(each, recorded.head)) is not None:
                here.append((each, box))
    check_identities(found, what)
    return {identity: here for identity, here in found.items() if here}


def thinned(
    here: list[tuple[Track, Corners]], after: Mapping[int, int], error: float
) -> Iterator[tuple[Track, Corners, bool, bool]]:
    """Yield an object's places, whether each is a keyframe, and whether the object ends there.

    `after` has the frame after each one; an object that is not in that one ends, and where it is
    there again a stretch begins.
    """
    frames = [each.frame for each, _ in here]
    ends = [
        after[frame] != further for frame, further in zip(frames, [*frames[1:], -1], strict=True)
    ]
    hidden = np.array([each.status is Status.OCCLUDED for each, _ in here])
    forced = np.array(ends)
    forced[1:] |= forced[:-1] | (hidden[1:] != hidden[:-1])
    keys = keyframes(np.array(frames), np.array([box for _, box in here]), forced, error)
    for (each, box), key, end in zip(here, keys.tolist(), ends, strict=True):
        yield each, box, key, end


TITLES = (b"frame,x,y,width,height\n", b"frame,x,y,a,b,theta\n")
"""Those of boxes, and of ellipses."""
CORNER = "x and y of a box are read as its left and top, not as its center, as in rows of motes."


def write(recorded: Recording, keyframe_error: float = KEYFRAME_ERROR) -> Iterator[bytes]:
    """Yield the rows of the one object.

    If the file that was read has keyframes of its own, these are written. Otherwise they are as few
    as keep linear interpolation within `keyframe_error` pixels.
    """
    here = recorded.only_object("A file of keyframes")
    turned = any(each.ellipse.theta or each.identity in recorded.ellipses for each in here.values())
    yield TITLES[turned]
    hidden = {
        row.frame for row in recorded if any(each.status is Status.OCCLUDED for each in row.objects)
    }
    listed = [row.frame for row in recorded if row.frame in here or row.frame not in hidden]
    own = not all(each.keyframe for each in here.values())
    stretch: list[int] = []
    for frame, after in zip(listed, [*listed[1:], None], strict=True):
        stretch.append(frame)
        if after is not None and (after in here) == (frame in here):
            continue
        if frame not in here:
            frames = f"{stretch[0]}:{frame}" if frame > stretch[0] else f"{frame}"
            yield f"{frames},absent\n".encode()
        else:
            ellipses = np.array([here[each].ellipse for each in stretch])
            nothing = np.zeros(len(stretch), bool)
            keys = keyframes(np.array(stretch), ellipses, nothing, keyframe_error).tolist()
            for each, key in zip(stretch, keys, strict=True):
                if here[each].keyframe if own else key:
                    region = here[each].ellipse if turned else here[each].ellipse.box
                    fields = [str(each), *(f"{value:.7g}" for value in region)]
                    yield (",".join(fields) + "\n").encode()
        stretch = []


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the target in the frames in which it is marked.

    Raises a FormatError if the rows are of several films.
    """
    notes: list[str] = []
    films = read_keyframes(path, notes.append)
    if len(films) > 1:
        raise FormatError(f"it has keyframes of {len(films)} films; keep the rows of one")
    (marks,) = films.values()
    objects = []
    for frame, region in marks.items():
        with at(f"frame {frame}"):
            if region is not None:
                objects.append(sound(Track(frame, UNTIMED, as_ellipse(region))))
    found = Recording.of(facts, objects, dict.fromkeys(marks))
    if not any(isinstance(region, Ellipse) for region in marks.values()):
        return replace(found, listed=True, notes=[CORNER])
    return replace(found, listed=True, ellipses={1}, notes=notes)
