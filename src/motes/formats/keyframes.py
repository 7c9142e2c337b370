"""Keyframes, as `motes track --keyframes` reads them: a row for each frame that is marked.

A row is `frame,x,y,width,height`, or `frame,x,y,a,b,theta` in all rows of a file if an ellipse is
turned; `frame,absent` or `first:last,absent` where the target is not in the picture. Frames and
pixels count from 0.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from motes.core.errors import FormatError
from motes.core.track import Status
from motes.correction.keyframes import read_keyframes
from motes.formats.recording import FilmFacts, Recording, placed, sound
from motes.formats.text import at
from motes.formats.thinning import KEYFRAME_ERROR, keyframes

TITLES = (b"frame,x,y,width,height\n", b"frame,x,y,a,b,theta\n")
"""Those of boxes, and of ellipses."""


def write(recorded: Recording, keyframe_error: float = KEYFRAME_ERROR) -> Iterator[bytes]:
    """Yield the rows of the one object.

    If the file that was read has keyframes of its own, these are written. Otherwise they are as few
    as keep linear interpolation within `keyframe_error` pixels.
    """
    here = recorded.only_object("A file of keyframes")
    turned = any(each.ellipse.theta for each in here.values())
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
    films = read_keyframes(path)
    if len(films) > 1:
        raise FormatError(f"it has keyframes of {len(films)} films; keep the rows of one")
    (marks,) = films.values()
    objects = []
    for frame, region in marks.items():
        with at(f"frame {frame}"):
            if region is not None:
                objects.append(sound(placed(frame, region)))
    return replace(Recording.of(facts, objects, dict.fromkeys(marks)), listed=True)
