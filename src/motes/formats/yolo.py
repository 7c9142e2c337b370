"""YOLO's labels: a folder with a text for each frame in `labels`, which Ultralytics trains with.

`data.yaml` has the names of the classes, and `train.txt` the images in `images`, which motes does
not write: their texts are where theirs is if `labels` stands for `images`. Without a `path`, all of
this is looked for beside `data.yaml`. https://docs.ultralytics.com/datasets/detect/

A line is class, center x, center y, width and height, in shares of the picture's sides. Predictions
have the confidence as a sixth number, which trainers refuse. More than six numbers are a polygon to
them, so identities have no place.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import msgspec

from motes.core.errors import FormatError
from motes.core.files import lines_of, read_text
from motes.core.geometry import Ellipse
from motes.core.track import Track
from motes.formats.image_names import frame_of, images_of, note_on_names
from motes.formats.recording import ANONYMOUS, UNTIMED, FilmFacts, Recording, sound
from motes.formats.shapes import image_of, label_or_none, labels_of, stem_of, visible_box
from motes.formats.text import at, number, whole
from motes.formats.visibility import visible
from motes.rows.schema import text_name

NAMES = "data.yaml"
CLASSES, DARKNET = "classes.txt", "obj.names"
"""Files with a class in each line; CVAT has the second one beside a folder of YOLO 1.1."""
LABELS = "labels"
"""The folder of the texts."""
SAID = 3
"""Folders of texts that an error names; the others are counted."""
IMAGES = "train.txt"
HEAD = f"""# The images that {IMAGES} lists belong into the folder images.
train: {IMAGES}
val: {IMAGES}
"""


def write(
    kind: Literal["labels", "predictions"], recorded: Recording
) -> Iterator[tuple[str, bytes]]:
    """Yield names and contents of files: a text for each frame, and what is common to them.

    These are the list of their images, and the names of the classes. In predictions, a line ends
    with the confidence.
    """
    head = recorded.head
    every = [each.label or head.label for row in recorded for each in row.objects]
    numbers = {name: number for number, name in enumerate(labels_of(every, head))}
    for row in recorded:
        lines = []
        for each in visible(row):
            box = visible_box(each, head)  # trainers refuse a text with shares beyond 0 to 1
            if box is None:
                continue
            shares = (
                (box.left + box.right) / 2 / head.width,
                (box.top + box.bottom) / 2 / head.height,
                (box.right - box.left) / head.width,
                (box.bottom - box.top) / head.height,
            )
            fields = [str(numbers[each.label or head.label]), *(f"{share:.8f}" for share in shares)]
            fields += [f"{each.confidence:.5f}"] if kind == "predictions" else []
            lines.append(" ".join(fields) + "\n")
        yield f"{LABELS}/{stem_of(row)}.txt", "".join(lines).encode()
    images = "".join(f"./images/{Path(image_of(row)).name}\n" for row in recorded)
    yield IMAGES, images.encode()
    quoted = {name.replace("'", "''"): number for name, number in numbers.items()}
    names = "".join(f"  {number}: '{name}'\n" for name, number in quoted.items())
    yield NAMES, f"{HEAD}nc: {len(numbers)}\nnames:\n{names}".encode()


def read(path: Path, facts: FilmFacts) -> Recording:
    """Return the objects of a folder of labels, which are in it or in its folder `labels`.

    Of a folder of images, a text belongs to the image of its name. Of a video, its frame is the
    last number in its name, from 0; but Ultralytics counts from 1, in the video's name and "_1".
    """
    path = _labels(path)
    names, images = _names(path), images_of(facts)
    stem = Path(facts.source).stem
    from_one = not images and not (path / f"{stem}_0.txt").exists()
    theirs = re.compile(rf"(?!frame_\d{{6}}){re.escape(stem)}_[1-9]\d*")
    left_out = [f"the texts in its folder {part}" for part in _parts(path)]
    objects, lines, stems, ended = [], [], dict[int, str](), dict[bool, str]()
    for file in sorted(path.glob("*.txt")):
        if not file.is_file():
            raise FormatError(f"{file.name} is not a file")
        with at(file.name):
            frame = frame_of(text_name(file.stem), images)
        if frame is not None and from_one and theirs.fullmatch(file.stem):
            frame -= 1
        if frame is None:
            if file.name != CLASSES:
                left_out.append(f"{file.name}, whose name has no number of a frame")
            continue
        if frame in stems:
            raise FormatError(f"{file.name}: another file is of frame {frame} too")
        stems[frame] = file.stem
        text = read_text(file, FormatError)
        if text.strip():
            ended.setdefault(text.endswith("\n"), file.name)
        for place, line in enumerate(lines_of(text), start=1):
            if line.strip():
                lines.append((f"{file.name}, line {place}", frame, line.split()))
    tracked, either = _sixth_numbers([(frame, fields) for _, frame, fields in lines])
    for where, frame, fields in lines:
        with at(where):
            objects.append(_row(frame, fields, names, facts, tracked=tracked))
    if len(ended) > 1:  # some tools end the last line of no text; then a cut cannot be told
        raise FormatError(
            f"{ended[False]}: its last line has no end, unlike those of other texts, so it may be "
            f"cut off there; if it is whole, end the line"
        )
    if not stems:
        if parts := _parts(path):
            which = "one of these folders" if len(parts) > 1 else "that folder"
            more = [f"{len(parts) - SAID} more"] * (len(parts) > SAID)
            named = " and ".join(parts[:SAID] + more)
            raise FormatError(f"its labels are in {named}; give {which}")
        raise FormatError(
            "it has no labels of YOLO, texts named after frames, or after images that --video "
            "names; of other formats give a file, and convert one for each picture, as of labelme, "
            "to COCO first"
        )
    notes = note_on_names(stems.values(), facts)
    shifted = from_one and any(map(theirs.fullmatch, stems.values()))
    if not images and not shifted and min(stems) == 1:
        notes.append(
            "frames are the numbers in its names, from 0; if these count from 1, give --video: the "
            "folder of the images, or the film that they are named after."
        )
    if either:
        taken = "identities" if tracked else "confidences"
        notes.append(f"the sixth numbers of its lines, 0 or 1, are read as {taken}.")
    found = Recording.of(facts, objects, dict.fromkeys(stems), left_out=left_out)
    return replace(found, notes=notes)


def _sixth_numbers(lines: list[tuple[int, list[str]]]) -> tuple[bool, bool]:
    """Return whether the sixth numbers of lines are identities, and whether that is not certain.

    One that is above 1 is no confidence. Where all are 0 or 1, as of one object that is tracked,
    they are confidences if a frame has one of them twice, or if all are 0.
    """
    sixth = [(frame, fields[5]) for frame, fields in lines if len(fields) == 6]
    whole_ones = [float(text) for _, text in sixth if text.isdecimal()]
    if not whole_ones or any(len(fields) > 6 for _, fields in lines):
        return False, False
    if max(whole_ones) > 1:
        return True, False
    either = len(whole_ones) == len(sixth)
    return either and max(whole_ones) == 1 and len({*sixth}) == len(sixth), either


def _row(
    frame: int, fields: list[str], names: dict[int, str], facts: FilmFacts, *, tracked: bool
) -> Track:
    label, *rest = fields
    if len(rest) not in (4, 5, 6):
        raise ValueError(
            f"{1 + len(rest)} numbers; a line has 5, or 6 or 7 with confidence and id; outlines, "
            f"turned boxes and poses are not read"
        )
    if tracked and len(rest) == 5:
        rest.insert(4, "1")
    x, y, width, height, *more = (number(value) for value in rest)
    if not all(-1 <= center <= 2 for center in (x, y)):
        raise ValueError(f"the center {x:g}, {y:g} is not a share of the picture's sides, 0 to 1")
    box = (
        (x - width / 2) * facts.width,
        (y - height / 2) * facts.height,
        width * facts.width,
        height * facts.height,
    )
    if not min(box[2:]) > 0:
        raise ValueError("the object has no area")
    identity = whole(rest[5]) if len(more) == 2 else ANONYMOUS
    number_of_class = whole(label)
    if number_of_class < 0 or (names and number_of_class not in names):
        raise ValueError(f"there is no class {label}; the file of names has {len(names)}")
    name = label_or_none(names.get(number_of_class, f"class {number_of_class}"), facts.label)
    confidence = more[0] if more else 1.0
    return sound(Track(
        frame, UNTIMED, Ellipse.from_box(box), confidence=confidence, identity=identity, label=name
    ))  # fmt: skip


def _labels(folder: Path) -> Path:
    """Return the folder of the texts: `labels`, or the part of a set for training in it."""
    folder = folder / LABELS if (folder / LABELS).is_dir() else folder
    parts = _parts(folder)
    alone = folder.name == LABELS and len(parts) == 1 and not any(folder.glob("*.txt"))
    return folder / parts[0] if alone else folder


def _parts(folder: Path) -> list[str]:
    """Return the folders in a folder that have texts, as of another film or part of a set."""
    texts = itertools.chain(folder.glob("*/*.txt"), folder.glob("*/*/*.txt"))  # as train/labels
    places = {each.parent.relative_to(folder) for each in texts}
    return sorted(place.as_posix() for place in places)


def _names(folder: Path) -> dict[int, str]:
    """Return the names of the classes, by number."""
    for place in (folder / CLASSES, folder.parent / CLASSES, folder.parent / DARKNET):
        if place.is_file():
            lines = lines_of(read_text(place, FormatError))
            return {number: name.strip() for number, name in enumerate(lines)}
    for place in (folder / NAMES, folder.parent / NAMES, folder.parent.parent / NAMES):
        if place.is_file():
            with at(place.name):
                return _yaml_names(read_text(place, FormatError))
    return {}


_QUOTED = r"""'(?:[^'\n]|'')*'|"(?:[^"\\\n]|\\.)*\""""
_COMMENT = re.compile(rf"({_QUOTED})|(?:^|(?<=\s))#.*", re.MULTILINE)
_KEY = re.compile(r"""(?:^|[{,])[ \t]*(["']?)names\1[ \t]*:[ \t]*""", re.MULTILINE)
_SCALAR = rf"({_QUOTED}|[^\][{{}},'\"&*|>\s]"
_ITEM = re.compile(rf"\s*(?:(\d+)\s*:\s*)?{_SCALAR}[^\][{{}},:\n]*?)\s*(,|[\]}}])")
_LINE = re.compile(rf"\s*(?:-|(\d+)\s*:)\s*{_SCALAR}.*?)\s*")
"""Of YAML: quoted text, a comment, the key, and an item of a list in brackets or on a line."""


def _yaml_names(text: str) -> dict[int, str]:
    """Return the `names` of a file in YAML: a list or numbered, in brackets or a line for each."""
    text = _COMMENT.sub(lambda match: match[1] or "", text)
    key = _KEY.search(text)
    if key is None:
        return {}
    found: dict[int, str] = {}

    def add(match: re.Match[str]) -> None:
        found[int(match[1]) if match[1] else len(found)] = _plain(match[2])

    rest = text[key.end() :]
    if rest[:1] in ("[", "{"):
        place, end = 1, ","
        while end == "," and not re.match(r"\s*[]}]", rest[place:]):
            match = _ITEM.match(rest, place)
            if match is None:
                raise FormatError("the list of names has no end, or holds more than names")
            add(match)
            place, end = match.end(), match[3]
        return found
    for line in rest.split("\n")[1:]:
        match = _LINE.fullmatch(line)
        if match is None and line.strip():
            break
        if match is not None:
            add(match)
    if not found:
        raise FormatError("its names are neither a list nor numbered")
    return found


def _plain(text: str) -> str:
    """Return a scalar of YAML without its quotes."""
    if text[0] == '"':
        return str(msgspec.json.decode(text))
    return text[1:-1].replace("''", "'") if text[0] == "'" else text.strip()
