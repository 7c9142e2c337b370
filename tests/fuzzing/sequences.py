"""Files of datasets: regions, lists, labels and seqinfo.ini."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image

from motes.core.errors import MotesError
from motes_lab.datasets.mot import MotSequence, load_mot_dataset
from motes_lab.datasets.sot import Problem, Sequence, load_dataset
from motes_lab.datasets.truth import read_mask

from . import detections, track_rows
from .outcomes import READ, REFUSED, check_finite, check_message, outcome, put, scratch

FRAMES = 6
BOXES = b"".join(b"%d,12,20,15.5\n" % (10 + i) for i in range(FRAMES))

Loaded = tuple[list[Sequence], list[Problem]] | tuple[list[MotSequence], list[Problem]]


@cache
def _dataset(name: str, frames: str) -> Path:
    """Return a folder of one sequence, One, with frames but without truth."""
    pictures = scratch() / name / "One" / frames
    pictures.mkdir(parents=True)
    for index in range(FRAMES):
        Image.new("RGB", (64, 48), (40 * index, 0, 0)).save(pictures / f"{index + 1:04d}.png")
    return scratch() / name


def _outcome(load: Callable[[], Loaded]) -> str:
    """Return what comes of loading a dataset, whose problems are as good as errors."""
    try:
        sequences, problems = load()
    except MotesError as error:
        check_message(str(error))
        return REFUSED
    for problem in problems:
        check_message(problem.what)
    return READ if sequences else REFUSED


def truths() -> list[bytes]:
    return [
        BOXES,
        b"10.5,12,30,14,28,30,9,29\n" * FRAMES,
        b"m3,4,5,6,2,3,4,5,6\n" * FRAMES,
        b"1\n10\t12\t20\t15\nnan,nan,nan,nan\n0,0,0,0\n10 12 20 15\n10;12;20;15\n",
        *track_rows.seeds(),
    ]


def check_truth(data: bytes) -> str:
    """Read the truth of a sequence in the layout of GOT-10k."""
    root = _dataset("got", "img")
    (root / "One" / "groundtruth.txt").write_bytes(data)

    def load() -> Loaded:
        sequences, problems = load_dataset(root)
        for each in sequences:
            there = np.isfinite(each.boxes).all(axis=1)
            check_finite(np.ravel(each.boxes[there]).tolist())
            check_finite(np.ravel(each.ellipses[there]).tolist())
        return sequences, problems

    return _outcome(load)


def lists() -> list[bytes]:
    return [b"One\n", b"One\nTwo\n", b"./One\n"]


def check_list(data: bytes) -> str:
    """Read a dataset's list.txt."""
    root = _dataset("listed", "img")
    (root / "One" / "groundtruth.txt").write_bytes(BOXES)
    (root / "list.txt").write_bytes(data)
    return _outcome(lambda: load_dataset(root))


def labels() -> list[bytes]:
    return [b"0\n0\n1\n0\n0\n0\n", b"1 " * FRAMES]


def check_label(data: bytes) -> str:
    """Read the absence.label of a sequence."""
    root = _dataset("labeled", "img")
    (root / "One" / "groundtruth.txt").write_bytes(BOXES)
    (root / "One" / "absence.label").write_bytes(data)
    return _outcome(lambda: load_dataset(root))


def information() -> list[bytes]:
    plain = b"[Sequence]\nname=One\nimDir=img1\nframeRate=25\nseqLength=6\nimWidth=64\n"
    return [plain, plain.replace(b"=", b" : ").replace(b"25", b"29.97")]


def check_information(data: bytes) -> str:
    """Read the seqinfo.ini of a sequence with many objects."""
    root = _dataset("crowds", "img1")
    for part, name in (("gt", "gt.txt"), ("det", "det.txt")):
        (root / "One" / part).mkdir(exist_ok=True)
        (root / "One" / part / name).write_bytes(detections.TRUTH)
    (root / "One" / "seqinfo.ini").write_bytes(data)
    return _outcome(lambda: load_mot_dataset(root))


def masks() -> list[bytes]:
    white = np.zeros((48, 64), np.uint8)
    white[10:20, 20:40] = 255
    pictures = []
    for name, mode in (("a.png", "L"), ("b.png", "P"), ("c.bmp", "RGB"), ("d.png", "RGBA")):
        path = scratch() / name
        Image.fromarray(white).convert(mode).save(path)
        pictures.append(path.read_bytes())
    return pictures


def check_mask(data: bytes) -> str:
    """Read a mask."""

    def read() -> None:
        box, ellipse, _ = read_mask(put("mask.png", data))
        if np.isfinite(box).any():
            check_finite([*box, *ellipse])

    return outcome(read)
