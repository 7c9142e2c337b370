"""Zhao and Pei, figure 9: the objects that a scene detects over those that are there, by frame."""

from __future__ import annotations

import itertools
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motes.core.detection import Detection, Detector
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import iou
from motes.core.track import Status
from motes.evaluation.datasets.distractors import MATCH_IOU, evaluated_rows
from motes.evaluation.datasets.mot import MotSequence
from motes.evaluation.datasets.mot_files import UNKNOWN, Rows, rows_of
from motes.evaluation.datasets.sot import Sequence as Film
from motes.evaluation.papers.result import Experiment, Result
from motes.evaluation.report.tables import NOTHING, Cell, Row, Table, number
from motes.mot.assignment import assign
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene
from motes.output import charts
from motes.video.sources import open_source

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

HEAD = ("frame", "there", "followed", "detected accurately", "ratio")


def crowd_of(film: Film) -> MotSequence:
    """Return a sequence with one object as one of many, without detections."""
    with open_source(film.source) as source:
        rate = source.fps or 1 / FRAME_INTERVAL
    lines = [
        [index + 1, 1, x + 1, y + 1, width, height, 1, UNKNOWN]
        for index, (x, y, width, height) in enumerate(film.boxes.tolist())
        if np.isfinite(x)
    ]
    return MotSequence(film.name, film.source, film.frames, rate, rows_of(lines), None)


def figure9(sequence: MotSequence, detector: Detector | None, preset: str, seed: int) -> Experiment:
    """Yield how many of the objects that are there a scene follows, frame by frame.

    An object is detected accurately if it is followed at a place that overlaps its own, one to one,
    by `MATCH_IOU` or more; which is where it should be while it is hidden. What counts as an object
    is as in the MOTChallenge (`evaluated_rows`).

    Parameters
    ----------
    sequence
        Frames and truth.
    detector
        What finds objects; if None, the sequence's own detections, and if it has none, what moves
        before the background.
    preset, seed
        Of the scene.

    Raises
    ------
    SourceError
        If a frame cannot be read.
    ConfigError
        If there is no such preset.
    """
    scene = Scene(detector or _own(sequence), preset, seed)
    counts: list[tuple[int, int, int]] = []
    rows: list[Row] = []
    with open_source(sequence.source) as source:
        for picture in itertools.islice(source, sequence.frames):
            frame = Frame(picture.index, picture.index / sequence.rate, picture.pixels)
            lines = [
                [
                    frame.index + 1, each.identity, each.track.box.x + 1, each.track.box.y + 1,
                    *each.track.box[2:], each.track.confidence, UNKNOWN,
                ]
                for each in scene.update(frame)
                if each.track.status is not Status.LOST
            ]  # fmt: skip
            here = sequence.truth.where(sequence.truth.frames == frame.index + 1)
            counts.append(_count(*evaluated_rows(here, rows_of(lines), sequence.distractors)))
            rows.append((Cell(str(frame.index), frame.index), *_cells(np.array(counts[-1:]))))
            foot = (Cell("all"), *_cells(np.array(counts)))
            title = f"Objects detected over objects there, {sequence.name}"
            note = " ".join(
                [f"Detected accurately: IoU {MATCH_IOU} or above.", *scene.warnings.values()]
            )
            table = Table(title, HEAD, rows, (foot,), note)
            progress = f"{len(counts)} of {sequence.frames} frames"
            yield Result({"": table}, partial(_draw, sequence.name, counts), progress=progress)


def _own(sequence: MotSequence) -> Detector:
    """Return what finds a sequence's objects if nobody says."""
    found = sequence.detections
    if found is None:
        return BackgroundDetector()
    return lambda frame: [Detection(box, score) for _, box, score in found.listed(frame.index)]


def _count(truth: Rows, said: Rows) -> tuple[int, int, int]:
    """Return how many objects are in a frame, how many are followed, and how many rightly."""
    overlaps = iou(truth.boxes[:, None], said.boxes)
    right = assign(np.where(overlaps >= MATCH_IOU, 1 - overlaps, np.inf))
    return len(truth.ids), len(said.ids), len(right)


def _cells(counts: NDArray[np.int64]) -> Row:
    """Return sums over frames (n, 3), and the share of the first one that is the last one."""
    there, followed, right = counts.sum(axis=0).tolist()
    ratio = number(right / there) if there else Cell(NOTHING)
    return *(number(each, 0) for each in (there, followed, right)), ratio


def _draw(name: str, counts: list[tuple[int, int, int]]) -> Figure:
    there, followed, right = np.array(counts, np.float64).T
    there[there == 0] = np.nan  # where nothing is there is no ratio
    figure = charts.new_figure(3.2)
    axes = figure.add_subplot()
    charts.style_axes(axes, name, "frame", "over objects there")
    axes.axhline(1, color=charts.INK, linewidth=0.8)
    for label, values, color in (
        ("followed", followed, charts.ORANGE), ("detected accurately", right, charts.BLUE)
    ):  # fmt: skip
        axes.step(np.arange(len(values)), values / there, where="mid", color=color, label=label)
    axes.set_ylim(bottom=0)
    charts.legend(axes)
    return figure
