"""Zhao and Pei, figure 8: the players of one team, found by the features of one of them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import Config, LookalikeDetector, Scene, Status, open_source, scene_config
from motes.core import iou
from motes.mot import assign
from motes_lab.datasets.distractors import MATCH_IOU
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.report.tables import Cell, Row, Table, number

HEAD = ("frame", "objects", "followed", "right", "precision", "recall")
Corners = tuple[float, float, float, float]


class MarkedFrame(Config, frozen=True):
    """The boxes in a frame."""

    index: Annotated[int, Meta(ge=0)]
    """The frame's index, from 0."""
    boxes: tuple[Corners, ...]
    """The boxes: x, y, width, height."""


class Team(Config, frozen=True):
    """All objects that look like one, in some frames."""

    sequence: str
    """The name of the sequence."""
    start: Annotated[int, Meta(ge=0)]
    """The frame in which the one is chosen."""
    like: Corners
    """Its box there."""
    frame: Annotated[tuple[MarkedFrame, ...], Meta(min_length=1)]
    """The frames with boxes."""


def zhao_team(truth: Path, pictures: Path, /, *, results: ResultOptions = ResultOptions()) -> int:
    """Zhao and Pei, figure 8: a team, found by one of its players.

    Parameters
    ----------
    truth
        A TOML file of boxes by hand: sequence, start (a frame), like (the chosen one's box there),
        and [[frame]] with index and boxes.
    pictures
        The film or the folder of its pictures.
    """
    return results.show("zhao-team", team(Team.load(truth), pictures))


def team(truth: Team, pictures: Path) -> Experiment:
    """Yield which objects a scene follows that look like the chosen one, by marked frame.

    An object is right if a visible track matches it, one to one, with an overlap of `MATCH_IOU` or
    more.
    """
    config = scene_config().for_lookalikes()
    scene = Scene(LookalikeDetector(truth.like), config)
    marked = {each.index: np.array(each.boxes).reshape(-1, 4) for each in truth.frame}
    rows, total, last = list[Row](), np.zeros(3, np.int64), max(marked)
    with open_source(pictures, start=truth.start, end=last + 1) as film:
        for frame, tracks in scene.watch(film):
            if frame.index not in marked:
                continue
            boxes = [each.box for each in tracks if each.status is Status.TRACKING]
            seen = np.reshape(boxes, (-1, 4))
            overlaps = iou(marked[frame.index][:, None], seen)
            right = assign(np.where(overlaps >= MATCH_IOU, 1 - overlaps, np.inf))
            counts = np.array([len(marked[frame.index]), len(seen), len(right)])
            total += counts
            rows.append(_row(str(frame.index), counts))
            note = f"{scene.created} identities so far. Right: IoU {MATCH_IOU} or above."
            title = f"Objects that look like one, {truth.sequence}"
            table = Table(title, HEAD, rows, (_row("all", total),), note)
            yield Result({"": table}, progress=f"frame {frame.index} of {last}")


def _row(name: str, counts: np.ndarray[tuple[int], np.dtype[np.int64]]) -> Row:
    """Return the row of a frame, or of all."""
    objects, followed, right = counts.tolist()
    shares = right / max(followed, 1), right / max(objects, 1)
    return (Cell(name), *(number(each, 0) for each in counts.tolist()), *map(number, shares))
