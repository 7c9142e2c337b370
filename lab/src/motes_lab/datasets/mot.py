"""Sequences with many objects, in the layout of the MOTChallenge.

A sequence is a folder with these files:

| file | content |
|---|---|
| `seqinfo.ini` | section Sequence: `seqLength`, `frameRate`, and `imDir` if it is not `img1` |
| `gt/gt.txt` | the truth, in the format of `motes.formats.mot` |
| `det/det.txt` | detections, the same for all trackers; may be missing |
| `img1/` | the frames; instead, the folder may contain one video |

A dataset is a folder of such folders. The first pixel is 1, as in the tools of the MOTChallenge.
"""

from __future__ import annotations

import configparser
import hashlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from motes import Box, FormatError, Frame, SourceError, open_source
from motes.core import read_text
from motes.rows import text_name
from motes_lab.datasets.distractors import DISTRACTORS, evaluated_rows
from motes_lab.datasets.mot_rows import MotRows, line_of, read_rows, rows_of
from motes_lab.datasets.sot import Problem, load_each, series_source

VIDEO_ENDINGS = frozenset(
    {".avi", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".webm", ".wmv"}
)

NON_MOT_VEHICLE = 6
"""A class that is a distractor in MOT20, but not in MOT16 and MOT17."""


@dataclass(frozen=True, slots=True, eq=False)
class MotSequence:
    """Many objects in one video."""

    name: str
    """Unique in its dataset."""
    source: str | Path
    """The source for `open_source`."""
    frames: int
    """Number of frames."""
    rate: float
    """Frames per second."""
    truth: MotRows
    """All rows of the truth."""
    detections: MotRows | None
    """The detections of the dataset; None if it has none."""

    @property
    def distractors(self) -> tuple[int, ...]:
        """Classes that results may contain without being counted as wrong."""
        return (*DISTRACTORS, NON_MOT_VEHICLE) if self.name.startswith("MOT20") else DISTRACTORS

    def pictures(self) -> Iterator[Frame]:
        """Yield its frames, with the times of its rate."""
        with open_source(self.source, end=self.frames) as source:
            for each in source:
                yield Frame(each.index, each.index / self.rate, each.pixels)

    def compared(self, index: int, found: Iterable[tuple[int, Box]]) -> tuple[MotRows, MotRows]:
        """Return the rows of the truth and of some boxes that are compared in a frame.

        Boxes have identities; the frame counts from 0.
        """
        results = rows_of([line_of(index, identity, box) for identity, box in found])
        truth = self.truth.where(self.truth.frames == index + 1)
        return evaluated_rows(truth, results, self.distractors)

    @property
    def digest(self) -> str:
        """A digest that changes with the truth and the detections."""
        digest = hashlib.sha256(f"{self.frames} {self.rate}".encode())
        for rows in (self.truth, self.detections):
            if rows is not None:
                for column in (rows.frames, rows.ids, rows.boxes, rows.scores, rows.classes):
                    digest.update(column.tobytes())
        return digest.hexdigest()


def has_mot_sequences(path: Path) -> bool:
    """Return whether a folder is a dataset of many objects, or one of its sequences."""
    return path.is_dir() and bool(_folders(path))


def load_mot_dataset(path: Path) -> tuple[list[MotSequence], list[Problem]]:
    """Load the sequences of a dataset, and report those that could not be loaded.

    Returns
    -------
    sequences, problems
        In the order of their names.

    Raises
    ------
    SourceError
        If the folder cannot be read, or there is no sequence in it.
    """
    if not path.exists():
        raise SourceError(f"There is no file or folder {path}; check the name.")
    if not (folders := _folders(Path(os.path.abspath(path)))):
        raise SourceError(
            f"There is no sequence of many objects in {path}; it is a folder with seqinfo.ini and "
            f"gt/gt.txt."
        )
    return load_each((text_name(folder.name), partial(_load, folder)) for folder in folders)


def _folders(path: Path) -> list[Path]:
    """Return the folders of sequences: the folder itself, or folders in it."""
    try:
        if _is_mot_sequence(path):
            return [path]
        inner = sorted(p for p in path.iterdir() if p.is_dir() and p.name[0] != ".")
    except OSError as error:
        raise SourceError(f"{error.filename} cannot be read: {error.strerror}.") from None
    return [folder for folder in inner if _is_mot_sequence(folder)]


def _is_mot_sequence(folder: Path) -> bool:
    return (folder / "seqinfo.ini").exists() or (folder / "gt" / "gt.txt").exists()


def _load(folder: Path) -> MotSequence:
    frames, rate, pictures = _information(folder)
    source: str | Path
    if pictures.is_dir():
        source, count = series_source(pictures)
        if count != frames:
            raise FormatError(f"seqinfo.ini has {frames} frames, but {pictures.name}/ has {count}")
    else:
        source = _video(folder, pictures.name)
    if not (folder / "gt" / "gt.txt").exists():
        raise FormatError("it has no truth; add a file gt/gt.txt")
    found = folder / "det" / "det.txt"
    sequence = MotSequence(
        text_name(folder.name),
        source,
        frames,
        rate,
        read_rows(folder / "gt" / "gt.txt", frames, "truth"),
        read_rows(found, frames, "detections") if found.exists() else None,
    )
    if not len(evaluated_rows(sequence.truth, sequence.truth, ())[0].frames):
        raise FormatError("gt/gt.txt has no row that counts")
    return sequence


def _information(folder: Path) -> tuple[int, float, Path]:
    """Return the number of frames, the frame rate, and the folder of the frames."""
    if not (folder / "seqinfo.ini").exists():
        raise FormatError("it has no seqinfo.ini; add one with seqLength and frameRate")
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(read_text(folder / "seqinfo.ini", FormatError))
        section = parser["Sequence"]
        frames, rate = int(section["seqLength"]), float(section["frameRate"])
    except (configparser.Error, ValueError) as error:
        raise FormatError(f"seqinfo.ini is not valid: {' '.join(str(error).split())}") from None
    except KeyError as error:
        raise FormatError(f"seqinfo.ini does not have {error}") from None
    if not (frames > 0 and 0 < rate < float("inf")):
        raise FormatError(f"seqinfo.ini has {frames} frames at {rate:g} frames per second")
    return frames, rate, folder / section.get("imDir", "img1")


def _video(folder: Path, pictures: str) -> Path:
    videos = [path for path in folder.iterdir() if path.suffix.lower() in VIDEO_ENDINGS]
    if len(videos) != 1:
        raise FormatError(f"it has no folder {pictures}/, and {len(videos) or 'no'} videos instead")
    return videos[0]
