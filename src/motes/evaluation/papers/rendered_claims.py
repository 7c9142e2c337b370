"""Claims of the papers, on rendered clips that have nothing but the difficulty in question."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import iou
from motes.cues.structure_tensor import Orientation
from motes.evaluation.metrics.sot import enclosing_boxes, overlap_distances
from motes.evaluation.papers.result import Experiment, Result, over
from motes.evaluation.report.tables import Cell, Row, Table, number, percent
from motes.evaluation.scores import MISS_IOU
from motes.evaluation.synthetic.clips import Clip
from motes.sot.mean_shift import MeanShift
from motes.sot.presets import preset
from motes.sot.tracker import Tracker

Floats = NDArray[np.float64]

FOLLOWED = 45.0
"""Degrees; a tracker whose angle is never as far off has followed the whole turn."""
NUMMIARO = {
    "mean_shift": "loses its target, for good",
    "mean_shift:kalman": "more likely to follow",
    "nummiaro": "follows to the end",
}
"""What section VI says of trackers where regions do not overlap; it has no numbers."""


class Pass(NamedTuple):
    """A tracker's run over a clip: its ellipses and the true ones, both (frames, 5)."""

    name: str
    found: Floats
    truth: Floats
    progress: str


def passes(
    presets: Sequence[str], clips: Sequence[Clip], seeds: int, *, upright: bool = False
) -> Iterator[Pass]:
    """Yield the passes of trackers over clips, mean shift with one seed as it draws no numbers.

    Parameters
    ----------
    presets, clips, seeds
        Which trackers, where, and how many seeds.
    upright
        Whether they start in the box around the target, not in its ellipse, which may be turned.

    Raises
    ------
    ConfigError
        If there is no such preset.
    """
    configs = {name: preset(name) for name in presets}
    runs = {name: 1 if isinstance(each, MeanShift) else seeds for name, each in configs.items()}
    total, done = len(clips) * sum(runs.values()), 0
    for clip in clips:
        frames, truths = zip(*clip, strict=True)
        truth = np.array([target.ellipse for (target,) in truths])
        start = truths[0][0].ellipse
        region: Sequence[float] = start.box if upright else start
        for name, config in configs.items():
            for seed in range(runs[name]):
                tracker = Tracker(config, seed)
                tracks = [tracker.init(_fresh(frames[0]), region)]
                tracks += [tracker.update(_fresh(frame)) for frame in frames[1:]]
                done += 1
                found = np.array([track.ellipse for track in tracks])
                yield Pass(name, found, truth, f"{done} of {total} runs")


def _fresh(frame: Frame) -> Frame:
    """Return a frame without what others have computed of it, which only takes up memory."""
    return Frame(frame.index, frame.time, frame.pixels)


def leaps(presets: Sequence[str], clips: Sequence[Clip], seeds: int) -> Experiment:
    """Yield how trackers do where regions do not overlap (Nummiaro et al., section VI).

    A leap frame is one whose true box does not overlap the one before.
    """
    runs: dict[str, list[tuple[float, float, float]]] = {}
    for name, found, truth, progress in passes(presets, clips, seeds, upright=True):
        true = enclosing_boxes(truth)
        leap = np.append(False, iou(true[1:], true[:-1]) == 0)
        overlaps = iou(enclosing_boxes(found), true)
        on = overlaps > MISS_IOU
        runs.setdefault(name, []).append((overlaps.mean(), on.mean(), on[leap].mean()))
        rows: list[Row] = []
        for each, values in runs.items():
            overlap, *shares = map(over, zip(*values, strict=True))
            said, count = Cell(NUMMIARO.get(each, "")), number(len(values), 0)
            rows.append((Cell(each), count, number(overlap, 2), *map(percent, shares), said))
        head = ("tracker", "runs", "mean IoU", "frames on target", "leap frames", "the paper")
        note = f"On target: IoU above {MISS_IOU}."
        table = Table("Regions that do not overlap", head, rows, note=note)
        yield Result({"": table}, progress=progress)


def rotation(presets: Sequence[str], clips: Sequence[Clip], seeds: int) -> Experiment:
    """Yield how far off trackers' angles are on a target that turns (Maggio et al., 3.2.1).

    The error is taken modulo half a turn, after which an ellipse is the same.
    """
    runs: dict[str, list[tuple[float, float, bool]]] = {}
    for name, found, truth, progress in passes(presets, clips, seeds):
        off = np.abs((np.degrees(found[:, 4] - truth[:, 4]) + 90) % 180 - 90)
        runs.setdefault(name, []).append((off.mean(), off.max(), off.max() < FOLLOWED))
        rows: list[Row] = []
        for each, values in runs.items():
            mean, largest, followed = zip(*values, strict=True)
            turns = Cell(f"{sum(followed)} of {len(followed)}", sum(followed))
            rows.append((Cell(each), number(over(mean), 1), number(over(largest), 0), turns))
        head = ("tracker", "mean error (degrees)", "largest error (degrees)", "turns followed")
        note = f"Followed: the error never reaches {FOLLOWED:g} degrees."
        table = Table("A target that turns once", head, rows, note=note)
        yield Result({"": table}, progress=progress)


def growth(presets: Sequence[str], clips: Sequence[Clip], seeds: int) -> Experiment:
    """Yield trackers' mean OD on a target that grows and shrinks (Maggio et al., 3.2.2 and 5).

    And how far the orientation histogram of the true region at its largest is from the model, with
    filters whose scale follows the target's, and without.
    """
    runs: dict[str, list[float]] = {}
    tables: dict[str, Table] = {}
    for name, found, truth, progress in passes(presets, clips, seeds):
        runs.setdefault(name, []).append(float(overlap_distances(found, truth).mean()))
        rows: list[Row] = [
            (Cell(each), number(len(ods), 0), number(over(ods))) for each, ods in runs.items()
        ]
        tables["tracks"] = Table("A target that grows", ("tracker", "runs", "mean OD"), rows)
        yield Result(dict(tables), progress=progress)
    rows = []
    for text, selection in (("follows the target", True), ("as in the first frame", False)):
        cue = Orientation(scale_selection=selection)
        rows.append((Cell(text), number(over(grown(cue, clip) for clip in clips))))
        head = ("scale of the filters", "distance")
        tables["histograms"] = Table("True region at its largest, to the model", head, list(rows))
        yield Result(dict(tables))


def grown(cue: Orientation, clip: Clip) -> float:
    """Return the distance of the largest true region to the model, which has seen all before."""
    largest = max(range(len(clip)), key=lambda index: clip.targets[0].states[index, 2])
    frame, (target,) = clip[0]
    model = cue.learn(frame, target.ellipse)
    for index in range(largest):
        frame, (target,) = clip[index]
        model = cue.update_reading(model, frame, target.ellipse)
    frame, (target,) = clip[largest]
    return float(cue.distances(model, frame, np.array([target.ellipse]))[0])
