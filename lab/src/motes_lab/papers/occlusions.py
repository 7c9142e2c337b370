"""Zhao and Pei's claim, rendered: targets keep their identity through full occlusions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, get_args

import numpy as np

from motes.core.geometry import iou
from motes.core.track import Status
from motes.mot.scene import Scene
from motes_lab.papers.expected_time import (
    MEASURED_FRAMES,
    Expected,
    SceneFactory,
    seconds_per_frame,
)
from motes_lab.papers.occlusion_clips import (
    EMPTY,
    MAX_LANES,
    OcclusionClip,
    Way,
    full_occlusions,
    occlusion_clip,
)
from motes_lab.papers.result import Experiment, Result, wilson_interval
from motes_lab.report.tables import Cell, Row, Table, number, percent

EDGE_FRAMES, CONTEXT_FRAMES = 10, 30
"""Frames next to an occlusion whose identities are not read.

Identities are read from the next frames, up to `CONTEXT_FRAMES` before and after the occlusion,
counted in frames in which the target is visible.
"""
VISIBLE = 0.98
"""A target is visible if more than this share of it is seen."""
HIDDEN = 0.02
"""A target is fully hidden if less than this share of it is seen."""
MATCH_IOU = 0.4
"""Smallest overlap (IoU) of a track with its target."""
SAME = "the same"
SHORT = 30
"""Occlusions of up to this many frames are also counted together."""


class Kind(NamedTuple):
    """A kind of occlusion: motion, colors, number of objects, approximate length in frames."""

    way: Way
    colors: str
    objects: int
    length: int

    def clip(self, seed: int) -> OcclusionClip:
        """Return a clip of this kind."""
        alike = self.colors == SAME
        return occlusion_clip(self.way, self.length, self.objects, same_colors=alike, seed=seed)

    @property
    def per_clip(self) -> int:
        """Number of occlusions in a clip that are counted."""
        lanes = min(self.objects // 2, MAX_LANES)
        a_side = self.objects // (2 * lanes)
        meetings = a_side if self.way == "turning back" else a_side * (a_side + 1) // 2
        return lanes * meetings

    def clips(self, least: int) -> int:
        """Return the number of clips that have `least` occlusions."""
        return -(-least // self.per_clip)


def kinds_of(lengths: Sequence[int], objects: Sequence[int]) -> list[Kind]:
    """Return all kinds of occlusions of these lengths, among these numbers of objects."""
    return [
        Kind(way, colors, count, length)
        for way in get_args(Way)
        for colors in ("different", SAME)
        for count in objects
        for length in lengths
    ]


def expected(kinds: Sequence[Kind], least: int, scene: SceneFactory) -> Expected:
    """Return the expected time of `occlusions`, measured on a few frames of some kinds."""
    per_frame: dict[int, float] = {}
    clips, frames, seconds = 0, 0, 0.0
    for kind in kinds:
        clip = kind.clip(0).clip
        if kind.objects not in per_frame:
            step = (len(clip) - EMPTY) / MEASURED_FRAMES
            measured = (clip[EMPTY + int(i * step)][0] for i in range(MEASURED_FRAMES))
            per_frame[kind.objects] = seconds_per_frame(scene(0), measured)
        count = kind.clips(least)
        clips += count
        frames += count * len(clip)
        seconds += count * len(clip) * per_frame[kind.objects]
    return Expected(f"{clips} clips, {frames} frames", seconds)


def occlusions(kinds: Sequence[Kind], least: int, scene: SceneFactory) -> Experiment:
    """Yield after each clip how many targets kept their identity while another one hid them.

    Parameters
    ----------
    kinds
        The kinds of occlusions, as from `kinds_of`.
    least
        Smallest number of occlusions of each kind.
    scene
        Makes the scene of each clip, with its detector.
    """
    kept: dict[Kind, list[bool]] = {}
    total = sum(kind.objects * kind.clips(least) for kind in kinds)
    done = 0
    for kind in kinds:
        kept_here, seed = kept.setdefault(kind, []), 0
        while len(kept_here) < least:
            kept_here += keeps(kind.clip(seed), scene(0))
            seed += 1
            here = kind.objects * kind.clips(least) * min(len(kept_here) / least, 1.0)
            clip = f"{kind.way}, {kind.objects} objects, {kind.length} frames, clip {seed}"
            yield Result(_tables(kept), progress=clip, share=(done + here) / total)
        done += kind.objects * kind.clips(least)


def keeps(staged: OcclusionClip, scene: Scene) -> list[bool]:
    """Return, for each occlusion, whether the hidden target has the same identity before and after.

    The identity is the most frequent one of the tracks on the target.
    """
    clip = staged.clip
    shape = len(clip), len(clip.targets)
    visible, within, owners = np.ones(shape), np.zeros(shape, bool), np.zeros(shape, int)
    for i, (frame, truths) in enumerate(clip):
        tracks = [t for t in scene.update(frame) if t.track.status is Status.TRACKING]
        boxes = np.array([t.track.box for t in tracks]).reshape(-1, 4)
        for k, truth in enumerate(truths):
            visible[i, k], within[i, k] = truth.visible, 0 < truth.ellipse.x < clip.size[0]
            overlaps = iou(boxes, np.array(truth.ellipse.box))
            if len(tracks) and overlaps.max() > MATCH_IOU:
                owners[i, k] = tracks[int(overlaps.argmax())].identity
    out = []
    for target, first, last in full_occlusions(visible, within, HIDDEN):
        whole = np.flatnonzero(visible[:, target] > VISIBLE)
        touched, clear = whole[whole < first], whole[whole > last]
        if first < staged.since or len(touched) < CONTEXT_FRAMES or len(clear) < CONTEXT_FRAMES:
            continue
        before = owners[touched[-CONTEXT_FRAMES:-EDGE_FRAMES], target]
        after = owners[clear[EDGE_FRAMES:CONTEXT_FRAMES], target]
        identity, later = (int(np.bincount(part).argmax()) for part in (before, after))
        out.append(identity > 0 and identity == later)
    return out


def _tables(kept: dict[Kind, list[bool]]) -> dict[str, Table]:
    """Return the counts of every kind, and those of all short occlusions by motion."""
    lengths: dict[Row, dict[int, list[bool]]] = {}
    short: dict[Row, list[bool]] = {}
    for kind, kept_here in kept.items():
        way, colors, count = Cell(kind.way), Cell(kind.colors), number(kind.objects, 0)
        lengths.setdefault((way, colors, number(kind.length, 0)), {})[kind.objects] = kept_here
        if kind.length <= SHORT:
            short.setdefault((way, colors, count), []).extend(kept_here)
    objects = sorted({kind.objects for kind in kept})
    head = ("way", "colors", "frames hidden", *(f"{count} objects" for count in objects))
    rows: list[Row] = [
        (*row, *(_of(each.get(count)) for count in objects)) for row, each in lengths.items()
    ]
    tables = {"lengths": Table("Identities kept through full occlusions", head, rows)}
    head = "way", "colors", "objects", "identities kept", "share", "95 % interval"
    rows = [(*row, *_shared(kept_here)) for row, kept_here in short.items()]
    every = [one for kept_here in short.values() for one in kept_here]
    foot: tuple[Row, ...] = ((Cell("all"), Cell(""), Cell(""), *_shared(every)),) if every else ()
    tables["short"] = Table(f"Hidden for up to {SHORT} frames", head, rows, foot)
    return tables


def _shared(kept: list[bool]) -> Row:
    low, high = (f"{100 * share:.1f}" for share in wilson_interval(sum(kept), len(kept)))
    return _of(kept), percent(sum(kept) / len(kept)), Cell(f"{low} to {high} %")


def _of(kept: list[bool] | None) -> Cell:
    return Cell("") if kept is None else Cell(f"{sum(kept)} of {len(kept)}", sum(kept))
