"""Zhao and Pei, figure 9: number of objects that a scene detects over number present, by frame."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from motes import (
    Box,
    Detector,
    LookalikeDetector,
    Scene,
    SourceError,
    named_detector,
    open_source,
    scene_config,
)
from motes.cli import numbers_of
from motes.core import FRAME_INTERVAL, iou
from motes.mot import assign
from motes_lab.datasets.distractors import MATCH_IOU
from motes_lab.datasets.mot import MotSequence, has_mot_sequences
from motes_lab.datasets.mot_rows import MotRows, line_of, rows_of
from motes_lab.datasets.sot import Sequence as Film
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import HYPHEN, RUN, crowds_of, films_of
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number
from motes_lab.track_figures import charts

if TYPE_CHECKING:
    from matplotlib.figure import Figure


HEAD = ("frame", "present", "followed", "detected accurately", "ratio")
SUM_HEAD = ("sequence", "found by", "frames", *HEAD[1:])


def zhao_figure9(
    sequence: Path,
    /,
    *,
    detector: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="Detector, as for motes watch. The default is the sequence's det/det.txt, or if "
            "it is missing a background.",
        ),
    ] = None,
    like: Annotated[
        str | None,
        HYPHEN,
        Parameter(
            group=RUN,
            help="Follow all that look like the target in this box of the first frame, as for "
            "motes watch: x,y,width,height.",
        ),
    ] = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Zhao and Pei, figure 9: objects detected over objects present.

    Parameters
    ----------
    sequence
        A folder with frames and ground truth as for motes-lab evaluate, of many objects or of one.
    """
    config = scene_config("zhao_pei")
    finder = None if detector is None else named_detector(detector)
    if like is not None:
        box = numbers_of("--like", like, "x,y,width,height")
        config, finder = config.for_lookalikes(), LookalikeDetector(box, finder)
    if has_mot_sequences(sequence):
        crowds, problems = crowds_of(sequence)
    else:
        films, problems = films_of(sequence)
        crowds = [as_mot_sequence(film) for film in films]
    if len(crowds) > 1:
        raise SourceError(f"{sequence} has {len(crowds)} sequences; give the folder of one.")
    (crowd,) = crowds
    found_by = " ".join(text for text in (like and f"--like {like}", detector) if text)
    if finder is None:
        finder = default_detector(crowd)
        found_by = "background" if crowd.detections is None else "det.txt"
    steps = figure9(crowd, Scene(finder, config), found_by)
    return results.show("zhao-figure9", steps, problems)


def as_mot_sequence(film: Film) -> MotSequence:
    """Return a sequence of one object as a `MotSequence` without detections."""
    with open_source(film.source) as source:
        rate = source.fps or 1 / FRAME_INTERVAL
    lines = [
        line_of(index, 1, Box(*box))
        for index, box in enumerate(film.boxes.tolist())
        if np.isfinite(box[0])
    ]
    return MotSequence(film.name, film.source, film.frames, rate, rows_of(lines), None)


def figure9(sequence: MotSequence, scene: Scene, found_by: str) -> Experiment:
    """Yield the share of the objects present that a scene follows, frame by frame.

    An object is detected accurately if a track matches it, one to one, with an overlap of
    `MATCH_IOU` or more. While it is hidden, the position of the track is its prediction. The rules
    of the MOTChallenge decide which objects count (`evaluated_rows`). `found_by` is the name of the
    scene's detector.
    """
    scene.prepare(sequence.pictures())
    counts: list[tuple[int, int, int]] = []
    rows: list[Row] = []
    for frame in sequence.pictures():
        tracks = [each for each in scene.update(frame) if not each.gone]
        found = ((each.identity, each.box) for each in tracks)
        counts.append(count_accurate(*sequence.compared(frame.index, found)))
        rows.append((Cell(str(frame.index), frame.index), *_cells(np.array(counts[-1:]))))
        sums = _cells(np.array(counts))
        note = " ".join(
            [f"Detected accurately: IoU {MATCH_IOU} or above.", *scene.warnings.values()]
        )
        title = f"Objects detected over objects present, {sequence.name}"
        names = Cell(sequence.name), Cell(found_by), number(len(counts), 0)
        tables = {
            "": Table(title, HEAD, rows, ((Cell("all"), *sums),), note),
            "all": Table("All frames", SUM_HEAD, [(*names, *sums)], note=note),
        }
        progress, share = f"frame {frame.index} of {sequence.frames}", len(counts) / sequence.frames
        yield Result(tables, partial(_draw, sequence.name, counts), (), progress, share)


def default_detector(sequence: MotSequence) -> Detector:
    """Return the sequence's own detections as a detector, or else a background model."""
    found = sequence.detections
    if found is None:
        return named_detector("background")
    return lambda frame: found.detections(frame.index)


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
