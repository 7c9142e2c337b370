"""Nummiaro et al., section VII: two rooms, two cameras, and who is who when somebody changes rooms.

The paper has one person and proposes the exchange; here several walk to and fro, with known truth.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse, iou
from motes.core.track import Status
from motes.evaluation.papers.result import Experiment, Result, over
from motes.evaluation.report.tables import Cell, Row, Table, number, percent
from motes.evaluation.synthetic.clips import Clip, Target
from motes.mot.cameras.camera_reporter import CameraReporter
from motes.mot.cameras.reidentification import CrossCameraAssociation
from motes.mot.cameras.rig_config import Camera, CameraLink, Rig
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene
from motes.sot.known_target import Place

Floats = NDArray[np.float64]

SIZE = (320, 240)
PEOPLE = 4
EMPTY = 40
"""Frames at the start in which nobody is there and the background is learned."""
TRANSIT = (1.0, 2.5)
"""Seconds from leaving one room whole to coming in by the other's door."""
FOUND = 0.3
"""An object is a person where their boxes overlap by more than this."""
Z95 = 1.96


class Rooms(NamedTuple):
    """Two clips with the same people in the same order, and their ways from one to the other.

    Attributes
    ----------
    clips
        The left room, whose right border is its door, and the right one, whose left border is.
    passages
        (person, room, last frame in it, first frame in the other one).
    """

    clips: tuple[Clip, Clip]
    passages: list[tuple[int, int, int, int]]


def rooms(seed: int = 0, frames: int = 1500, people: int = PEOPLE) -> Rooms:
    """Return two rooms through whose doors people of random colors walk, with random pauses.

    Each comes in by the door, walks to a place in the room, stays for a while, and walks out.
    """
    rng = np.random.default_rng((seed, 4))
    width, height = SIZE
    targets: tuple[list[Target], list[Target]] = ([], [])
    passages = []
    for person in range(people):
        a, b = 17 * rng.uniform(0.9, 1.1), 12 * rng.uniform(0.9, 1.1)
        lane = height * (person + 0.5) / people + rng.uniform(-4, 4)
        # How far from the door's border everyone is, inside the room; outside, below 0.
        ways = np.full((2, frames), -100.0)
        index, room = EMPTY + int(rng.integers(0, 150)), int(rng.integers(2))
        before: int | None = None
        while True:
            pace = rng.uniform(1.8, 3.0)
            deep = rng.uniform(0.35, 0.8) * width
            into = np.arange(-a, deep, pace)
            way = np.concatenate([into, np.full(rng.integers(5, 50), into[-1]), into[::-1]])
            if index + len(way) > frames:
                break
            ways[room, index : index + len(way)] = way
            if before is not None:
                passages.append((person, 1 - room, before, index))
            before, room = index + len(way) - 1, 1 - room
            index = before + int(rng.uniform(*TRANSIT) / FRAME_INTERVAL)
        coat = rng.integers(20, 256, (3, 3)).tolist()
        heading = np.gradient(ways, axis=1) >= 0
        for each, (way, inward) in enumerate(zip(ways, heading, strict=True)):
            x = way if each else width - 1 - way
            theta = np.where(inward == bool(each), 0.0, np.pi)
            columns = np.broadcast_arrays(x, lane, a, b, theta)
            shell, stripe, head = map(tuple, coat)
            targets[each].append(Target(np.stack(columns, axis=1), (shell, stripe, head)))
    left, right = (Clip(SIZE, tuple(t), seed=2 * seed + i) for i, t in enumerate(targets))
    return Rooms((left, right), passages)


def rig(joined: bool) -> Rig:
    """Return the rig of two rooms, whose doors are joined or not."""
    width, height = SIZE
    doors = ((width - 12, 0, 12, height), (0, 0, 12, height))
    cameras = tuple(
        Camera(name, "", place=(Place("door", door),))
        for name, door in zip(("left", "right"), doors, strict=True)
    )
    passage = CameraLink(("left/door", "right/door"), (TRANSIT[0] - 0.5, TRANSIT[1] + 1.0))
    return Rig(cameras, (passage,) * joined)


def identities(scene: Rooms, rigs: Sequence[Rig], seed: int = 0) -> list[Floats]:
    """Return for each rig whose identity each person has, (rooms, frames, people); NaN for none."""
    watches = [CrossCameraAssociation(each) for each in rigs]
    lookouts = [
        CameraReporter(camera, Scene(BackgroundDetector("gaussian"), seed=seed))
        for camera in rigs[0].camera
    ]
    count, people = len(scene.clips[0]), len(scene.clips[0].targets)
    named = [np.full((2, count, people), np.nan) for _ in rigs]
    for index in range(count):
        for room, (clip, lookout) in enumerate(zip(scene.clips, lookouts, strict=True)):
            frame, truths = clip[index]
            report = lookout.report(Frame(frame.index, frame.time, frame.pixels))
            seen = [s for s in report.sightings if s.status is Status.TRACKING]
            boxes = np.array([s.box for s in seen], np.float64).reshape(-1, 4)
            for watch, names in zip(watches, named, strict=True):
                found = watch.update(report)
                for person, truth in enumerate(truths):
                    overlaps = iou(np.array(Ellipse(*truth.ellipse).box), boxes)
                    if truth.visible > 0 and seen and overlaps.max() > FOUND:
                        names[room, index, person] = found[seen[int(overlaps.argmax())].identity]
    return named


def kept(names: Floats, passages: Sequence[tuple[int, int, int, int]]) -> list[bool]:
    """Return for each passage whether the last identity before it is the first one after it."""
    results = []
    for person, room, out, into in passages:
        before, after = names[room, : out + 1, person], names[1 - room, into:, person]
        before, after = before[np.isfinite(before)], after[np.isfinite(after)]
        results.append(bool(before.size and after.size and before[-1] == after[0]))
    return results


def two_rooms(seeds: int, frames: int) -> Experiment:
    """Yield how often an identity is kept from room to room, with handover and without."""
    ways = {"with handover": rig(True), "without": rig(False)}
    runs: dict[str, list[list[bool]]] = {name: [] for name in ways}
    for seed in range(seeds):
        scene = rooms(seed, frames)
        for name, found in zip(ways, identities(scene, list(ways.values()), seed), strict=True):
            runs[name].append(kept(found, scene.passages))
        rows: list[Row] = []
        for name, results in runs.items():
            total, good = sum(map(len, results)), sum(map(sum, results))
            low, high = wilson(good, total)
            share = percent(over(sum(each) / len(each) for each in results if each))
            between = Cell(f"{low:.1%} to {high:.1%}", good / total)
            rows.append((Cell(name), number(total, 0), number(good, 0), share, between))
        head = ("cameras", "passages", "identity kept", "share over seeds", "95 % interval")
        note = "Wilson's interval over all passages."
        table = Table("From room to room", head, rows, note=note)
        yield Result({"": table}, progress=f"{seed + 1} of {seeds} seeds")


def wilson(good: int, total: int) -> tuple[float, float]:
    """Return Wilson's interval of 95 % for a share."""
    share, z2 = good / total, Z95 * Z95
    middle = (share + z2 / (2 * total)) / (1 + z2 / total)
    half = Z95 * np.sqrt(share * (1 - share) / total + z2 / (4 * total**2)) / (1 + z2 / total)
    return float(middle - half), float(middle + half)
