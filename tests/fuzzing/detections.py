"""Boxes as the MOTChallenge writes them: of detectors, in the truth, and in results."""

from functools import partial
from pathlib import Path

import numpy as np

from motes.core.frame import Frame
from motes.formats.mot import Kind
from motes.mot.detection.pretrained import RecordedDetections
from motes_lab.datasets.distractors import evaluated_rows
from motes_lab.datasets.mot_rows import read_rows
from motes_lab.metrics.mot import tally

from .outcomes import READ, REFUSED, check_finite, outcome, put

FRAMES = 6
TRUTH = "".join(
    f"{frame},{who},{10 * who + frame},{5 * who},20,30.5,1,1,0.9\n"
    for frame in range(1, FRAMES + 1)
    for who in (1, 2, 3)
).encode()
EMPTY = np.zeros((48, 64, 3), np.uint8)


def seeds() -> list[bytes]:
    found = b"1,-1,10,20,30,40,0.5,-1,-1,-1\n2,-1,11,20,30,40,0.25\n\n3 -1 12 20 3e1 40 1\n"
    distracted = TRUTH.replace(b",1,1,0.9", b",1,8,0.9", 3).replace(b"3,1,", b"3;1;")
    return [TRUTH, distracted, found]


def check_detector(data: bytes) -> str:
    """Read what `--detector det.txt` reads."""

    def read() -> None:
        found = RecordedDetections(put("det.txt", data))
        for index in range(FRAMES):
            for box, score in ((d.box, d.score) for d in found(Frame(index, 0.0, EMPTY))):
                check_finite([*box, score])

    return outcome(read)


def check_rows(data: bytes) -> str:
    """Read truth, results and detections of `motes-lab evaluate`, and measure them."""
    path = put("gt.txt", data)
    kinds: tuple[Kind, ...] = ("truth", "results", "detections")
    found = [outcome(partial(_measure, path, kind)) for kind in kinds]
    return READ if READ in found else REFUSED


def _measure(path: Path, kind: Kind) -> None:
    rows = read_rows(path, FRAMES, kind)
    for index in range(FRAMES):
        for _, box, score in rows.listed(index):
            check_finite([*box, score])
    if kind != "detections":
        truth = read_rows(put("truth.txt", TRUTH), FRAMES, "truth")
        pair = (rows, truth) if kind == "truth" else (truth, rows)
        numbers = tally(*evaluated_rows(*pair, (8,)), FRAMES)
        check_finite([*numbers.hota.tolist(), numbers.mota, numbers.motp, numbers.idf1])
