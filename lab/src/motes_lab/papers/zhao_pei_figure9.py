"""Zhao and Pei, figure 9: number of objects that a scene detects over number present, by frame."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Generator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motes.core.detection import Detection, Detector, PreparedDetector
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import iou
from motes.core.track import Status
from motes.formats.mot_files import UNKNOWN, MotRows, rows_of
from motes.mot.assignment import assign
from motes.mot.detection.background import BackgroundDetector
from motes.output import charts
from motes.video.sources import open_source
from motes_lab.adapters.mot import prepare
from motes_lab.datasets.distractors import MATCH_IOU, evaluated_rows
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.sot import Sequence as Film
from motes_lab.papers.expected_time import Expected, SceneFactory, seconds_per_frame
from motes_lab.papers.result import Experiment, Result
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


HEAD = ("frame", "present", "followed", "detected accurately", "ratio")
SUM_HEAD = ("sequence", "found by", "frames", *HEAD[1:])


def as_mot_sequence(film: Film) -> MotSequence:
    """Return a sequence of one object as a `MotSequence` without detections."""
    with open_source(film.source) as source:
        rate = source.fps or 1 / FRAME_INTERVAL
    lines = [
        [index + 1, 1, x + 1, y + 1, width, height, 1, UNKNOWN]
        for index, (x, y, width, height) in enumerate(film.boxes.tolist())
        if np.isfinite(x)
    ]
    return MotSequence(film.name, film.source, film.frames, rate, rows_of(lines), None)


def expected(sequence: MotSequence, scene: SceneFactory, frames: int) -> Expected:
    """Return the expected time of `figure9`, measured on the first frames.

    Raises
    ------
    SourceError
        If a frame cannot be read.
    """
    with contextlib.closing(_frames(sequence, frames)) as first:
        return Expected(f"{frames} frames", frames * seconds_per_frame(scene(0), first))


def figure9(
    sequence: MotSequence, scene: SceneFactory, found_by: str, seed: int, frames: int
) -> Experiment:
    """Yield the share of the objects present that a scene follows, frame by frame.

    An object is detected accurately if a track matches it, one to one, with an overlap of
    `MATCH_IOU` or more. While it is hidden, the position of the track is its prediction. The rules
    of the MOTChallenge decide which objects count (`evaluated_rows`).

    Parameters
    ----------
    sequence
        Frames and truth.
    scene
        Makes the scene, with its detector.
    found_by
        The detector's name.
    seed
        Seed of the scene.
    frames
        Number of frames, from the first one on.

    Raises
    ------
    SourceError
        If a frame cannot be read.
    """
    followed = scene(seed)
    if isinstance(followed.detector, PreparedDetector):
        prepare(followed.detector, sequence.source, sequence.rate)
    counts: list[tuple[int, int, int]] = []
    rows: list[Row] = []
    part = "" if frames == sequence.frames else f", first {frames} of {sequence.frames} frames"
    with contextlib.closing(_frames(sequence, frames)) as read:
        for frame in read:
            lines = [
                [
                    frame.index + 1, each.identity, each.track.box.x + 1, each.track.box.y + 1,
                    *each.track.box[2:], each.track.confidence, UNKNOWN,
                ]
                for each in followed.update(frame)
                if each.track.status is not Status.LOST
            ]  # fmt: skip
            truth = sequence.truth.where(sequence.truth.frames == frame.index + 1)
            compared = evaluated_rows(truth, rows_of(lines), sequence.distractors)
            counts.append(count_accurate(*compared))
            rows.append((Cell(str(frame.index), frame.index), *_cells(np.array(counts[-1:]))))
            sums = _cells(np.array(counts))
            foot = (Cell("all"), *sums)
            title = f"Objects detected over objects present, {sequence.name}{part}"
            note = " ".join(
                [f"Detected accurately: IoU {MATCH_IOU} or above.", *followed.warnings.values()]
            )
            table = Table(title, HEAD, rows, (foot,), note)
            progress, share = f"{len(counts)} of {frames} frames", len(counts) / frames
            draw = partial(_draw, sequence.name, counts)
            names = Cell(sequence.name), Cell(found_by), number(len(counts), 0)
            all_frames = Table("All frames", SUM_HEAD, [(*names, *sums)], note=note)
            tables = {"": table, "all": all_frames}
            yield Result(tables, draw, progress=progress, share=share)


def _frames(sequence: MotSequence, count: int) -> Generator[Frame, None, None]:
    """Yield the first frames of a sequence, at the times of its frame rate."""
    with open_source(sequence.source) as source:
        for decoded in itertools.islice(source, count):
            yield Frame(decoded.index, decoded.index / sequence.rate, decoded.pixels)


def default_detector(sequence: MotSequence) -> Detector:
    """Return the sequence's own detections as a detector, or else a background model."""
    found = sequence.detections
    if found is None:
        return BackgroundDetector()
    return lambda frame: [Detection(box, score) for _, box, score in found.listed(frame.index)]


def count_accurate(truth: MotRows, results: MotRows) -> tuple[int, int, int]:
    """Return the numbers of objects present, followed, and detected accurately in a frame."""
    overlaps = iou(truth.boxes[:, None], results.boxes)
    accurate = assign(np.where(overlaps >= MATCH_IOU, 1 - overlaps, np.inf))
    return len(truth.ids), len(results.ids), len(accurate)


def _cells(counts: NDArray[np.int64]) -> Row:
    """Return the sums over frames (n, 3), and the ratio of the last to the first."""
    present, followed, accurate = counts.sum(axis=0).tolist()
    ratio = number(accurate / present) if present else Cell(NO_VALUE)
    return *(number(each, 0) for each in (present, followed, accurate)), ratio


def _draw(name: str, counts: list[tuple[int, int, int]]) -> Figure:
    present, followed, accurate = np.array(counts, np.float64).T
    present[present == 0] = np.nan  # no ratio without objects
    figure = charts.new_figure(3.2)
    axes = figure.add_subplot()
    charts.style_axes(axes, name, "frame", "over objects present")
    axes.axhline(1, color=charts.INK, linewidth=0.8)
    for label, values, color in (
        ("followed", followed, charts.ORANGE), ("detected accurately", accurate, charts.BLUE)
    ):  # fmt: skip
        axes.step(np.arange(len(values)), values / present, where="mid", color=color, label=label)
    axes.set_ylim(bottom=0)
    charts.legend(axes)
    return figure
