"""Zhao and Pei, section 3.1: the objects that a detector finds, before any tracking."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from motes import named_detector
from motes_lab.datasets.distractors import MATCH_IOU
from motes_lab.datasets.mot import MotSequence
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import crowds_of
from motes_lab.papers.zhao_pei_figure9 import count_accurate
from motes_lab.report.tables import Cell, Row, Table, number

HEAD = ("sequence", "objects", "detections", "right", "precision", "recall", "F1")


def zhao_detections(sequences: Path, /, *, results: ResultOptions = ResultOptions()) -> int:
    """Zhao and Pei, section 3.1: what the mixture detects.

    Parameters
    ----------
    sequences
        A folder of sequences of many objects, as for motes-lab evaluate.
    """
    crowds, problems = crowds_of(sequences)
    return results.show("zhao-detections", detections(crowds), problems)


def detections(sequences: Sequence[MotSequence]) -> Experiment:
    """Yield precision and recall of the mixture of Gaussians, sequence by sequence.

    A detection is right if it matches an object, one to one in its frame, with an overlap of
    `MATCH_IOU` or more. The rules of the MOTChallenge decide which objects count.
    """
    rows, total = list[Row](), np.zeros(3, np.int64)
    for done, sequence in enumerate(sequences, start=1):
        counts = _counts(sequence)
        total += counts
        rows.append(_row(sequence.name, counts))
        note = f"A detection is right at an IoU of {MATCH_IOU} or above."
        table = Table("Detections before tracking", HEAD, rows, (_row("all", total),), note)
        yield Result({"": table}, progress=f"{done} of {len(sequences)} sequences")


def _counts(sequence: MotSequence) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the numbers of objects, of detections, and of right ones: (3,)."""
    detector = named_detector("background")
    assert hasattr(detector, "prepare")
    detector.prepare(sequence.pictures())
    counts = np.zeros(3, np.int64)
    for frame in sequence.pictures():
        found = enumerate((each.box for each in detector(frame)), start=1)
        counts += count_accurate(*sequence.compared(frame.index, found))
    return counts


def _row(name: str, counts: np.ndarray[tuple[int], np.dtype[np.int64]]) -> Row:
    """Return the row of a sequence."""
    objects, found, right = counts.tolist()
    shares = (right / max(found, 1), right / max(objects, 1), 2 * right / max(objects + found, 1))
    return (Cell(name), *(number(each, 0) for each in counts.tolist()), *map(number, shares))
