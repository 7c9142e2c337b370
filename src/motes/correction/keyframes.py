"""Keyframes: frames in which a user has marked the target, or marked it as absent.

A file of keyframes has a row for each:

    0,300,200,40,60             frame, then a box: x, y, width, height
    90,310.5,214,21,33,0.12     frame, then an ellipse: x, y, a, b, theta
    130,absent                  the target is not in this frame
    135:150,absent              nor in these, the last one included

A row may begin with the name of its film, so that one file serves many films; one that has a comma
or begins with `#` stands in quotes. A first row of titles that begins with `frame` or `film` is
skipped, and so are empty rows and those that begin with `#`. The regions of a file are all boxes or
all ellipses, those of its titles if it has any, so that a row that lost a number is noticed.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from motes.core.errors import ConfigError, InputError, MotesError
from motes.core.files import check_ended, lines_of, read_text
from motes.core.frame import WHOLE
from motes.core.geometry import Box, Ellipse, as_ellipse, as_region, check_angle, region_within
from motes.core.types import Numbers

Region = Box | Ellipse
"""What was marked: a box tells no angle, an ellipse whose theta is 0 does."""

Keyframes = Mapping[int, Region | None]
"""The target's region in each marked frame, in order of the frames; None where it is absent."""

Marks = Mapping[int, Numbers | None]
"""The same, with regions as users have them."""

Mark = tuple[int, Sequence[float] | None]
"""One of them: a frame, and the target's region there; None where it is absent."""

ABSENT = "absent"
TITLES = (
    ["x", "y", "width", "height"], ["x", "y", "w", "h"], ["x", "y", "a", "b", "theta"], ["region"],
)  # fmt: skip
"""Titles of the columns after the frame that a file may have."""
BOXES = (
    "if the numbers are frame,id,x,y,width,height or frame,x,y,width,height,score, write frame,id,"
    "x,y,width,height,score (id -1 for none; frames and pixels from 1); if they are of an ellipse, "
    "add titles: frame,x,y,a,b,theta."
)
"""What to do where six numbers without titles may be no ellipse."""
MAX_ABSENT = 1_000_000
"""Frames that one range of absence may have; more than nine hours of film."""
_FRAMES = re.compile(r"\d{1,9}(:\d{1,9})?")
_NUMBERS = re.compile(r"[-+.:\d]+")


def keyframes_in(marks: Marks) -> dict[int, Region | None]:
    """Return keyframes in order from a mapping; raise a ConfigError if they are none.

    The angle of the first region must be within a turn.
    """
    if not isinstance(marks, Mapping):
        raise ConfigError(
            f"Keyframes are a mapping from numbers of frames to regions, such as {{0: (300, 200, "
            f"40, 60)}}; got {' '.join(repr(marks).split())[:80]}."
        )
    found = keyframes(marks.items())
    for region in found.values():
        if region is not None:
            check_angle(as_ellipse(region).theta)
            break  # later ones may go on beyond a turn
    return found


def keyframes(marks: Iterable[tuple[int, Numbers | None]]) -> dict[int, Region | None]:
    """Return keyframes in order from marks: frames, each with a region or None.

    Raises a ConfigError if a region is not valid, a frame is negative, or two marks of a frame
    differ.
    """
    found: dict[int, Region | None] = {}
    for frame, region in marks:
        if not isinstance(frame, WHOLE) or isinstance(frame, bool):
            raise ConfigError(f"A keyframe has the number of its frame; got {frame!r}.")
        if frame < 0:
            raise ConfigError(f"Frame {frame} of a keyframe is negative; the first frame is 0.")
        mark = None if region is None else as_region(region)
        if found.setdefault(frame, mark) != mark:
            raise ConfigError(
                f"The keyframes of frame {frame} contradict each other: {named(found[frame])} and "
                f"{named(mark)}; keep one."
            )
    return dict(sorted(found.items()))


def number_of(marks: Marks) -> int:
    """Return how many corrections marks are; frames without the target, side by side, are one."""
    absent = {frame for frame, region in marks.items() if region is None}
    return sum(frame not in absent or frame - 1 not in absent for frame in marks)


def named(mark: Region | None) -> str:
    """Return a keyframe's region as text."""
    if mark is None:
        return ABSENT
    return ",".join(f"{value:g}" for value in mark)


def marks_of(frames: str, region: str) -> list[Mark]:
    """Return the marks of a text of frames, N or FIRST:LAST, and one of a region, or `absent`.

    Raises a ConfigError if a text has another form.
    """
    if not _FRAMES.fullmatch(frames.strip()):
        raise ConfigError(f"{frames!r} is no frame; give its number, or FIRST:LAST if absent.")
    first, _, last = frames.partition(":")
    start, stop = int(first), int(last or first)
    if stop < start:
        raise ConfigError(f"The frames {frames} are no range; the first one comes first.")
    if stop - start >= MAX_ABSENT:
        raise ConfigError(f"The frames {frames} are more than {MAX_ABSENT}; correct the last one.")
    if region.strip() == ABSENT:
        return [(frame, None) for frame in range(start, stop + 1)]
    if last:
        raise ConfigError(
            f"The frames {frames} have one region; give each frame its own, by its number, which "
            f"counts from 0, and not by a time."
        )
    try:
        numbers = [float(number) for number in region.split(",")]
    except ValueError:
        raise ConfigError(
            f"{region!r} is no region of frame {start}; give x,y,width,height or x,y,a,b,theta, or "
            f"{ABSENT}."
        ) from None
    return [(start, as_region(numbers))]


def read_keyframes(
    path: str | Path, tell: Callable[[str], object] = lambda _: None
) -> dict[str, dict[int, Region | None]]:
    """Return the keyframes of a file, by the film that their rows name; "" without a name.

    Parameters
    ----------
    path
        A file of comma-separated rows: `frame,x,y,width,height`, `frame,x,y,a,b,theta`, or
        `frame,absent` and `first:last,absent`. Frames and pixels count from 0. The name of a film
        may be in front.
    tell
        Called with what to know of a file without titles, whose six numbers are read as ellipses.

    Returns
    -------
    For each film the target's box or ellipse by frame; None where the target is absent.

    Raises
    ------
    InputError
        If the file cannot be read, has no keyframe, or a row has another form, with its number.
    """
    text = read_text(path, InputError)
    marks: dict[str, list[Mark]] = {}
    size: int | None = None
    titled = False
    for number, line in enumerate(lines_of(text), start=1):
        try:
            fields = [field.strip() for field in next(csv.reader([line], skipinitialspace=True))]
        except (csv.Error, StopIteration):  # no line of a table, or an empty one
            fields = [line.strip()]
        if number == 1 and fields[0].lower() in ("frame", "film"):
            size, titled = _size_of_titles(path, [field.lower() for field in fields]), True
            continue
        if not any(fields) or line.lstrip().startswith("#"):
            continue
        film = "" if _NUMBERS.fullmatch(fields[0]) else fields.pop(0)
        if fields[1:2] == [ABSENT]:
            fields = fields[: 2 + len("".join(fields[2:]))]  # a spreadsheet fills up the row
        try:
            if len(fields) < 2:
                raise ConfigError(
                    "it has no region; give x,y,width,height, with commas and points, or absent."
                )
            here = marks_of(fields[0], ",".join(fields[1:]))
            if (region := here[0][1]) is not None:
                count = len(region)
                if count == 5 and all(mark is None for _, mark in marks.get(film, ())):
                    _check_first(region[4], titled)
                if count != (size := size or count):
                    raise ConfigError(
                        f"it has {count} numbers, and a region of this file has {size}; give "
                        f"x,y,width,height in all rows, or x,y,a,b,theta in all."
                    )
            marks.setdefault(film, []).extend(here)
        except MotesError as error:
            raise InputError(f"{path}, row {number}: {error}") from None
    try:
        check_ended(text)
    except ValueError as error:
        raise InputError(f"{path}: {error}.") from None
    if not marks:
        raise InputError(f"{path} has no keyframe; a row is frame,x,y,width,height.")
    doubtful = size == 5 and not titled
    try:
        found = {film: keyframes(each) for film, each in marks.items()}
    except ConfigError as error:
        raise InputError(f"{path}: {error}{f' Or {BOXES}' * doubtful}") from None
    if doubtful:
        tell(f"its rows are read as frame,x,y,a,b,theta of ellipses; {BOXES}")
    return found


def _size_of_titles(path: str | Path, titles: Sequence[str]) -> int | None:
    """Return how many numbers a region has by the titles of a file; None if they leave it open."""
    columns = [title for title in titles[titles[0] == "film" :] if title]
    if columns[:1] != ["frame"] or columns[1:] not in TITLES:
        raise InputError(
            f"{path}, row 1: the columns are {', '.join(titles)[:80]}; they must be frame, x, y, "
            f"width, height, or frame, x, y, a, b, theta."
        )
    return len(columns) - 1 if len(columns) > 2 else None


def _check_first(theta: float, titled: bool) -> None:
    """Check the angle of the first ellipse, which without titles may be the height of a box."""
    if titled or theta <= 0 or (theta <= math.pi and theta % 1):  # a height is whole
        return check_angle(theta)
    raise ConfigError(f"theta begins with {theta:g}; {BOXES}")


def keyframes_of(
    path: str | Path, source: str, tell: Callable[[str], object]
) -> dict[int, Region | None]:
    """Return the keyframes of a source in a file: rows with its name, or rows without a name.

    `tell` is that of `read_keyframes`. Raises an InputError if the file cannot be read, or has
    neither.
    """
    found = read_keyframes(path, tell)
    for name in (source, Path(source).name, Path(source).stem, ""):
        if name in found:
            return found[name]
    raise InputError(
        f"{path} has keyframes of {', '.join(sorted(found))}, none of {source}; name it in a row."
    )


def check_keyframes(marks: Keyframes, name: str, frames: range, width: int, height: int) -> None:
    """Check keyframes against their film.

    Raises a ConfigError if there is none with a region, some are boxes and some are ellipses, or
    one is outside of the frames or of the picture.
    """
    if all(region is None for region in marks.values()):
        raise ConfigError("No keyframe marks the target; give one a region.")
    boxes = [frame for frame, region in marks.items() if isinstance(region, Box)]
    ellipses = [frame for frame, region in marks.items() if isinstance(region, Ellipse)]
    if boxes and ellipses:
        raise ConfigError(
            f"Frame {ellipses[-1]} is marked by an ellipse, and frame {boxes[-1]} by a box, which "
            f"tells no angle; mark x,y,a,b,theta in all frames, or x,y,width,height in all."
        )
    for frame in (min(marks), max(marks)):  # an end of a range is a number that was given
        if frame not in frames:
            raise ConfigError(
                f"The keyframe {frame} is outside of {name}, of which the frames {frames.start} to "
                f"{frames.stop - 1} are used; correct its number."
            )
    for frame, region in marks.items():
        if region is not None:
            try:
                region_within(region, width, height)
            except ConfigError as error:
                raise ConfigError(f"Keyframe {frame} of {name}: {error}") from None
