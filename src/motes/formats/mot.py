"""Results, truth and detections of the MOTChallenge.

A line is a box, its numbers separated by commas, semicolons, tabs or spaces:

    frame, id, x, y, width, height, score, class, visibility

Frames and pixels count from 1. Only truth has classes. The score of truth is a flag, 0 for boxes
that do not count. Milan et al., MOT16: a benchmark for multi-object tracking, 2016, table 4. Lines
of ten numbers have world coordinates instead of a class, as in Leal-Taixé et al., MOTChallenge
2015.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Literal

from motes.core.errors import FormatError, counted
from motes.core.files import check_ended, lines_of, read_text
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.correction.keyframes import BOXES
from motes.formats.recording import ANONYMOUS, MAX_FRAME, UNTIMED, FilmFacts, Recording
from motes.formats.shapes import label_or_none
from motes.formats.text import at, fields_of, number
from motes.formats.visibility import shown, visible
from motes.video.image_files import rate_in

Kind = Literal["truth", "results", "detections"]

UNKNOWN = -1
"""Class of a box that has none, and identity of a detection."""
AREAS: dict[Kind, str] = {"truth": "an object", "detections": "a detection"}
"""The kinds whose rows must have an area, and their names in the error."""
CLASSES = {
    "pedestrian": 1, "person on vehicle": 2, "car": 3, "bicycle": 4, "motorbike": 5,
    "non-motorized vehicle": 6, "static person": 7, "distractor": 8, "occluder": 9,
    "occluder on the ground": 10, "full occluder": 11, "reflection": 12, "crowd": 13,
}  # fmt: skip
"""Numbers of classes in the MOTChallenge (Milan et al., MOT16, 2016, table 3)."""
PARTS = ("gt", "det")
"""Folders of a sequence of the MOTChallenge."""
LABELS = "labels.txt"
"""The file beside a truth that has the names of its classes."""
SYNONYMS = {"person": "pedestrian", "motorcycle": "motorbike"}
_NAMES = {number: name for name, number in CLASSES.items()}

_NEEDED, _MOST = 7, 10
_CLASS = 7


def write(kind: Kind, recorded: Recording) -> Iterator[bytes]:
    """Yield a line for each visible object; only truth has a line for an occluded one, too.

    Elsewhere the form cannot mark a predicted box, and scores would count it. Detections have no
    identity, and are for `motes watch --detector`.
    """
    for row in recorded:
        for each in shown(row) if kind == "truth" else visible(row):
            yield line_of(kind, each).encode() + b"\n"


def line_of(kind: Kind, each: Track) -> str:
    """Return the line of an object in a frame.

    - Results: frame, identity, box, confidence, class, 1, -1. The class is 1 for an object without
      one, and -1 for one that is none of `CLASSES`.
    - Truth: frame, identity, box, flag, class, visibility. The flag is 0 for an object with
      confidence 0, which does not count. An occluded object counts, with visibility 0.
    - Detections: frame, -1, box, confidence, -1, -1, -1.
    """
    frame, box, sure = each.frame, _box(each), f"{each.confidence:.4f}"
    if kind == "detections":
        return f"{frame + 1},-1,{box},{sure},-1,-1,-1"
    if kind == "results":
        return f"{frame + 1},{each.identity},{box},{sure},{number_of(each.label)},1,-1"
    hidden = each.status is Status.OCCLUDED
    flag = int(hidden or each.confidence > 0)
    return f"{frame + 1},{each.identity},{box},{flag},{number_of(each.label)},{1 - hidden}"


def _box(each: Track) -> str:
    x, y, width, height = each.box
    return f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f}"


def number_of(label: str | None) -> int:
    """Return the number of a class; that of a pedestrian for none, and -1 for another one."""
    if label is None:
        return CLASSES["pedestrian"]
    name = label.lower()
    return CLASSES.get(SYNONYMS.get(name, name), UNKNOWN)


def numberless(recorded: Recording) -> list[str]:
    """Return the classes that have no number in the MOTChallenge, so that they become -1."""
    labels = {each.label for row in recorded for each in row.objects if each.label is not None}
    return sorted(label for label in labels if number_of(label) == UNKNOWN)


def read(kind: Kind, path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of a file.

    The confidence of truth is its flag, and visibility 0 is occluded. Detections have no identity.
    A score that is no probability, as many detectors' are not, is read as 1. Truth has the classes
    that `class_names` finds beside it. Where the film's rate is unknown, it is that of a
    `seqinfo.ini` beside the file, or beside its folder gt or det.
    """
    if not facts.fps:
        folder = path.absolute().parent
        facts = replace(facts, fps=rate_in(folder.parent if folder.name in PARTS else folder))
    lines = read_lines(path, facts.frames or MAX_FRAME, kind, sized=True)
    if lines and all(height <= 1 for *_, height, _, _, _ in lines):  # so a score is read as one
        raise FormatError(f"none of its boxes is higher than a pixel; {BOXES}")
    own_names = class_names(path.parent) if kind == "truth" else {}
    names = own_names or _NAMES
    objects = [*_objects(lines, kind, names, facts.label)]
    scores = sum(not 0 <= line[6] <= 1 for line in lines)
    left_out = ["the numbers after the score"] * (bool(lines) and _has_more(path, kind))
    left_out += [f"{counted(scores, 'score')} that are no probabilities, and read as 1"] * bool(
        scores
    )
    # One target of results may be lost where it has no line.
    told = kind != "results" or len({each.identity for each in objects}) > 1
    last = max((each.frame for each in objects), default=-1)
    seen = facts.seen(last) if told else range(0)
    notes = [
        f"its first pixel is read as 1, as in the MOTChallenge; CVAT and Datumaro, which write "
        f"{LABELS} too, mean 0, so that a box of theirs is now a pixel too far left and up: export "
        f"it as CVAT or COCO."
    ] * bool(own_names)
    return replace(Recording.of(facts, objects, told=seen, left_out=left_out), notes=notes)


def _has_more(path: Path, kind: Kind) -> bool:
    """Return whether the lines have further numbers that are not read, such as places in metres."""
    line = next(line for line in lines_of(read_text(path, FormatError)) if line.strip())
    more = fields_of(line)[_NEEDED:]
    return not _has_classes(more, kind) and any(number(each) != UNKNOWN for each in more)


def _has_classes(more: list[str], kind: Kind) -> bool:
    """Return whether class and visibility follow the score: in truth, and in results of motes."""
    ours = kind == "results" and len(more) == 3 and more[-2:] == ["1", "-1"]
    return ours or (kind == "truth" and len(more) in (1, 2))


def class_names(folder: Path) -> dict[int, str]:
    """Return the names of classes by number, of a `labels.txt` of CVAT or Datumaro; empty without.

    The first line is class 1.
    """
    path = folder / LABELS
    if not path.is_file():
        return {}
    names = lines_of(read_text(path, FormatError))
    return {number: name.strip() for number, name in enumerate(names, start=1) if name.strip()}


def _objects(
    lines: Iterable[list[float]], kind: Kind, names: Mapping[int, str], usual: str
) -> Iterator[Track]:
    for frame, identity, x, y, width, height, score, label, share in lines:
        if kind != "detections" and identity < ANONYMOUS:
            raise FormatError(f"{identity:.0f} is no identity; they count from 0, and -1 is none")
        yield Track(
            int(frame) - 1,
            UNTIMED,
            Ellipse.from_box((x - 1, y - 1, width, height)),
            confidence=score if 0 <= score <= 1 else 1.0,
            status=Status.OCCLUDED if share == 0 else Status.TRACKING,
            identity=ANONYMOUS if kind == "detections" else int(identity),
            label=label_or_none(_class_name(int(label), names), usual),
        )


def _class_name(label: int, names: Mapping[int, str]) -> str | None:
    """Return the name of a class; None where a line has none."""
    if label == UNKNOWN or label in names:
        return names.get(label)
    if names is not _NAMES:
        raise FormatError(f"class {label} is none of the {len(names)} of {LABELS}; add its name")
    return f"class {label}"


def read_boxes(path: Path, frames: int, kind: Kind) -> list[list[float]]:
    """Return what `read_lines` does, with classes of the MOTChallenge, or `UNKNOWN`.

    Where a truth has the names of its own classes beside it, what is none of the MOTChallenge's is
    a distractor. Raises a FormatError as `read_lines`, and for another class.
    """
    lines = read_lines(path, frames, kind)
    names = class_names(path.parent) if kind == "truth" else {}
    for line in lines if names else ():
        number = number_of(names.get(int(line[_CLASS]), ""))
        line[_CLASS] = CLASSES["distractor"] if number == UNKNOWN else number
    most = max((line[_CLASS] for line in lines), default=0)
    if most > max(CLASSES.values()):
        raise FormatError(
            f"class {most:.0f} is none of the MOTChallenge; add gt/{LABELS} with names"
        )
    return lines


def read_lines(path: Path, frames: int, kind: Kind, *, sized: bool = False) -> list[list[float]]:
    """Return the boxes of a video, in the order of the lines; these have equally many fields.

    Raises a FormatError if it cannot be read, or a line is wrong, with file and line. In truth and
    results, a frame has each identity at most once. Truth has classes and visibilities, and so have
    results of motes, which end with `1,-1`. Objects and detections must have an area; results need
    not, unless `sized`. A box is frame, identity, x, y, width, height, score, class and visibility;
    the class is `UNKNOWN` and the visibility 1 where the line has none. The first frame and pixel
    are 1.
    """
    name = "/".join([path.parent.name, path.name]).lstrip("/")
    text = read_text(path, FormatError)
    lines: list[list[float]] = []
    seen: dict[tuple[float, float], int] = {}
    count = 0
    for place, line in enumerate(lines_of(text), 1):
        if not line.strip():
            continue
        with at(f"{name}, line {place}"):
            fields = fields_of(line)
            count = count or len(fields)
            if len(fields) != count:
                raise ValueError(f"{len(fields)} fields, and the lines before it have {count}")
            row = _parse_row(fields, frames, kind)
            frame, identity, _, _, width, height, *_ = row
            first = seen.setdefault((frame, identity), place)
            if kind != "detections" and first != place:
                raise ValueError(
                    f"frame {frame:.0f} already has the identity {identity:.0f}, in line {first}"
                )
            if (sized or kind in AREAS) and not (width > 0 and height > 0):
                raise ValueError(
                    f"{AREAS.get(kind, 'a box')} of {width:g}x{height:g} pixels has no area"
                )
        lines.append(row)
    with at(name):
        check_ended(text)
    return lines


def _parse_row(fields: list[str], frames: int, kind: Kind) -> list[float]:
    if not _NEEDED <= len(fields) <= _MOST:
        raise ValueError(
            f"{len(fields)} numbers, but a line has {_NEEDED} to {_MOST}: frame, id, x, y, width, "
            f"height, score, and up to three more"
        )
    values, more = [number(field) for field in fields[:_NEEDED]], fields[_NEEDED:]
    frame, identity, *_ = values
    further = [number(field) for field in more]
    if not (frame.is_integer() and identity.is_integer()):
        raise ValueError(f"frame and id are whole numbers, not {fields[0]}, {fields[1]}")
    if frame < 1:
        raise ValueError(f"there is no frame {frame:.0f}: frames count from 1")
    if frame > frames:
        raise ValueError(f"there is no frame {frame:.0f}; the video has the frames 1 to {frames}")
    if not _has_classes(more, kind):
        return [*values, UNKNOWN, 1]
    label, share = further[0], further[1] if len(further) > 1 else 1
    if not label.is_integer() or (label < 1 and label != UNKNOWN):
        raise ValueError(f"{more[0]} is not a class; classes count from 1")
    if not 0 <= share <= 1 and share != UNKNOWN:
        raise ValueError(f"the visibility {more[1]} is no share, 0 to 1")
    return [*values, label, share]
