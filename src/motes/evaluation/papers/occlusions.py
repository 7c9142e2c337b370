"""Who is hidden whole by somebody else and keeps its identity: Zhao and Pei's claim, rendered."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist
from typing import NamedTuple, get_args

import numpy as np

from motes.core.geometry import iou
from motes.core.track import Status
from motes.evaluation.papers.result import Experiment, Result
from motes.evaluation.report.tables import Cell, Row, Table, number, percent
from motes.evaluation.synthetic.occlusion_clips import Meetings, Way, hidden, meetings
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene

ASIDE, BESIDE = 10, 30
"""The identity is looked up so many frames before a target was last seen whole, ..."""
WHOLE = 0.98
"""... that is more than this share of it; and as many after."""
UNSEEN = 0.02
"""Visible share below which a target is hidden whole."""
ON = 0.4
"""Overlap (IoU) from which on a track is that of a target."""
ALIKE = "the same"
SHORT = 30
"""Frames; occlusions up to these are also counted together."""


class Kind(NamedTuple):
    """What tells occlusions apart: the way, whether both have the same colors, objects, frames."""

    way: Way
    colors: str
    objects: int
    length: int


def occlusions(lengths: Sequence[int], objects: Sequence[int], least: int) -> Experiment:
    """Yield how many targets keep their identity while another one hides them whole.

    Detections are what moves before the background, in the clips of `meetings`.

    Parameters
    ----------
    lengths
        How many frames a target is hidden, about.
    objects
        How many there are at once: 2, 10, 20, ... 50.
    least
        At least so many occlusions of each kind.
    """
    kept: dict[Kind, list[bool]] = {}
    kinds = [
        Kind(way, colors, count, length)
        for way in get_args(Way)
        for colors in ("different", ALIKE)
        for count in objects
        for length in lengths
    ]
    for done, kind in enumerate(kinds):
        mine, seed = kept.setdefault(kind, []), 0
        while len(mine) < least:
            alike = kind.colors == ALIKE
            mine += keeps(meetings(kind.way, kind.length, kind.objects, alike=alike, seed=seed))
            seed += 1
        yield Result(_tables(kept), progress=f"{done + 1} of {len(kinds)} kinds")


def keeps(met: Meetings) -> list[bool]:
    """Return of each occlusion whether the hidden target has the same identity before and after.

    It is the identity that most often is on it.
    """
    clip, scene = met.clip, Scene(BackgroundDetector())
    shape = len(clip), len(clip.targets)
    visible, within, owners = np.ones(shape), np.zeros(shape, bool), np.zeros(shape, int)
    for i, (frame, truths) in enumerate(clip):
        said = [t for t in scene.update(frame) if t.track.status is Status.TRACKING]
        boxes = np.array([t.track.box for t in said]).reshape(-1, 4)
        for k, truth in enumerate(truths):
            visible[i, k], within[i, k] = truth.visible, 0 < truth.ellipse.x < clip.size[0]
            overlaps = iou(boxes, np.array(truth.ellipse.box))
            if len(said) and overlaps.max() > ON:
                owners[i, k] = said[int(overlaps.argmax())].identity
    out = []
    for target, first, last in hidden(visible, within, UNSEEN):
        whole = np.flatnonzero(visible[:, target] > WHOLE)
        touched, clear = whole[whole < first], whole[whole > last]
        if first < met.since or len(touched) < BESIDE or len(clear) < BESIDE:
            continue
        before = owners[touched[-BESIDE:-ASIDE], target]
        after = owners[clear[ASIDE:BESIDE], target]
        mine, again = (int(np.bincount(part).argmax()) for part in (before, after))
        out.append(mine > 0 and mine == again)
    return out


def interval(hits: int, of: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share (J. Am. Stat. Assoc. 22, 1927)."""
    z = NormalDist().inv_cdf(0.975)
    center = (hits + z * z / 2) / (of + z * z)
    half = z * math.sqrt(hits * (of - hits) / of + z * z / 4) / (of + z * z)
    return max(center - half, 0.0), min(center + half, 1.0)


def _tables(kept: dict[Kind, list[bool]]) -> dict[str, Table]:
    """Return the counts of every kind, and those of all short occlusions of a way."""
    lengths: dict[Row, dict[int, list[bool]]] = {}
    short: dict[Row, list[bool]] = {}
    for kind, mine in kept.items():
        way, colors, count = Cell(kind.way), Cell(kind.colors), number(kind.objects, 0)
        lengths.setdefault((way, colors, number(kind.length, 0)), {})[kind.objects] = mine
        if kind.length <= SHORT:
            short.setdefault((way, colors, count), []).extend(mine)
    objects = sorted({kind.objects for kind in kept})
    head = ("way", "colors", "frames hidden", *(f"{count} objects" for count in objects))
    rows: list[Row] = [
        (*row, *(_of(each.get(count)) for count in objects)) for row, each in lengths.items()
    ]
    tables = {"lengths": Table("Identities kept through full occlusions", head, rows)}
    head = "way", "colors", "objects", "identities kept", "share", "95 % interval"
    rows = [(*row, *_shared(mine)) for row, mine in short.items()]
    every = [one for mine in short.values() for one in mine]
    foot: tuple[Row, ...] = ((Cell("all"), Cell(""), Cell(""), *_shared(every)),) if every else ()
    tables["short"] = Table(f"Hidden for up to {SHORT} frames", head, rows, foot)
    return tables


def _shared(kept: list[bool]) -> Row:
    low, high = (f"{100 * share:.1f}" for share in interval(sum(kept), len(kept)))
    return _of(kept), percent(sum(kept) / len(kept)), Cell(f"{low} to {high} %")


def _of(kept: list[bool] | None) -> Cell:
    return Cell("") if kept is None else Cell(f"{sum(kept)} of {len(kept)}", sum(kept))
