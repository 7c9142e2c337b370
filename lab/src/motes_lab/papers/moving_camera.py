"""Cameras that move: how exactly their motion is found, and how many identities it keeps.

A still film is seen by a camera that pans, turns, zooms and shakes, so its motion and all boxes are
known exactly. Films from drones have the truth of one object.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import cv2
import numpy as np
from msgspec import structs

from motes import (
    BackgroundConfig,
    BackgroundDetector,
    Box,
    Detection,
    Detector,
    Frame,
    Scene,
    Status,
    open_source,
    scene_config,
)
from motes.core import Floats, iou
from motes.mot import GlobalMotion, PannedDetector
from motes_lab.datasets.distractors import evaluated_rows
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.mot_rows import MotRows, rows_of
from motes_lab.datasets.sot import Sequence as Film
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import crowds_of, films_of
from motes_lab.metrics.mot import Tally, tally
from motes_lab.report.tables import Cell, Row, Table, number, percent

Model = Literal["homography", "similarity"]
"""How `GlobalMotion` moves a picture."""
VIEW = 2 / 3
"""Width and height of the moving camera's picture, as shares of the film's."""
PERIOD = 4.0
"""Seconds of one pan to the right and back."""
TURN, ZOOM, SHAKE = np.radians(2), 0.1, 1.0
"""Largest turn; largest change of scale; standard deviation of the shake in pixels."""
SEED = 0
"""Seed of the shake: all trackers see the same film."""
GRID = 5
"""Points in x and y at which two motions are compared."""
HIT = 0.3
"""Least overlap of a track with a drone's target, whose boxes are a few pixels wide."""
TINY = BackgroundConfig(least=2e-4)
"""Targets of drones have 10 by 6 pixels, 0.0002 of a frame of 640 by 360."""


def moving_camera(dataset: Path, /, *drones: Path, results: ResultOptions = ResultOptions()) -> int:
    """Hard films: identities before a camera that moves.

    Parameters
    ----------
    dataset
        A folder of sequences of many objects, as for motes-lab evaluate, from still cameras. They
        are seen by a camera that pans, turns, zooms and shakes.
    drones
        Folders of sequences of one object, from cameras that move.
    """
    crowds, problems = crowds_of(dataset)
    films = []
    for folder in drones:
        found, failed = films_of(folder, ["0"])
        films += found
        problems += failed
    return results.show("moving-camera", moving_cameras(crowds, films), problems)


class View(NamedTuple):
    """What a virtual camera sees of a film: its picture's size, and for each frame a motion."""

    width: int
    height: int
    """In pixels."""
    places: Floats
    """(frames, 3, 3), from the film's pixels to those of the view."""


def view_of(width: int, height: int, frames: int, rate: float, *, moves: bool) -> View:
    """Return a view of the middle of a film, by a camera at rest, or one that moves."""
    w, h = round(VIEW * width), round(VIEW * height)
    phase = 2 * np.pi * np.arange(frames) / (rate * PERIOD) * moves
    rng = np.random.default_rng(SEED)
    shake = rng.normal(0, SHAKE, (frames, 2)) * moves
    margin = 0.5 * (1 - VIEW) * 0.8  # the rest is for turns and shake
    x = width / 2 + margin * width * np.sin(phase) + shake[:, 0]
    y = height / 2 + 0.5 * margin * height * np.sin(0.7 * phase) + shake[:, 1]
    scale, angle = 1 + ZOOM * (1 - np.cos(phase)) / 2, TURN * np.sin(1.3 * phase)
    places = np.zeros((frames, 3, 3))
    places[:, 0, 0] = places[:, 1, 1] = scale * np.cos(angle)
    places[:, 1, 0] = scale * np.sin(angle)
    places[:, 0, 1] = -places[:, 1, 0]
    middle = np.stack([x, y], axis=1)
    places[:, :2, 2] = (w / 2, h / 2) - (places[:, :2, :2] @ middle[:, :, None])[:, :, 0]
    places[:, 2, 2] = 1
    return View(w, h, places)


def seen(view: View, sequence: MotSequence, frames: Iterable[Frame]) -> Iterator[Frame]:
    """Yield the frames of a sequence as a view has them."""
    for frame in frames:
        pixels = cv2.warpAffine(
            np.ascontiguousarray(frame.pixels),
            view.places[frame.index][:2],
            (view.width, view.height),
            borderMode=cv2.BORDER_REFLECT,
        )
        yield Frame(frame.index, frame.index / sequence.rate, np.asarray(pixels, np.uint8))


def rows_in(view: View, rows: MotRows) -> MotRows:
    """Return the rows whose box's middle is in a view, in its pixels."""
    matrices = view.places[rows.frames - 1]
    middle = rows.boxes[:, :2] - 1 + (rows.boxes[:, 2:] - 1) / 2  # pixels count from 1 there
    moved = (matrices[:, :2, :2] @ middle[:, :, None])[:, :, 0] + matrices[:, :2, 2]
    sizes = rows.boxes[:, 2:] * np.sqrt(np.linalg.det(matrices[:, :2, :2]))[:, None]
    inside = np.all((moved >= 0) & (moved < (view.width, view.height)), axis=1)
    boxes = np.concatenate([moved - (sizes - 1) / 2 + 1, sizes], axis=1)
    return replace(rows, boxes=boxes).where(inside)


def motions(frames: Iterable[Frame], model: Model) -> list[Floats]:
    """Return the motions between frames, as `GlobalMotion` finds them; identity where unclear."""
    estimator = GlobalMotion(model)
    found = [estimator.update(frame.pixels) for frame in frames]
    return [np.eye(3) if each is None else each for each in found[1:]]


def motion_errors(view: View, found: Sequence[Floats]) -> Floats:
    """Return how far motions (3, 3) are off, (frames - 1,): the mean over a grid, in pixels."""
    x, y = np.meshgrid(np.linspace(0, view.width, GRID), np.linspace(0, view.height, GRID))
    grid = np.stack([x.ravel(), y.ravel(), np.ones(GRID**2)])
    true = view.places[1:] @ np.linalg.inv(view.places[:-1]) @ grid
    taken = np.stack(found) @ grid
    off = taken[:, :2] / taken[:, 2:] - true[:, :2] / true[:, 2:]
    errors: Floats = np.hypot(off[:, 0], off[:, 1]).mean(axis=1)
    return errors


def followed(sequence: MotSequence, truth: MotRows, frames: Iterable[Frame], scene: Scene) -> Tally:
    """Return the scores of a scene over frames."""
    lines: list[list[float]] = []
    for frame in frames:
        lines += [
            [frame.index + 1, each.identity, box.x + 1, box.y + 1, *box[2:], 1]
            for each, box in ((each, each.box) for each in scene.update(frame))
            if each.status is Status.TRACKING
        ]
    return tally(*evaluated_rows(truth, rows_of(lines), sequence.distractors), sequence.frames)


class _Arm(NamedTuple):
    """A row of the table: a camera, the detector before it, and what the scene is told."""

    name: str
    moves: bool
    detector: Callable[[View], Detector]
    camera: Literal["auto", "still", "moving"] = "auto"

    def scene(self, view: View) -> Scene:
        """Return the scene before a view."""
        config = structs.replace(scene_config(), camera=self.camera)
        return Scene(self.detector(view), config)


def moving_cameras(sequences: Sequence[MotSequence], drones: Sequence[Film]) -> Experiment:
    """Yield the tables of moving cameras: motions, identities, drones."""
    tables: dict[str, Table] = {}
    errors: dict[str, list[Floats]] = {}
    rows: list[Row] = []
    for sequence in sequences:
        still = [np.eye(3)] * (sequence.frames - 1)
        for name, model in (("nothing", None), *((each, each) for each in get_args(Model))):
            view, frames = view_frames(sequence, moves=True)
            found = still if model is None else motions(frames, model)
            errors.setdefault(name, []).append(motion_errors(view, found))
        tables["motion"] = _motions(errors)
        for arm in _arms(sequence):
            view, frames = view_frames(sequence, moves=arm.moves)
            truth = rows_in(view, sequence.truth)
            counts = followed(sequence, truth, frames, arm.scene(view))
            rows.append(_identities(f"{sequence.name}, {arm.name}", counts))
            tables["identities"] = Table(
                "A moving camera: identities",
                ("film, detections, camera", "HOTA", "AssA", "IDF1", "switches"),
                rows,
            )
            yield Result(dict(tables), progress=f"{sequence.name}, {arm.name}")
    kept: list[Row] = []
    for film in drones:
        for name, make in _DRONE_ARMS:
            kept.append(_drone(film, name, make()))
            tables["drones"] = Table(
                "A moving camera: one target from a drone",
                ("film, background", "frames with a track on it", "identities", "by the longest"),
                kept,
                note=f"A track is on the target at an IoU of {HIT} or above.",
            )
            yield Result(dict(tables), progress=f"{film.name}, {name}")


def view_frames(sequence: MotSequence, *, moves: bool) -> tuple[View, Iterator[Frame]]:
    """Return a view of a sequence, and its frames."""
    with open_source(sequence.source) as source:
        view = view_of(source.width, source.height, sequence.frames, sequence.rate, moves=moves)

    def frames() -> Iterator[Frame]:
        with open_source(sequence.source, end=sequence.frames) as source:
            yield from seen(view, sequence, source)

    return view, frames()


def _arms(sequence: MotSequence) -> list[_Arm]:
    """Return the cameras and detectors that are compared."""

    def given(view: View) -> Detector:
        assert sequence.detections is not None
        found = rows_in(view, sequence.detections)
        return lambda frame: found.detections(frame.index)

    def mog2(view: View) -> Detector:
        return BackgroundDetector()

    arms = [
        _Arm("mog2, at rest", False, mog2),
        _Arm("mog2, moves", True, mog2),
        _Arm("background that moves along, moves", True, lambda view: PannedDetector()),
    ]
    if sequence.detections is None:
        return arms
    return [
        _Arm("given, at rest", False, given),
        _Arm("given, moves, taken for still", True, given, "still"),
        _Arm("given, moves, followed", True, given),
        _Arm("given, moves, motion known", True, lambda view: _Known(given(view), view)),
        *arms,
    ]


def _motions(errors: dict[str, list[Floats]]) -> Table:
    rows = []
    for name, each in errors.items():
        all_of = np.concatenate(each)
        quantiles = np.quantile(all_of, [0.5, 0.95, 1])
        rows.append((Cell(name), *(number(float(value), 2) for value in quantiles)))
    head = ("taken for", "median", "95 % below", "worst")
    return Table("A moving camera: its motion, in pixels off", head, rows)


def _identities(name: str, counts: Tally) -> Row:
    shares = (float(counts.hota.mean()), float(counts.assa.mean()), counts.idf1)
    return (Cell(name), *map(number, shares), number(counts.switches, 1))


class _Known:
    """A detector whose camera moves as is known exactly."""

    def __init__(self, detector: Detector, view: View) -> None:
        self._detector, self._places = detector, view.places
        self.motion: Floats | None = None

    def __call__(self, frame: Frame) -> Any:
        now, before = self._places[frame.index], self._places[max(frame.index - 1, 0)]
        self.motion = now @ np.linalg.inv(before)
        return self._detector(frame)


class _Ignored:
    """A detector whose camera is taken for still."""

    def __init__(self) -> None:
        self._detector = PannedDetector(TINY)
        self.observe = self._detector.observe

    def __call__(self, frame: Frame) -> list[Detection]:
        return self._detector(frame)


_DRONE_ARMS: tuple[tuple[str, Callable[[], Detector]], ...] = (
    ("mog2", lambda: BackgroundDetector(TINY)),
    ("moves along, objects do not", _Ignored),
    ("moves along, objects too", lambda: PannedDetector(TINY)),
)


def _drone(film: Film, name: str, detector: Detector) -> Row:
    """Return how long a drone's target has a track, and how many identities these have."""
    identities: Counter[int] = Counter()
    present, scene = 0, Scene(detector)
    with open_source(film.source, end=film.frames) as source:
        for frame in source:
            tracks = [each for each in scene.update(frame) if each.status is Status.TRACKING]
            box = film.boxes[frame.index]
            if not np.isfinite(box).all():
                continue
            present += 1
            boxes = np.array([each.box for each in tracks]).reshape(-1, 4)
            overlaps = iou(np.array(Box(*box.tolist())), boxes)
            if len(tracks) and overlaps.max() >= HIT:
                identities[tracks[int(overlaps.argmax())].identity] += 1
    longest = max(identities.values(), default=0)
    return (
        Cell(f"{film.name}, {name}"),
        percent(identities.total() / present),
        number(len(identities), 0),
        percent(longest / present),
    )
