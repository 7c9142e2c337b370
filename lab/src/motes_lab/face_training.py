"""Train a detector of faces on pictures of one's own: Nummiaro et al., section V."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from motes.core.errors import ConfigError, SourceError
from motes.core.files import write_whole, writing
from motes.core.geometry import Box
from motes.core.optional import optional
from motes.core.types import Bytes
from motes.video.image_files import read_image

PENALTY = 5.0
"""Weight of errors against the width of the margin, C of the support vector machine."""


class Example(NamedTuple):
    """A picture, RGB (H, W, 3), and the boxes of all faces in it; there may be none."""

    picture: Bytes
    faces: tuple[Box, ...]


class Trained(NamedTuple):
    """A detector, as bytes for its file, and how it does on the pictures that trained it."""

    detector: bytes
    precision: float
    recall: float


def read_examples(path: str | Path) -> list[Example]:
    """Read pictures and the faces in them from a CSV file.

    A line is `picture,x,y,width,height` for each face, or `picture` alone if there is none. Names
    of pictures are relative to the file. Empty lines and a first line that begins with `picture,`
    are left out.

    Raises
    ------
    SourceError
        If the file or a picture cannot be read, or a line has another form.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not text"
        raise SourceError(f"{path} cannot be read: {reason}; check the name.") from None
    faces: dict[str, list[Box]] = {}
    for number, row in enumerate(csv.reader(text.splitlines()), start=1):
        if not row or (number == 1 and row[0] == "picture"):
            continue
        name, *values = (value.strip() for value in row)
        boxes = faces.setdefault(name, [])
        if not values:
            continue
        try:
            x, y, width, height = map(float, values)
        except ValueError:
            x = y = width = height = math.nan
        if not (math.isfinite(x + y) and 1 <= width < 1e6 and 1 <= height < 1e6):
            raise SourceError(
                f"{path}, line {number}, is not a face: picture,x,y,width,height; got {row}."
            )
        boxes.append(Box(x, y, width, height))
    if not faces:
        raise SourceError(f"{path} names no picture; write a line for each face.")
    folder = Path(path).parent
    return [Example(read_image(folder / name), tuple(boxes)) for name, boxes in faces.items()]


def train_faces(examples: Sequence[Example], folder: Path) -> Trained:
    """Return a detector of the faces in pictures: gradient histograms and a linear SVM, by dlib.

    Parameters
    ----------
    examples
        Pictures with all of their faces, which are alike in shape. What is outside the boxes is
        learned as no face, so a face without a box does harm.
    folder
        A folder for a temporary file: dlib only writes files.

    Raises
    ------
    MissingDependencyError
        If dlib is not installed.
    ConfigError
        If there is no face, or the boxes differ too much in shape.
    """
    dlib = optional("dlib", "Training on faces needs dlib", "motes[faces]")
    if not any(example.faces for example in examples):
        raise ConfigError("There is no face in the pictures; give the box of at least one.")
    options = dlib.simple_object_detector_training_options()
    options.add_left_right_image_flips = True  # faces are about symmetric
    options.C = PENALTY
    options.num_threads = os.cpu_count() or 1
    pictures = [np.ascontiguousarray(example.picture) for example in examples]
    boxes = [[_rectangle(dlib, box) for box in example.faces] for example in examples]
    try:
        detector = dlib.train_simple_object_detector(pictures, boxes, options)
    except RuntimeError as error:
        raise ConfigError(
            f"dlib cannot learn these boxes ({' '.join(str(error).split())}); give faces of about "
            f"one shape, 20 pixels wide and high or more."
        ) from None
    quality = dlib.test_simple_object_detector(pictures, boxes, detector)
    file = folder / "faces.svm"
    detector.save(str(file))
    return Trained(file.read_bytes(), quality.precision, quality.recall)


def save_detector(trained: Trained, path: Path) -> None:
    """Write a detector; raise a FormatError if the file cannot be written."""
    with writing(path):
        write_whole(path, trained.detector)


def _rectangle(dlib: object, box: Box) -> object:
    """Return a box as dlib's rectangle, whose right and bottom are inside."""
    left, top = round(box.x), round(box.y)
    right, bottom = round(box.x + box.width) - 1, round(box.y + box.height) - 1
    return dlib.rectangle(left, top, right, bottom)  # type: ignore[attr-defined]
