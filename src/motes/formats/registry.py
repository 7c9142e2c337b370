"""All formats in one table: their names, what they hold, and how a file is recognized."""

from __future__ import annotations

import csv
import importlib
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
from msgspec import structs

from motes.core.errors import ConfigError, FormatError, SourceError
from motes.core.files import write_folder, write_whole
from motes.core.geometry import of_corners
from motes.core.registry import Registry
from motes.core.track import BOX, ELLIPSE, SURE, Status
from motes.formats.recording import FilmFacts, Recording
from motes.formats.shapes import visible_box
from motes.formats.text import fields_of
from motes.formats.truth import kind_of
from motes.formats.visibility import (
    ANGLES,
    ASPECTS,
    CLASSES,
    CONFIDENCES,
    GUESSES,
    HIDDEN,
    IDENTITIES,
    MASKS,
    OTHERS,
    SHOWN,
    TIMES,
    certain,
    marked,
)
from motes.rows.reader import OLD_LINES, SEPARATED

UNKNOWN, UNSEEN = {"status": Status.SEARCHING}, {"status": Status.OCCLUDED}
"""A guess in formats that cannot mark it, so that it is not there, and in those that can."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Format:
    """A format of files."""

    title: str
    """What it is, in a few words."""
    endings: tuple[str, ...] = ()
    """Ends of the names of its files, for writing, or whole names where there is no dot before. The
    longest one that fits counts."""
    read: str | Callable[..., Recording] | None = None
    """Returns the `Recording` of a path and of the `FilmFacts`; or `module:function` in
    `motes.formats`, or `module:function:text` if it takes a text before. None if it cannot be
    read."""
    write: str | Callable[..., Iterator[Any]] | None = None
    """Returns the bytes of a `Recording`, piece by piece; of a folder, pairs of a name and bytes.
    None if it cannot be written."""
    holds: tuple[str, ...] = ()
    """Those of `ASPECTS` that it holds."""
    sized: bool = False
    """Whether it needs the size of the picture."""
    thinned: bool = False
    """Whether it holds keyframes, between which its tools interpolate."""
    folder: tuple[str, ...] = ()
    """The endings of the files in a folder; none if it is a single file."""
    folders: tuple[str, ...] = ()
    """The names of folders in it."""
    single: bool = False
    """Whether it holds one object."""
    certain: bool = False
    """Whether it tells others what a frame shows, so that a frame in which a target is lost or
    searched for is left out: that it is not found does not say that it is not there."""
    guess: Mapping[str, Any] | None = field(default_factory=UNKNOWN.copy)
    """What a row that is a guess has here, as the format would tell others that it was seen; None
    where its status or its confidence tells."""


ROWS = (ANGLES, CONFIDENCES, IDENTITIES, CLASSES, HIDDEN, GUESSES, TIMES, OTHERS)
LABELS = (".txt", ".yaml", ".cache")

OWN: dict[str, Format] = {
    "csv": Format(
        title="rows of motes, CSV", endings=(".csv",), read="rows:read", write="rows:write:csv",
        holds=ROWS, guess=None,
    ),
    "jsonl": Format(
        title="rows of motes, JSON Lines", endings=(".jsonl",), read="rows:read",
        write="rows:write:jsonl", holds=ROWS, guess=None,
    ),
    "parquet": Format(
        title="rows of motes, Apache Parquet", endings=(".parquet",), read="parquet:read",
        write="parquet:write", holds=ROWS, guess=None,
    ),
    "mot": Format(
        title="results of the MOTChallenge", endings=(".txt",), read="mot:read:results",
        write="mot:write:results", holds=(CONFIDENCES, IDENTITIES, CLASSES), guess=None,
    ),
    "mot-truth": Format(
        title="truth of the MOTChallenge", endings=(".gt.txt", "gt.txt"), read="mot:read:truth",
        write="mot:write:truth", holds=(IDENTITIES, CLASSES, HIDDEN),
        guess={"status": Status.TRACKING, "confidence": 0.0},  # its flag: it does not count
    ),
    "mot-detections": Format(
        title="detections of the MOTChallenge", endings=(".det.txt", "det.txt"),
        read="mot:read:detections", write="mot:write:detections", holds=(CONFIDENCES,),
        guess=None,
    ),
    "otb": Format(
        title="truth of OTB", endings=(".otb.txt", "groundtruth_rect.txt"), read="truth:read:otb",
        write="truth:write:otb", single=True,
    ),
    "vot": Format(
        title="truth of VOT", endings=(".vot.txt", "groundtruth.txt"), read="truth:read:vot",
        write="truth:write:vot", holds=(ANGLES,), single=True,
    ),
    "lasot": Format(title="truth of LaSOT", read="truth:read:lasot", single=True),
    "got10k": Format(title="truth of GOT-10k", read="truth:read:got10k", single=True),
    "coco": Format(
        title="COCO", endings=(".json",), read="coco:read", write="coco:write",
        holds=(CONFIDENCES, IDENTITIES, CLASSES, HIDDEN, MASKS, TIMES), sized=True, certain=True,
        guess=UNSEEN,
    ),
    "cvat": Format(
        title="CVAT for video 1.1", endings=(".xml",), read="cvat:read", write="cvat:write",
        holds=(IDENTITIES, CLASSES, HIDDEN), sized=True, thinned=True, guess=UNSEEN,
    ),
    "yolo": Format(
        title="labels of YOLO", endings=(".yolo", "labels"), read="yolo:read",
        write="yolo:write:labels", holds=(CLASSES,), sized=True, folder=LABELS, folders=("labels",),
        certain=True,
    ),
    "yolo-predictions": Format(
        title="labels of YOLO with confidences", read="yolo:read", write="yolo:write:predictions",
        holds=(CONFIDENCES, CLASSES), sized=True, folder=LABELS, folders=("labels",),
        certain=True, guess=None,
    ),
    "masks": Format(
        title="masks, PNG", endings=("masks",), write="masks:write", holds=(MASKS,), sized=True,
        folder=(".png",), single=True,
    ),
    "label-studio": Format(
        title="Label Studio, video", endings=(".ls.json",),
        read="label_studio:read", write="label_studio:write",
        holds=(IDENTITIES, CLASSES, TIMES), sized=True, thinned=True,
    ),
    "deeplabcut": Format(
        title="DeepLabCut's CSV", endings=(".dlc.csv",), write="deeplabcut:write",
        holds=(ANGLES, CONFIDENCES, IDENTITIES), guess=None,
    ),
    "keyframes": Format(
        title="keyframes for motes track", endings=(".keyframes.csv", "keyframes.csv"),
        read="keyframes:read", write="keyframes:write", holds=(ANGLES,), thinned=True, single=True,
        certain=True,
    ),
    "journal": Format(
        title="rows of a run that was killed", endings=(".rows.jsonl",), read="rows:read_journal",
        holds=ASPECTS, guess=None,
    ),
}  # fmt: skip
"""The formats of motes, by name."""
FORMATS = Registry[Format]("format", "motes.formats", Format, OWN, values=True)
"""All formats, those of other packages included."""

NAMED = ("otb", "vot", "mot-truth", "mot-detections")
"""Formats of numbers alone, which the ending of a name tells apart."""
LATE = 1.0
"""Seconds after the film's last frame at which no row of it is."""
SNIFFED = 1 << 16
"""Bytes of a file in which its format is looked for."""
_RESULT = re.compile(r'"(image|video)_id"\s*:')
_TASK = re.compile(r'"(result|predictions|data)"\s*:')
"""What results of COCO have, and tasks of Label Studio."""
FOREIGN = {
    '"items":': "a dataset of Datumaro", '"shapes":': "a picture of labelme",
    '"regions":': "a project of VIA", '"fname":': "a project of VIA",
    '"slots":': "a file of Darwin", '"classTitle":': "a file of Supervisely",
    "<annotation>": "a picture of Pascal VOC",
}  # fmt: skip
"""Documents that are not read, by a key or an element that they have."""
ADVICE = "correct it there, or make the file anew."


def _by_ending(path: str | Path) -> list[str]:
    """Return the names of the formats whose ending a file's name has, the longest ending first.

    Other packages are asked only where a name has no ending of ours, or several endings.
    """
    name = Path(path).name.lower()

    def fitting(formats: Mapping[str, Format]) -> list[str]:
        lengths = {
            known: len(ending)
            for known, form in formats.items()
            for ending in form.endings
            if name == ending or (ending[0] == "." and name.endswith(ending))
        }
        return sorted(lengths, key=lambda known: -lengths[known])

    own = fitting(OWN)
    return own if own and name.count(".") == 1 else fitting(FORMATS.usable())


def format_for(output: str) -> str:
    """Return the name of the format that a file's name chooses for writing.

    Raises a ConfigError if no format has this ending.
    """
    for name in _by_ending(output):
        if FORMATS.resolve(name).write is not None:
            return name
    endings = (end for form in FORMATS.usable().values() if form.write for end in form.endings)
    usual = [end for end in endings if end.startswith(".") and end.count(".") == 1]
    raise ConfigError(
        f"{output} ends in none of {', '.join(usual)}; rename it, or name its format (--to in "
        f"motes convert, else --format), as yolo for a folder of labels."
    )


def recognized(path: Path) -> str:
    """Return the name of the format of a file or folder, by its content.

    Only a format of another package is recognized by its ending. Raises a SourceError if it cannot
    be read, or its format is not clear from its content and its name.
    """
    named = next(iter(_by_ending(path)), "")
    if named and named not in OWN:
        return named
    if path.is_dir():
        return "masks" if named == "masks" else "yolo"
    if path.suffixes[-2:] == [".run", ".json"]:
        rows = path.with_suffix("").stem
        raise SourceError(f"{path} is the history beside rows; give the rows, {rows}.")
    try:
        _check_not_empty(path)
        with path.open("rb") as file:
            head = file.read(SNIFFED)
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}; check the name.") from None
    try:
        found = "parquet" if head.startswith(b"PAR1") else _of_text(head, path)
    except (ValueError, csv.Error) as error:
        raise SourceError(f"{path}: {error}.") from None
    if found is None:
        raise SourceError(
            f"The format of {path} is not clear; name it: {', '.join(_readable())}. If it is none "
            f"of these, convert it to one with another tool."
        )
    return found


def _readable() -> Iterable[str]:
    return (name for name, form in FORMATS.usable().items() if form.read is not None)


def _of_text(head: bytes, path: Path) -> str | None:
    """Return the format of a text by its beginning; raise a ValueError if it is of none of ours."""
    if head.startswith(b"PK\3\4"):
        raise ValueError("it is a ZIP archive, or a workbook; unpack it, or save its table as CSV")
    if b"\0" in head:
        raise ValueError("it is no text, or one in UTF-16; save it as UTF-8")
    text = head.decode("utf-8-sig", errors="replace").lstrip()
    if "\r" in text and "\n" not in text:
        raise ValueError(OLD_LINES)
    first = text.partition("\n")[0].strip()
    if not first:
        raise ValueError("it is empty; make the file anew")
    if text.startswith("[") and not _TASK.search(text):
        raise ValueError(
            "it is a list of results of COCO, without the images and the names of classes; put it "
            "as annotations into their document"
            if _RESULT.search(text)
            else "it is a list in JSON of another tool; export it as COCO, and what is of Label "
            "Studio as JSON, not JSON-MIN"
        )
    marks = {
        "<": "cvat", "[": "label-studio", '{"motes"': "journal", "{": "coco",
        "scorer,": "deeplabcut",
    }  # fmt: skip
    found = next((form for mark, form in marks.items() if text.startswith(mark)), None)
    if found == "coco" and _is_row(first):
        return "jsonl"
    foreign = found == "coco" and b'"images"' not in path.read_bytes()
    if foreign and '"result":' in text:
        return "label-studio"  # one task without its list
    if foreign or (found == "cvat" and "<annotation>" in text):
        known = (name for mark, name in FOREIGN.items() if mark in text)
        other = next(known, "JSON of another tool")
        raise ValueError(f"it is {other}, which is not read; export or convert it as COCO")
    if found is not None:
        return found
    titles = [title.strip() for title in next(csv.reader([first]), [])]
    if titles[:1] == ["film"] or titles[:5] == ["frame", "x", "y", "width", "height"]:
        return "keyframes"
    if titles == ["frame", *ELLIPSE]:
        return "keyframes"
    kinds = ["time"], ["confidence"], BOX, ELLIPSE
    if "frame" in titles and any({*titles}.issuperset(each) for each in kinds):
        return "csv"
    for mark in ";\t":
        if "frame" in next(csv.reader([first], delimiter=mark), []):
            raise ValueError(SEPARATED.format(mark))
    found = _of_numbers(first, path)
    if found is None and any(each[:1].isalpha() for each in titles[2:]):
        raise ValueError(
            f"its columns are {', '.join(titles)[:80]}; those of boxes are called frame, "
            f"{', '.join(BOX)}"
        )
    return found


def _is_row(line: str) -> bool:
    """Return whether a line is a row in JSON, or the beginning of one of motes."""
    try:
        return "frame" in msgspec.json.decode(line, type=dict[str, Any])
    except (msgspec.MsgspecError, RecursionError):
        return line.startswith('{"frame"')


def _of_numbers(line: str, path: Path) -> str | None:
    """Return the format of a text of numbers, by its first line and the name of the file."""
    if line.startswith("m"):
        return "vot"
    words = re.findall(r"[^,;\s]+", line)
    if words[1:] == ["absent"]:
        return "keyframes"
    try:
        values = [float(word) for word in words]
    except ValueError:
        return None
    fields_of(line)  # raises an error for decimal commas
    count, name = len(values), path.name.lower()
    own = next((found for found in NAMED if name.endswith(OWN[found].endings)), None)
    if count == 4:
        if own == "otb" or name.startswith("groundtruth_rect"):
            return "otb"
        found = "vot" if name.endswith(".vot.txt") else kind_of(path)
        if found is None:
            raise ValueError(
                "it has four numbers a line, and nothing tells its first pixel; give --from otb if "
                "that is 1, as in most datasets, and --from vot if it is 0"
            )
        return found
    if count == 8 and own is None and values[0] >= 1 and 0 <= values[6] <= 1:
        raise ValueError(
            "it has eight numbers a line; give --from vot for corners, and for frame, id, box, "
            "score and class --from mot-truth, or mot for results"
        )
    if count == 8 or (count > 10 and count % 2 == 0) or math.isnan(values[0]):
        return own or "vot"
    if count in (6, 7, 9, 10) and own in ("mot-truth", "mot-detections") and values[0] >= 0:
        return own
    if count in (5, 6) and "," in line:
        return "keyframes"
    if count in (7, 9, 10) and values[0] >= 0:
        kinds = {9: "mot-truth"}
        return "mot-detections" if values[1] == -1 else kinds.get(count, "mot")
    return None


def _function(name: str | Callable[..., Any]) -> Callable[..., Any]:
    """Return a function of a format; a text names one of motes."""
    if not isinstance(name, str):
        return name
    module, function, *texts = name.split(":")
    return partial(getattr(importlib.import_module(f"motes.formats.{module}"), function), *texts)


def read(path: Path, name: str, facts: FilmFacts) -> Recording:
    """Return the objects in a file of a format.

    Raises a ConfigError if the format cannot be read, or needs the size of the picture; and a
    SourceError if the file cannot be read, or is none of this format, or of another film.
    """
    form = FORMATS.resolve(name)
    if form.read is None:
        raise ConfigError(f"{name} is only written; motes reads {', '.join(_readable())}.")
    if path.exists() and path.is_dir() != bool(form.folder):
        here, wanted = ("a folder", "a file") if path.is_dir() else ("a file", "a folder")
        raise SourceError(f"{path} is {here}, and {name} is {wanted}; check the name.")
    if name in ("yolo", "yolo-predictions", "label-studio") and not facts.width:
        raise ConfigError(f"{path} holds shares of the picture; give its --size or --video.")
    try:
        _check_not_empty(path)
        recorded: Recording = _function(form.read)(path, facts)
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}; check the name.") from None
    except (FormatError, ConfigError) as error:
        text = str(error)
        names = f"{path.parent.name}/{path.name}", path.name  # as readers of folders begin
        rest = next((text.removeprefix(n) for n in names if text.startswith(n)), f": {text}")
        text = text if str(path) in text else f"{path}{rest}"
        raise SourceError(text if ";" in text else f"{text}; {ADVICE}") from None
    except (ValueError, KeyError, IndexError, TypeError, OverflowError) as error:
        raise SourceError(
            f"{path} is damaged, or not of the format {name}: {error}; {ADVICE}"
        ) from None
    _check_film(path, recorded, facts)
    if not recorded.head.width:
        size = {"width": facts.width, "height": facts.height}
        recorded = replace(recorded, head=structs.replace(recorded.head, **size))
    boxes = [each.box for row in recorded for each in row.objects if each.placed]
    if boxes and all(max(box) <= 1 for box in boxes):
        raise SourceError(
            f"{path} has all of its boxes within a pixel, as shares of the picture are; give them "
            f"in pixels."
        )
    width, height = recorded.head.width, recorded.head.height
    notes = list(recorded.notes)
    if 2 * sum(of_corners(box, width, height) is not None for box in boxes) > len(boxes):
        notes.append(
            f"most of its boxes fit into the picture of {width}x{height} only as left, top, right, "
            f"bottom; they are read as left, top, width, height."
        )
    seen = [each for row in recorded for each in row.objects if each.status in SHOWN]
    outside = sum(visible_box(each, recorded.head) is None for each in seen) if width else 0
    if outside:
        notes.append(
            f"the picture of {width}x{height} has nothing of {outside} of its {len(seen)} boxes; "
            f"formats that cut boxes at its border leave these out."
        )
    return replace(recorded, notes=notes)


def _check_film(path: Path, recorded: Recording, facts: FilmFacts) -> None:
    """Raise a SourceError if objects are of another film, by its size, its frames or its length."""
    head = recorded.head
    if facts.width and head.width and (head.width, head.height) != (facts.width, facts.height):
        raise SourceError(
            f"{path} is of a film of {head.width}x{head.height} pixels, not of {facts.width}x"
            f"{facts.height}; give the film that it belongs to."
        )
    last = max((row.frame for row in recorded if row.objects), default=0)
    if facts.frames is not None and last >= facts.frames:
        raise SourceError(
            f"{path} has objects in frame {last}, but the film has {facts.frames} frames; give the "
            f"film that it belongs to."
        )
    last_time = max((row.time for row in recorded), default=0.0)
    if facts.end is not None and last_time > facts.end + LATE:
        raise SourceError(
            f"{path} has times up to {last_time:g}, in seconds, but the film's last frame is at "
            f"{facts.end:g}; correct them, or give the film that they belong to."
        )


def _check_not_empty(path: Path) -> None:
    """Raise a SourceError if a file is empty."""
    if path.is_file() and not path.stat().st_size:
        raise SourceError(f"{path} is empty; {ADVICE}")


class Written(NamedTuple):
    """What of a recording others do not take for seen."""

    missed: int
    """The number of frames that are left out, as a target is lost or searched for there."""
    guesses: int
    """The number of rows that are guesses; their frames are left out too, or they are marked in the
    frames that are written."""
    unknown: int = 0
    """The number of frames that nobody has looked at, and that have a line in a truth: absent."""
    marked: bool = False
    """Whether guesses are marked, as hidden objects."""

    @property
    def missed_told(self) -> str:
        """What a target is in the frames that are left out."""
        return "lost or searched for" + ", or guessed" * (self.guesses > 0 and not self.marked)

    @property
    def guesses_told(self) -> str:
        """What has become of guesses, in a few words; "" without any."""
        if not self.guesses:
            return ""
        become = "marked" if self.marked else "left out"
        number = f"{self.guesses} guess{'es' * (self.guesses != 1)}"
        return f"{number} {become} (interpolated, or confidence below {SURE})"


def frames_told(form: str, recorded: Recording) -> str:
    """Return what a tool needs so that its frames are those of a written file; "" for nothing."""
    names = [row.file or "" for row in recorded]
    if form == "cvat" and names != sorted(names):
        from motes.formats.cvat import ORDER  # not where a run begins

        return ORDER
    if form == "label-studio":
        return (
            'Label Studio has a rate of its own; give its tag Video framerate="$fps", so that its '
            "frames are those of the film."
        )
    return ""


def write(
    path: Path,
    name: str,
    recorded: Recording,
    keyframe_error: float | None = None,
    *,
    guesses: bool = False,
) -> Written:
    """Write a file or folder of a format, complete or not at all.

    Raises a ConfigError if the format cannot be written, or needs the size of the picture; a
    FormatError if the format cannot hold these objects; and an OSError if the file cannot be
    written; what was at `path` stays. `keyframe_error` is the largest deviation of what a tool
    interpolates between keyframes, in pixels. With `guesses`, these are written as if they were
    seen. Returns what others do not take for seen.
    """
    form = FORMATS.resolve(name)
    if form.write is None:
        raise ConfigError(f"Files of the format {name} cannot be written.")
    if form.sized and not recorded.head.width:
        raise ConfigError(f"{name} needs the size of the picture; give --size or --video.")
    thin = {} if keyframe_error is None or not form.thinned else {"keyframe_error": keyframe_error}
    told, count = recorded, 0
    if form.guess is not None and not guesses:
        told, count = marked(recorded, form.guess)
    kept = certain(told) if form.certain else told
    if count and HIDDEN in form.holds:
        there = {row.frame for row in kept}
        before = (each for row in recorded if row.frame in there for each in row.objects)
        count = sum(each.guessed for each in before)
    pieces = _function(form.write)(kept, **thin)
    if form.folder:
        check_folder(path, form)
        check_images([row.file for row in kept if row.file])
        write_folder(path, pieces)
    else:
        write_whole(path, pieces)
    frames = [row.frame + 1 for row in recorded]
    unknown = max([recorded.length, *frames]) - len(frames) if name in ("otb", "vot") else 0
    missed = len(recorded.frames) - len(kept.frames)
    return Written(missed, count, unknown, HIDDEN in form.holds)


def check_images(files: Iterable[str]) -> None:
    """Raise a FormatError if a folder of a format would have one file for two images."""
    seen = dict[str, str]()
    for file in files:
        other = seen.setdefault(Path(file).stem, file)
        if other != file:
            raise FormatError(
                f"The images {other} and {file} have one name but for their ending, so that a file "
                f"would be of both; rename one."
            )


def check_folder(path: Path, form: Format) -> None:
    """Check that nothing but files of a format is lost if a folder is made anew.

    Raises a FormatError if the folder holds other files, or is the current one.
    """
    if not path.is_dir():
        return
    if path.samefile("."):
        raise FormatError(f"{path} is the current folder; name another one.")
    for each in path.rglob("*"):
        plain = each.is_dir() and not each.is_symlink() and each.name in form.folders
        if not plain and (each.is_dir() or each.suffix not in form.folder):
            raise FormatError(
                f"{path} would be replaced, but holds {each.relative_to(path)}, which is no part "
                f"of {form.title}; choose another name."
            )


def lost(present: set[str], source: str, target: str) -> list[str]:
    """Return those of `present` that the format `target` does not hold.

    Times are lost if the format `source` holds them. It may hold more than motes writes, such as
    the angles of CVAT's rectangles.
    """
    held, kept = (FORMATS.resolve(name).holds for name in (source, target))
    told = present if TIMES in held else present - {TIMES}
    return [each for each in ASPECTS if each in told and each not in kept]
