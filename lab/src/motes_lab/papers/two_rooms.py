"""Nummiaro et al., section VII: identities of people who walk between two rooms with cameras.

The paper has one person and proposes the exchange; here several people walk to and fro, with known
truth.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse, iou
from motes.core.track import Status
from motes.core.types import Floats
from motes.mot.cameras.arrivals import VISIBLE
from motes.mot.cameras.camera_reporter import CameraReporter
from motes.mot.cameras.reidentification import CrossCameraAssociation
from motes.mot.cameras.rig_config import Camera, CameraLink, Rig
from motes.sot.places import Place
from motes.synthetic.beetle import Target
from motes.synthetic.clips import Clip
from motes_lab.papers.expected_time import (
    MEASURED_FRAMES,
    Expected,
    SceneFactory,
    seconds_per_frame,
)
from motes_lab.papers.result import Experiment, Result, over, wilson_interval
from motes_lab.report.tables import Cell, Row, Table, number, percent

SIZE = (320, 240)
PEOPLE = 4
EMPTY = 40
"""Frames at the start without people, in which the background is learned."""
TRANSIT = (1.0, 2.5)
"""Seconds from leaving one room completely to entering through the door of the other."""
MATCH_IOU = 0.3
"""An object is a person if their boxes overlap by more than this."""


NAMES = "left", "right"


class Way(NamedTuple):
    """Whether the doors of two cameras are linked, and whether people are expected there."""

    linked: bool
    expects: bool


WAYS = {
    "with handover": Way(True, True),
    "names alone": Way(True, False),
    "without": Way(False, False),
}


class Rooms(NamedTuple):
    """Two clips with the same people in the same order, and their passages between the rooms.

    Attributes
    ----------
    clips
        The left room, whose door is the right border, and the right room, whose door is the left
        border.
    passages
        (person, room, last frame in it, first frame in the other room).
    """

    clips: tuple[Clip, Clip]
    passages: list[tuple[int, int, int, int]]


def rooms(seed: int = 0, frames: int = 1500, people: int = PEOPLE) -> Rooms:
    """Return two rooms through whose doors people of random colors walk, with random pauses.

    Each person enters by the door, walks to a position in the room, stays for a while, and walks
    out.
    """
    rng = np.random.default_rng((seed, 4))
    width, height = SIZE
    targets: tuple[list[Target], list[Target]] = ([], [])
    passages = []
    for person in range(people):
        a, b = 17 * rng.uniform(0.9, 1.1), 12 * rng.uniform(0.9, 1.1)
        lane = height * (person + 0.5) / people + rng.uniform(-4, 4)
        # Distance from the border with the door, by room; below 0 outside of the room.
        distances = np.full((2, frames), -100.0)
        index, room = EMPTY + int(rng.integers(0, 150)), int(rng.integers(2))
        last_out: int | None = None
        while True:
            pace = rng.uniform(1.8, 3.0)
            depth = rng.uniform(0.35, 0.8) * width
            into = np.arange(-a, depth, pace)
            path = np.concatenate([into, np.full(rng.integers(5, 50), into[-1]), into[::-1]])
            if index + len(path) > frames:
                break
            distances[room, index : index + len(path)] = path
            if last_out is not None:
                passages.append((person, 1 - room, last_out, index))
            last_out, room = index + len(path) - 1, 1 - room
            index = last_out + int(rng.uniform(*TRANSIT) / FRAME_INTERVAL)
        colors = rng.integers(20, 256, (3, 3)).tolist()
        heading = np.gradient(distances, axis=1) >= 0
        for each, (path, inward) in enumerate(zip(distances, heading, strict=True)):
            x = path if each else width - 1 - path
            theta = np.where(inward == bool(each), 0.0, np.pi)
            columns = np.broadcast_arrays(x, lane, a, b, theta)
            shell, stripe, head = map(tuple, colors)
            targets[each].append(Target(np.stack(columns, axis=1), (shell, stripe, head)))
    left, right = (Clip(SIZE, tuple(t), seed=2 * seed + i) for i, t in enumerate(targets))
    return Rooms((left, right), passages)


def rig(linked: bool) -> Rig:
    """Return the rig of two rooms, whose doors are linked or not."""
    width, height = SIZE
    doors = ((width - 12, 0, 12, height), (0, 0, 12, height))
    cameras = tuple(
        Camera(name, "", place=(Place("door", door),))
        for name, door in zip(NAMES, doors, strict=True)
    )
    passage = CameraLink(("left/door", "right/door"), (TRANSIT[0] - 0.5, TRANSIT[1] + 1.0))
    return Rig(cameras, (passage,) * linked)


def identities(
    rooms: Rooms, ways: Sequence[Way], scene: SceneFactory, seed: int = 0
) -> list[Floats]:
    """Return the identity of each person for each way, (rooms, frames, people); NaN for none.

    `scene` makes the scene of each camera.
    """
    associations = [CrossCameraAssociation(rig(way.linked)) for way in ways]
    reporters = [
        [CameraReporter(camera, scene(seed), seed) for camera in rig(way.linked).camera]
        for way in ways
    ]
    count, people = len(rooms.clips[0]), len(rooms.clips[0].targets)
    identities_by_way = [np.full((2, count, people), np.nan) for _ in ways]
    for index in range(count):
        pictures = [clip[index] for clip in rooms.clips]
        for way, association, pair, names in zip(
            ways, associations, reporters, identities_by_way, strict=True
        ):
            now = pictures[0][0].time
            coming = [association.arrivals(n, now) if way.expects else () for n in NAMES]
            for room, reporter in enumerate(pair):
                frame, truths = pictures[room]
                reporter.expect(coming[room])
                report = reporter.report(Frame(frame.index, frame.time, frame.pixels))
                found = association.update(report)
                seen = [
                    each
                    for each in report.sightings
                    if each.status is Status.TRACKING and each.identity in found
                ]
                boxes = np.array([s.box for s in seen], np.float64).reshape(-1, 4)
                for person, truth in enumerate(truths):
                    overlaps = iou(np.array(Ellipse(*truth.ellipse).box), boxes)
                    if truth.visible > 0 and seen and overlaps.max() > MATCH_IOU:
                        names[room, index, person] = found[seen[int(overlaps.argmax())].identity]
    return identities_by_way


def kept(names: Floats, passages: Sequence[tuple[int, int, int, int]]) -> list[bool]:
    """Return for each passage whether the last identity before it equals the first one after it."""
    results = []
    for person, room, out, into in passages:
        before, after = names[room, : out + 1, person], names[1 - room, into:, person]
        before, after = before[np.isfinite(before)], after[np.isfinite(after)]
        results.append(bool(before.size and after.size and before[-1] == after[0]))
    return results


def until_known(
    names: Floats, passages: Sequence[tuple[int, int, int, int]], clips: Sequence[Clip]
) -> list[int]:
    """Return for each passage in which the identity is kept how long it takes, in frames.

    Frames count from when a quarter of the person is in the other room's picture.
    """
    frames = []
    for passage, same in zip(passages, kept(names, passages), strict=True):
        person, room, _, into = passage
        after = np.flatnonzero(np.isfinite(names[1 - room, into:, person]))
        if not same:
            continue
        states = clips[1 - room].targets[person].states
        x, a = states[into:, 0], states[into:, 2]
        shown = np.minimum(x + a, SIZE[0]) - np.maximum(x - a, 0) > VISIBLE * 2 * a
        frames.append(int(after[0]) - int(shown.argmax()))
    return frames


def expected(seeds: int, frames: int, scene: SceneFactory) -> Expected:
    """Return the expected time of `two_rooms`, measured on a few frames of a room."""
    clip = rooms(0, frames).clips[0]
    step = max(len(clip) / MEASURED_FRAMES, 1.0)
    measured = (clip[int(i * step)][0] for i in range(min(MEASURED_FRAMES, len(clip))))
    total = 2 * seeds * frames
    seconds = len(WAYS) * total * seconds_per_frame(scene(0), measured)
    return Expected(f"{2 * seeds} clips, {total} frames", seconds)


def two_rooms(seeds: int, frames: int, scene: SceneFactory) -> Experiment:
    """Yield how often an identity is kept from room to room, with handover and without."""
    runs: dict[str, list[list[bool]]] = {name: [] for name in WAYS}
    waits: dict[str, list[int]] = {name: [] for name in WAYS}
    for seed in range(seeds):
        pair = rooms(seed, frames)
        found_by_way = identities(pair, list(WAYS.values()), scene, seed)
        for name, found in zip(WAYS, found_by_way, strict=True):
            runs[name].append(kept(found, pair.passages))
            waits[name] += until_known(found, pair.passages, pair.clips)
        progress = f"{seed + 1} of {seeds} pairs of rooms"
        yield Result({"": compared(runs, waits)}, None, (), progress, (seed + 1) / seeds)


def compared(
    runs: Mapping[str, Sequence[Sequence[bool]]], waits: Mapping[str, Sequence[int]]
) -> Table:
    """Return how often the identity was kept, of passages by run, and how soon it was known."""
    rows: list[Row] = []
    for name, results in runs.items():
        total, good = sum(map(len, results)), sum(map(sum, results))
        low, high = wilson_interval(good, total)
        share = percent(over(sum(each) / len(each) for each in results if each))
        between = Cell(f"{low:.1%} to {high:.1%}", good / total)
        wait = number(over(waits[name]) if waits[name] else None, 1)
        rows.append((Cell(name), number(total, 0), number(good, 0), share, between, wait))
    head = (
        *("cameras", "passages", "identity kept", "share over runs", "95 % interval"),
        "frames until known",
    )
    note = (
        "Wilson's interval over all passages. Frames from when a quarter of the person is in "
        "the other room's picture, where the identity is kept."
    )
    return Table("From room to room", head, rows, note=note)
