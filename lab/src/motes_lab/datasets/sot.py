"""Sequences with ground truth: layouts of OTB, VOT and GOT-10k, masks, and single videos.

A sequence is a folder with its frames in `img/`, in `color/` or in the folder itself, and with its
truth:

| truth | layout | first pixel |
|---|---|---|
| `groundtruth_rect.txt`, or `groundtruth_rect.1.txt` … | OTB | 1 |
| `groundtruth.txt`, and marks of VOT | VOT | 0 |
| `groundtruth.txt` without these marks | GOT-10k, LaSOT | 1 |
| images in `masks/`, as in DAVIS | | |

The first of these in a folder is used. Numbered files of OTB hold one target each and make the
sequences NAME-1 …; in GOT-10k, `absence.label` has a 1 for each frame without the target, in LaSOT
`full_occlusion.txt` or `out_of_view.txt`. `motes.formats.truth` describes the text files.

The first pixel is the number of the first row and column in the truth: 1 in OTB (Wu, Lim and Yang,
CVPR 2013) and in GOT-10k (according to its authors), while VOT's toolkit uses its regions as
indices from 0. The marks of VOT are `color/`, the file `sequence`, a `camera_motion` tag, and
polygons or masks in the truth.

A dataset is a folder of such folders; with a file `list.txt`, only the folders named in it. It may
also hold films with the truth beside each: `cup.mp4` and `cup.txt`, such a text or
rows of motes, the first pixel 0.
"""

from __future__ import annotations

import glob
import hashlib
import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from motes import ConfigError, FormatError, MotesError, SourceError, open_source
from motes.core import read_text
from motes.correction import History
from motes.formats import absences, kind_of
from motes.rows import text_name
from motes.video import IMAGE_ENDINGS
from motes_lab.datasets.truth import read_mask, read_truth

FILM_ENDINGS = (".mp4", ".mkv", ".mov", ".m4v", ".avi", ".webm", ".mpg", ".wmv")
"""Endings of the films that a dataset may hold."""
S = TypeVar("S")


@dataclass(frozen=True, slots=True, eq=False)
class Sequence:
    """One object in one video.

    All frames are kept, including those before the first one with the target, where a tracker
    starts.
    """

    name: str
    """Unique in its dataset."""
    source: str | Path
    """The source for `open_source`."""
    boxes: NDArray[np.float64]
    """(frames, 4): x, y, width, height, 0-based; NaN where the target is absent. If the source is
    images, their number equals that of the boxes; the number of frames of a video is known only
    after decoding."""
    ellipses: NDArray[np.float64]
    """(frames, 5): x, y, a, b, theta, see `TruthRegion`; NaN where the target is absent."""

    @property
    def frames(self) -> int:
        """Number of frames of the truth."""
        return len(self.boxes)

    @property
    def digest(self) -> str:
        """A digest that changes with the truth."""
        return hashlib.sha256(self.boxes.tobytes()).hexdigest()


@dataclass(frozen=True, slots=True)
class Problem:
    """A failure that did not stop the rest of the work."""

    where: str
    """What failed, such as "sequence David"."""
    what: str
    """The reason, in one line."""


class _Entry(NamedTuple):
    """A folder or a video that looks like a sequence, with its truth if it has one."""

    name: str
    place: Path
    truth: Path | None


def load_dataset(
    path: str | Path, first_pixel: Mapping[str, int] = {}, annotation: str | Path | None = None
) -> tuple[list[Sequence], list[Problem]]:
    """Load the sequences of a dataset, and report those that could not be loaded.

    Parameters
    ----------
    path
        A folder of sequences, the folder of one sequence, or, with an annotation, a video or a
        folder of images.
    first_pixel
        The number of the first row and column in the truth, 0 or 1, for sequences whose names match
        a pattern such as "seg-*"; the last pattern that matches is used. The default is that of the
        layout, and 0 with an annotation.
    annotation
        The truth of one video: such a text, rows of motes, or a folder of masks.

    Returns
    -------
    sequences, problems
        In the order of `list.txt`, else of their names. One of the two may be empty, but not both.

    Raises
    ------
    SourceError
        If the dataset or annotation does not exist, or contains nothing that looks like a sequence.
    ConfigError
        If a pattern matches no sequence, or a first pixel is neither 0 nor 1.
    """
    # Absolute: the relative name 0001 would be read as the number of a camera.
    root = Path(os.path.abspath(path))
    for needed in (path, annotation):
        if needed is not None and not os.path.exists(needed):
            raise SourceError(f"There is no file or folder {needed}; check the name.")
    if annotation is not None:
        name = text_name(root.name if root.is_dir() else root.stem)
        entries = [_Entry(name, root, Path(annotation))]
    elif root.is_dir():
        entries = _entries(root)
    else:
        raise SourceError(f"{path} is one file; give the truth for it as well, as an annotation.")
    if not entries:
        raise SourceError(
            f"There is no sequence in {path}; a sequence is a folder with frames and a "
            f"groundtruth_rect.txt, groundtruth.txt or masks/, or a film with a text of its name."
        )
    for pattern, pixel in first_pixel.items():
        if not any(fnmatchcase(entry.name, pattern) for entry in entries):
            raise ConfigError(f"First pixel: {pattern!r} fits no sequence of {path}.")
        if pixel not in (0, 1):
            raise ConfigError(f"First pixel of {pattern!r} is {pixel}; it is 0 or 1.")
    pixels = first_pixel if annotation is None else {"*": 0, **first_pixel}

    def load(entry: _Entry) -> Sequence:
        fitting = [p for pattern, p in pixels.items() if fnmatchcase(entry.name, pattern)]
        return _load(entry, fitting[-1] if fitting else None)

    return load_each((entry.name, partial(load, entry)) for entry in entries)


def load_each(loaders: Iterable[tuple[str, Callable[[], S]]]) -> tuple[list[S], list[Problem]]:
    """Load sequences by name; return those that were loaded, and the problems of the others.

    A repeated name is a problem, as is any MotesError or OSError of a loader.
    """
    sequences: list[S] = []
    problems: list[Problem] = []
    names: set[str] = set()
    for name, load in loaders:
        try:
            if name in names:
                raise FormatError("there are two of this name; rename one")
            names.add(name)
            sequences.append(load())
        except (MotesError, OSError) as error:
            if isinstance(error, OSError):
                error = FormatError(f"{error.filename}: {error.strerror}")
            problems.append(Problem(f"sequence {name}", str(error)))
    return sequences, problems


def _entries(root: Path) -> list[_Entry]:
    """Return what looks like a sequence: the folder itself, or else the folders in it."""
    try:
        truths = _truth_files(root)
        # A folder of sequences may contain one with the name masks.
        if any(truth.is_file() for truth in truths.values()) or (
            truths and _image_files(_frames_folder(root))
        ):
            return _entries_of_folder(root)
        listed = (root / "list.txt").is_file()
        if listed:
            names = [line.strip() for line in read_text(root / "list.txt").splitlines()]
            folders = [root / name for name in names if name]
        else:
            folders = sorted(p for p in root.iterdir() if p.is_dir() and p.name[0] != ".")
    except OSError as error:
        raise SourceError(f"{error.filename} cannot be read: {error.strerror}.") from None
    entries = [entry for folder in folders for entry in _entries_of_folder(folder, listed)]
    return entries if listed else entries + _films(root)


def _films(root: Path) -> list[_Entry]:
    """Return the films in a folder that have a truth of their name beside them."""
    return [
        _Entry(text_name(film.stem), film, film.with_suffix(".txt"))
        for film in sorted(root.iterdir())
        if film.suffix.lower() in FILM_ENDINGS and film.with_suffix(".txt").is_file()
    ]


def _entries_of_folder(folder: Path, listed: bool = False) -> list[_Entry]:
    """Return the sequences of a folder; none if it has files, but neither truth nor frames."""
    name = text_name(folder.name)
    bare = [_Entry(name, folder, None)]
    try:
        if truths := _truth_files(folder):
            return [_Entry(name + suffix, folder, path) for suffix, path in truths.items()]
        return (
            bare
            if listed or _image_files(_frames_folder(folder)) or not any(folder.iterdir())
            else []
        )
    except (OSError, ValueError):  # as of a name with a NUL; loading raises or refuses it again
        return bare


def _truth_files(folder: Path) -> dict[str, Path]:
    """Return the truth in a folder, by the suffix that it adds to the sequence's name."""
    numbered = {
        f"-{match[1]}": path
        for path in sorted(folder.glob("groundtruth_rect.*.txt"))
        if (match := re.fullmatch(r"groundtruth_rect\.(\d+)\.txt", path.name))
    }
    if (plain := folder / "groundtruth_rect.txt").exists():
        return {"": plain}
    others = [path for path in (folder / "groundtruth.txt", folder / "masks") if path.exists()]
    return numbered or ({"": others[0]} if others else {})


def _load(entry: _Entry, first_pixel: int | None) -> Sequence:
    """Load a sequence; a first pixel of None means that of the layout.

    Raises
    ------
    MotesError, OSError
        If it cannot be loaded.
    """
    name, place, truth = entry
    if not place.exists():
        raise FormatError("list.txt contains it, but there is no such folder")
    if place.is_dir() and not any(place.iterdir()):
        raise FormatError("the folder is empty")
    if truth is None:
        raise FormatError("it has no truth; add groundtruth_rect.txt, groundtruth.txt or masks/")
    source, count = (place, None) if place.is_file() else series_source(_frames_folder(place))
    regions = [read_mask(path) for path in _series(truth)] if truth.is_dir() else read_truth(truth)
    if count not in (None, len(regions)):
        raise FormatError(f"{truth.name} is for {len(regions)} frames, but there are {count}")
    if truth.is_file() and (known := History.beside(truth)) is not None:
        with open_source(source) as film:
            known.check(film)
    boxes = np.array([region.box for region in regions], np.float64).reshape(-1, 4)
    ellipses = np.array([region.ellipse for region in regions], np.float64).reshape(-1, 5)
    kind = kind_of(truth) if truth.name == "groundtruth.txt" else None
    absent = absences(kind or "", place, len(regions))
    boxes[absent] = ellipses[absent] = np.nan
    if np.isnan(boxes).all():
        raise FormatError(f"{truth.name} has no frame with a target")
    if not truth.is_dir():
        if first_pixel is None:
            polygons = truth.name == "groundtruth.txt" and not all(each.is_box for each in regions)
            vot = kind == "vot" or (kind is None and polygons)
            first_pixel = 0 if place.is_file() or vot else 1
        boxes[:, :2] -= first_pixel
        ellipses[:, :2] -= first_pixel
    return Sequence(name, source, boxes, ellipses)


def _frames_folder(folder: Path) -> Path:
    """Return the folder of a sequence's frames."""
    return next((folder / name for name in ("img", "color") if (folder / name).is_dir()), folder)


def _image_files(folder: Path) -> list[Path]:
    """Return the files that `open_source` reads as the images of a folder."""
    return [
        path
        for path in folder.iterdir()
        if path.suffix.lower() in IMAGE_ENDINGS and path.name[0] != "."
    ]


def series_source(folder: Path) -> tuple[str | Path, int]:
    """Return a source of the frames in a folder, without other images there, and their number."""
    series, pictures = _series(folder), _image_files(folder)
    if len(series) == len(pictures):
        return folder, len(series)
    stray = min(set(pictures) - set(series))
    stem = re.sub(r"\d+$", "", series[0].stem)
    pattern = glob.escape(os.path.join(folder, stem)) + f"[0-9]*{series[0].suffix}"
    if {Path(name) for name in glob.glob(pattern)} != set(series):
        raise FormatError(f"{stray.name} is among the frames, but not one of them; move it away")
    return pattern, len(series)


def _series(folder: Path) -> list[Path]:
    """Return the images in a folder that belong to one numbered series, in order.

    Raises
    ------
    FormatError
        If there is none, two series have the same length, or an image in between is missing.
    """
    groups: dict[tuple[str, str] | None, list[tuple[int, Path]]] = {}
    for path in _image_files(folder):
        match = re.fullmatch(r"(.*?)(\d+)", path.stem)
        kind, number = ((match[1], path.suffix), int(match[2])) if match else (None, 0)
        groups.setdefault(kind, []).append((number, path))
    if not groups:
        raise FormatError(f"there are no pictures in {folder.name}/")
    kinds = sorted(groups, key=lambda kind: len(groups[kind]))
    if len(kinds) > 1 and len(groups[kinds[-1]]) == len(groups[kinds[-2]]):
        names = sorted(groups[kind][0][1].name for kind in kinds[-2:])
        raise FormatError(f"frames are either like {names[0]} or like {names[1]}; move the others")
    series = sorted(groups[kinds[-1]])
    if kinds[-1] is not None and len(series) > 1:
        numbers = np.array([number for number, _ in series])
        steps = np.diff(numbers)
        step = max(int(steps.min()), 1)  # 5 if only every fifth frame was kept
        if (gaps := np.flatnonzero(steps > step)).size:
            before = series[gaps[0]][1].stem
            width = len(before) - len(kinds[-1][0])
            missing = f"{kinds[-1][0]}{numbers[gaps[0]] + step:0{width}}{kinds[-1][1]}"
            raise FormatError(f"the frame {missing} is missing after {before}{kinds[-1][1]}")
    return [path for _, path in series]
