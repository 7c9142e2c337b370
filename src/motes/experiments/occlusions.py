"""Who passes behind somebody else and keeps its identity: Zhao and Pei's claim, rendered."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist

import numpy as np

from motes import synthetic
from motes.background import BackgroundDetector
from motes.evaluate.tables import Cell, Row, Table, number, percent
from motes.experiments.result import Experiment, Result
from motes.geometry import iou
from motes.scene import Scene
from motes.synthetic import Clip
from motes.track import Status

BESIDE = 30
"""Frames before and after an occlusion in which the identity is looked up, ..."""
ASIDE = 10
"""... but not in so many next to it, in which the target is seen in part."""
UNSEEN = 0.02
"""Visible share below which a target is hidden whole."""
ON = 0.4
"""Overlap (IoU) from which on a track is that of a target."""


def occlusions(lengths: Sequence[int], clips: int) -> Experiment:
    """Yield how many targets keep their identity while another one hides them whole.

    Each clip of `synthetic.hiding` has one occlusion, targets of different colors or of the same
    ones; detections are what moves before the background.

    Parameters
    ----------
    lengths
        How many frames a target is hidden, about.
    clips
        How many clips of each length and kind.
    """
    kept: dict[tuple[str, int], list[bool]] = {}
    total = 2 * len(lengths) * clips
    for alike in (False, True):
        for length in lengths:
            for seed in range(clips):
                key = "the same" if alike else "different", length
                kept.setdefault(key, []).append(
                    keeps(synthetic.hiding((200, 150), length, seed, alike))
                )
                done = sum(map(len, kept.values()))
                yield Result({"": _table(kept)}, progress=f"{done} of {total} clips")


def keeps(clip: Clip) -> bool:
    """Return whether the first target, once hidden, has the same identity before and after.

    It is the identity that most often is on it.
    """
    scene = Scene(BackgroundDetector())
    owners, hidden = [], []
    for frame, (truth, _) in clip:
        tracks = (t for t in scene.update(frame) if t.track.status is Status.TRACKING)
        on = [t.identity for t in tracks if iou(t.track.box, truth.ellipse.box) > ON]
        owners.append(on[0] if on else 0)
        hidden.append(truth.visible < UNSEEN and 0 < truth.ellipse.x < clip.size[0])
    gone = np.flatnonzero(hidden)
    before = owners[gone[0] - BESIDE : gone[0] - ASIDE]
    after = owners[gone[-1] + 1 + ASIDE : gone[-1] + 1 + BESIDE]
    mine, again = (int(np.bincount(part).argmax()) for part in (before, after))
    return mine > 0 and mine == again


def interval(hits: int, of: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a share (J. Am. Stat. Assoc. 22, 1927)."""
    z = NormalDist().inv_cdf(0.975)
    center = (hits + z * z / 2) / (of + z * z)
    half = z * math.sqrt(hits * (of - hits) / of + z * z / 4) / (of + z * z)
    return max(center - half, 0.0), min(center + half, 1.0)


def _table(kept: dict[tuple[str, int], list[bool]]) -> Table:
    rows: list[Row] = []
    for (colors, length), each in kept.items():
        low, high = interval(sum(each), len(each))
        share = percent(sum(each) / len(each))
        between = Cell(f"{100 * low:.0f} to {100 * high:.0f} %")
        counts = number(length, 0), number(len(each), 0), number(sum(each), 0)
        rows.append((Cell(colors), *counts, share, between))
    head = ("colors", "frames hidden", "occlusions", "identity kept", "share", "95 % interval")
    return Table("Full occlusions", head, rows)
