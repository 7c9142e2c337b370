"""Sequences with many objects, in the layout of the MOTChallenge.

A sequence is a folder with

| file | what |
|---|---|
| `seqinfo.ini` | section Sequence: `seqLength`, `frameRate`, and `imDir` if that is not `img1` |
| `gt/gt.txt` | the truth, as `mot_rows` has it |
| `det/det.txt` | what a detector found, the same for all trackers; may be missing |
| `img1/` | the frames; instead, one video may be in the folder |

and a dataset is a folder of such folders. Its first pixel is 1, as in the MOTChallenge's tools.
"""

from __future__ import annotations

import configparser
import hashlib
import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from motes.core.errors import FormatError, SourceError
from motes.evaluation.datasets.distractors import DISTRACTORS, counted
from motes.evaluation.datasets.mot_files import Rows, read_rows
from motes.evaluation.datasets.sot import Problem, gather, printable, read_text, series_source

VIDEO_ENDINGS = frozenset(
    {".avi", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".webm", ".wmv"}
)

NON_MOT_VEHICLE = 6
"""A class that is a distractor in MOT20, and nothing in MOT16 and MOT17."""


@dataclass(frozen=True, slots=True, eq=False)
class MotSequence:
    """Many objects in one video.

    Attributes
    ----------
    name
        Unique in its dataset.
    source
        What `open_source` reads.
    frames
        How many there are.
    rate
        Frames a second.
    truth
        All rows of the truth.
    detections
        What a detector found; None if nobody says.
    """

    name: str
    source: str | Path
    frames: int
    rate: float
    truth: Rows
    detections: Rows | None

    @property
    def distractors(self) -> tuple[int, ...]:
        """Classes that results may show without being wrong."""
        return (*DISTRACTORS, NON_MOT_VEHICLE) if self.name.startswith("MOT20") else DISTRACTORS

    @property
    def digest(self) -> str:
        """Another one for any other truth, or other detections."""
        digest = hashlib.sha256(f"{self.frames} {self.rate}".encode())
        for rows in (self.truth, self.detections):
            if rows is not None:
                for column in (rows.frames, rows.ids, rows.boxes, rows.scores, rows.classes):
                    digest.update(column.tobytes())
        return digest.hexdigest()


def has_crowds(path: Path) -> bool:
    """Return whether a folder is a dataset of many objects, or one of its sequences."""
    return path.is_dir() and bool(_folders(path))


def load_crowds(path: Path) -> tuple[list[MotSequence], list[Problem]]:
    """Load the sequences of a dataset, and say which ones could not be loaded, and why.

    In the order of their names.

    Raises
    ------
    SourceError
        If the folder cannot be read.
    """
    folders = _folders(Path(os.path.abspath(path)))
    return gather((printable(folder.name), partial(_load, folder)) for folder in folders)


def _folders(path: Path) -> list[Path]:
    """Return the sequences: the folder itself, or those in it."""
    try:
        if _is_crowd(path):
            return [path]
        inner = sorted(p for p in path.iterdir() if p.is_dir() and p.name[0] != ".")
    except OSError as error:
        raise SourceError(f"{error.filename} cannot be read: {error.strerror}.") from None
    return [folder for folder in inner if _is_crowd(folder)]


def _is_crowd(folder: Path) -> bool:
    return (folder / "seqinfo.ini").exists() or (folder / "gt" / "gt.txt").exists()


def _load(folder: Path) -> MotSequence:
    frames, rate, pictures = _information(folder)
    source: str | Path
    if pictures.is_dir():
        source, count = series_source(pictures)
        if count != frames:
            raise FormatError(f"seqinfo.ini says {frames} frames, but {pictures.name}/ has {count}")
    else:
        source = _video(folder, pictures.name)
    if not (folder / "gt" / "gt.txt").exists():
        raise FormatError("it has no truth; that would be gt/gt.txt")
    found = folder / "det" / "det.txt"
    crowd = MotSequence(
        printable(folder.name),
        source,
        frames,
        rate,
        read_rows(folder / "gt" / "gt.txt", frames, "truth"),
        read_rows(found, frames, "detections") if found.exists() else None,
    )
    if not len(counted(crowd.truth, crowd.truth, ())[0].frames):
        raise FormatError("gt/gt.txt has no row that counts")
    return crowd


def _information(folder: Path) -> tuple[int, float, Path]:
    """Return the number of frames, how many there are a second, and where they are."""
    if not (folder / "seqinfo.ini").exists():
        raise FormatError("it has no seqinfo.ini, which says seqLength and frameRate")
    parser = configparser.ConfigParser(interpolation=None)
    try:
        parser.read_string(read_text(folder / "seqinfo.ini"))
        section = parser["Sequence"]
        frames, rate = int(section["seqLength"]), float(section["frameRate"])
    except (configparser.Error, ValueError) as error:
        raise FormatError(f"seqinfo.ini makes no sense: {' '.join(str(error).split())}") from None
    except KeyError as error:
        raise FormatError(f"seqinfo.ini does not have {error}") from None
    if not (frames > 0 and 0 < rate < float("inf")):
        raise FormatError(f"seqinfo.ini says {frames} frames, and {rate:g} of them a second")
    return frames, rate, folder / section.get("imDir", "img1")


def _video(folder: Path, pictures: str) -> Path:
    videos = [path for path in folder.iterdir() if path.suffix.lower() in VIDEO_ENDINGS]
    if len(videos) != 1:
        raise FormatError(f"it has no folder {pictures}/, and {len(videos) or 'no'} videos instead")
    return videos[0]
