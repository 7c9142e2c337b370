"""The frames of a film by the names of its images, as annotation tools write them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from motes.core.errors import FormatError
from motes.formats.recording import UNKNOWN, FilmFacts
from motes.rows.schema import text_name

NO_IMAGE = "the film has no image of this name; give the film that it belongs to."
OF_VIDEO = re.compile(r"frame_\d+")
"""The name that CVAT, and motes, give to a frame of a video: it counts from 0."""
_OF_ANOTHER = re.compile(r"frame_\d{6}(_\d+)+")
"""That of a frame which has its name from another video already: CVAT adds a number."""
_ROBOFLOW = re.compile(r"_(jpe?g|png|bmp|webp|tiff?)\.rf\.\w+$", re.IGNORECASE)
_UPLOADED = re.compile(r"^[0-9a-f]{8}-")
"""What Label Studio puts before the name of a file."""
_NUMBER = re.compile(r"[^0-9a-zA-Z]*\d+\D*$")
_OF_ANY = "frame", "frames", "image", "images", "img", "im", "picture"
"""Names that tools give to the images of any film."""
_HASH = re.compile(r"(?=[0-9a-f]{6,}$)[a-f]*[0-9]+[a-f]+[0-9a-f]*", re.IGNORECASE)
"""A hash: hexadecimal digits, with letters after a number."""


def images_of(facts: FilmFacts) -> dict[str, int]:
    """Return the frames of the images of a folder, by their names without endings."""
    names = [text_name(Path(file).stem) for file in facts.files]
    frames = {name: frame for frame, name in enumerate(names)}
    for frame, name in enumerate(names):
        if frames[name] != frame:
            raise FormatError(
                f"{facts.source} has several images {name}, so that a text is of none of them"
            )
    return frames


def check_one_film(**marks: Iterable[object]) -> None:
    """Raise a FormatError if images are of several films, by one of their marks."""
    for what, each in marks.items():
        found = sorted({str(mark) for mark in each if mark is not None})
        if len(found) > 1:
            raise FormatError(
                f"its images are of several films, by their {what}, as {found[0]} and {found[1]}; "
                f"keep those of one."
            )


def note_on_names(names: Iterable[str], facts: FilmFacts) -> list[str]:
    """Return a note if images of a video have names like those of another video.

    They are names without endings, of frames that their numbers tell. Raises a FormatError if they
    are named like several videos.
    """
    if facts.files:
        return []
    film = text_name(Path(facts.source).stem)
    names = [*names]
    plain = (_UPLOADED.sub("", _ROBOFLOW.sub("", name)) for name in names)
    heads = {_NUMBER.sub("", name) for name in plain} - {"", *_OF_ANY}
    if len(heads) < len(names):  # else each name has something of its own, such as a time
        check_one_film(names=heads)
    if len(heads) != 1 or heads <= {film} or film == UNKNOWN:
        return []
    return [f"its images are named {heads.pop()}; if that is another film than {film}, give it."]


def frame_of(name: str, images: Mapping[str, int]) -> int | None:
    """Return the frame of an image by its name without ending; None if it has no number.

    Raises a FormatError if the film is a folder of images, and none has this name; or if the name
    is one of several videos, or ends in a hash, which says nothing. `images` has the frames of the
    film's images by their names; none of a video.
    """
    exported = _ROBOFLOW.sub("", name)
    plain = _UPLOADED.sub("", exported)
    for known in (name, exported, plain):
        if known in images:
            return images[known]
    if _OF_ANOTHER.fullmatch(name):
        raise FormatError(
            "CVAT names the frames of a project's second video so; export the task of one."
        )
    number = re.search(r"(\d+)\D*$", plain)
    if number is None:
        return None
    if images and not OF_VIDEO.fullmatch(plain):
        raise FormatError(NO_IMAGE)
    if _HASH.fullmatch(re.split(r"[^0-9a-zA-Z]", plain)[-1]):
        raise FormatError("its name ends in a hash; give --video FOLDER with the images.")
    return int(number[1])
