"""Claims of the papers, on rendered clips that contain only the difficulty in question."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import iou
from motes.core.types import Floats
from motes.cues.structure_tensor import Orientation
from motes.sot.mean_shift import MeanShift
from motes.sot.presets import preset
from motes.sot.tracker import Tracker
from motes.synthetic.clips import Clip
from motes_lab.metrics.sot import enclosing_boxes, overlap_distances
from motes_lab.papers.result import Experiment, Result, over
from motes_lab.report.tables import Cell, Row, Table, number, percent
from motes_lab.scores import MISS_IOU

FOLLOWED = 45.0
"""Degrees; a tracker has followed the whole turn if its error is always smaller."""
NUMMIARO = {
    "mean_shift": "loses its target, for good",
    "mean_shift:kalman": "more likely to follow",
    "nummiaro": "follows to the end",
}
"""Section VI on trackers where regions do not overlap; it has no numbers."""


class Pass(NamedTuple):
    """A tracker's run on a clip: its ellipses and the true ones, both (frames, 5)."""

    name: str
    found: Floats
    truth: Floats
    progress: str


def passes(
    presets: Sequence[str], clips: Sequence[Clip], seeds: int, *, upright: bool = False
) -> Iterator[Pass]:
    """Yield the passes of trackers over clips; mean shift is not random and has one seed.

    Parameters
    ----------
    presets, clips, seeds
        The trackers, the clips, and the number of seeds.
    upright
        Whether trackers start in the box around the target, not in its ellipse, which may be
        rotated.

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
    """Return a frame without the cached values of others, which would only use memory."""
    return Frame(frame.index, frame.time, frame.pixels)


def leaps(presets: Sequence[str], clips: Sequence[Clip], seeds: int) -> Experiment:
    """Yield results where regions do not overlap (Nummiaro et al., section VI).

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
            claim, count = Cell(NUMMIARO.get(each, "")), number(len(values), 0)
            rows.append((Cell(each), count, number(overlap, 2), *map(percent, shares), claim))
        head = ("tracker", "runs", "mean IoU", "frames on target", "leap frames", "the paper")
        note = f"On target: IoU above {MISS_IOU}."
        table = Table("Regions that do not overlap", head, rows, note=note)
        yield Result({"": table}, progress=progress)


def rotation(presets: Sequence[str], clips: Sequence[Clip], seeds: int) -> Experiment:
    """Yield the errors of trackers' angles on a target that rotates (Maggio et al., 3.2.1).

    The error is computed modulo half a turn, since an ellipse is then the same.
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

    A second table has the distance of the orientation histogram of the true region at its largest
    from the model, with filters whose scale follows the target, and without.
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
    """Return the distance of the largest true region from a model updated in all frames before."""
    largest = max(range(len(clip)), key=lambda index: clip.targets[0].states[index, 2])
    frame, (target,) = clip[0]
    model = cue.learn(frame, target.ellipse)
    for index in range(largest):
        frame, (target,) = clip[index]
        model = cue.update_reading(model, frame, target.ellipse)
    frame, (target,) = clip[largest]
    return float(cue.distances(model, frame, np.array([target.ellipse]))[0])
