"""Nummiaro et al., section VII: what a tracker gains from the samples that another one gives it.

A film is cut in two pictures that overlap, as of two cameras. People who walk from one into the
other are known in the first. The second camera has them after some frames: as births, as births
that get the names of the first camera's objects, or from that camera's samples.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from motes.core.detection import Detection
from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse, iou
from motes.core.track import Status
from motes.mot.cameras.arrivals import VISIBLE
from motes.mot.cameras.camera_report import ObjectReport
from motes.mot.cameras.camera_reporter import CameraReporter
from motes.mot.cameras.reidentification import CrossCameraAssociation
from motes.mot.cameras.rig_config import Camera, Overlap, Rig
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene
from motes.synthetic.beetle import Target
from motes.synthetic.clips import Clip
from motes.video.sources import open_source
from motes_lab.datasets.distractors import evaluated_rows
from motes_lab.datasets.mot import MotSequence
from motes_lab.papers.result import Experiment, Result, over, wilson_interval
from motes_lab.papers.two_rooms import EMPTY
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number

SHARED = 0.25
"""Share of a film's width that both pictures show."""
WINDOW, LATER = 10, 50
"""Frames after an entry that are measured, and after which the identity is read again."""
KNOWN = 5
"""Frames for which a person must be in the first picture before entering the second one."""
MATCH_IOU = 0.3
"""An object is a person if their boxes overlap by more than this."""
NAMES = "left", "right"


class Moment(NamedTuple):
    """A frame of a film, the true boxes by number, and given detections, if there are any."""

    frame: Frame
    truth: Mapping[int, Box]
    detections: Sequence[Detection] | None


class Film(NamedTuple):
    """A film: its name, and a function that returns its frames."""

    name: str
    moments: Callable[[], Iterator[Moment]]


class Entry(NamedTuple):
    """The entry of a person into a picture: number of the person, picture, frame."""

    person: int
    view: int
    frame: int


def real_film(sequence: MotSequence) -> Film:
    """Return a sequence of people, with its truth and its detections."""
    truth, _ = evaluated_rows(sequence.truth, sequence.truth, ())

    def moments() -> Iterator[Moment]:
        with open_source(str(sequence.source)) as frames:
            for frame in frames:
                boxes = {person: box for person, box, _ in truth.listed(frame.index)}
                found = None
                if sequence.detections is not None:
                    rows = sequence.detections.listed(frame.index)
                    found = [Detection(box, score) for _, box, score in rows]
                picture = Frame(frame.index, frame.index / sequence.rate, frame.pixels)
                yield Moment(picture, boxes, found)

    return Film(sequence.name, moments)


def rendered_film(seed: int, frames: int = 500, people: int = 8) -> Film:
    """Return a film in which objects of random colors walk through the picture, both ways."""
    rng = np.random.default_rng((seed, 5))
    width, height = 400, 200
    targets = []
    for person in range(people):
        a, b = 17 * rng.uniform(0.9, 1.1), 12 * rng.uniform(0.9, 1.1)
        pace, start = rng.uniform(2.0, 3.5), EMPTY + int(rng.integers(0, frames // 2))
        path = pace * (np.arange(frames) - start) - a
        back = bool(rng.integers(2))
        x, theta = (width - 1 - path, np.pi) if back else (path, 0.0)
        y = height * (person + 0.5) / people + rng.uniform(-4, 4)
        columns = np.broadcast_arrays(x, y, a, b, theta)
        shell, stripe, head = map(tuple, rng.integers(20, 256, (3, 3)).tolist())
        targets.append(Target(np.stack(columns, axis=1), (shell, stripe, head)))
    clip = Clip((width, height), tuple(targets), seed=seed)

    def moments() -> Iterator[Moment]:
        for frame, truths in clip:
            boxes = {n: Ellipse(*t.ellipse).box for n, t in enumerate(truths) if t.visible > 0}
            yield Moment(frame, boxes, None)

    return Film(f"rendered {seed}", moments)


def views_of(width: int, shared: float = SHARED) -> tuple[range, range]:
    """Return the columns of the two pictures of a film; below 0, what is between is unseen."""
    half = round(width * (1 + shared) / 2)
    return range(half), range(width - half, width)


def part(box: Box, columns: range) -> Box | None:
    """Return the part of a box in a picture, in its coordinates; None if it is too small."""
    left, right = max(box.x, columns.start), min(box.x + box.width, columns.stop)
    if right - left < VISIBLE * box.width:
        return None
    return Box(left - columns.start, box.y, right - left, box.height)


def detected_part(found: Detection, columns: range) -> Detection | None:
    """Return a detection as a detector would give it in a picture."""
    box = part(found.box, columns)
    return None if box is None else Detection(box, found.score)


def entries(truths: Sequence[Mapping[int, Box]], views: Sequence[range]) -> list[Entry]:
    """Return the entries of people that have been in the other picture for `KNOWN` frames."""
    found = []
    since: dict[tuple[int, int], int] = {}
    for index, boxes in enumerate(truths):
        here = {(n, v) for n, box in boxes.items() for v in range(2) if part(box, views[v])}
        for person, view in sorted(here):
            first = since.get((person, view)) is None
            known = index - since.get((person, 1 - view), index) >= KNOWN
            if first and known and index + WINDOW <= len(truths):
                found.append(Entry(person, view, index))
        since = {key: since.get(key, index) for key in here}
    return found


def overlap_of(views: Sequence[range]) -> Overlap:
    """Return how the two pictures overlap."""
    shift = float(views[0].start - views[1].start)
    return Overlap(NAMES, ((1.0, 0.0, shift), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)))


def rigs(views: Sequence[range]) -> dict[str, tuple[Rig, bool]]:
    """Return the rigs that are compared, and whether their cameras give each other samples."""
    cameras = tuple(Camera(name, "") for name in NAMES)
    given, learned = overlap_of(views), Overlap(NAMES)
    return {
        "births alone": (Rig(cameras), False),
        "names": (Rig(cameras, overlap=(given,)), False),
        "samples": (Rig(cameras, overlap=(given,)), True),
        "samples, ground learned": (Rig(cameras, overlap=(learned,)), True),
    }


class Found(NamedTuple):
    """What a rig has of a person in a picture: the identity, and the overlap with the truth."""

    identity: int
    overlap: float


def run(
    moments: Sequence[Moment], rig: Rig, exchange: bool, seed: int, shared: float = SHARED
) -> list[dict[tuple[int, int], Found]]:
    """Return for each frame what a rig has of each (person, picture)."""
    association = CrossCameraAssociation(rig)
    given: list[list[Detection]] = [[], []]
    reporters: list[CameraReporter] = []
    answers = []
    for moment in moments:
        frame = moment.frame
        views = views_of(frame.width, shared)
        if not reporters:
            for view, camera in enumerate(rig.camera):
                detector = (
                    BackgroundDetector("gaussian")
                    if moment.detections is None
                    else lambda _, view=view: given[view]
                )
                reporters.append(CameraReporter(camera, Scene(detector, seed=seed), seed))
        coming = [association.arrivals(name, frame.time) if exchange else () for name in NAMES]
        answer: dict[tuple[int, int], Found] = {}
        for view, reporter in enumerate(reporters):
            columns = views[view]
            given[view] = [
                each
                for found in moment.detections or ()
                if (each := detected_part(found, columns)) is not None
            ]
            reporter.expect(coming[view])
            pixels = frame.pixels[:, columns.start : columns.stop]
            report = reporter.report(Frame(frame.index, frame.time, pixels))
            found = association.update(report)
            seen = [s for s in report.sightings if s.status is Status.TRACKING]
            answer |= _matched(moment.truth, columns, view, seen, found)
        answers.append(answer)
    return answers


def _matched(
    truth: Mapping[int, Box],
    columns: range,
    view: int,
    seen: Sequence[ObjectReport],
    identities: Mapping[int, int],
) -> dict[tuple[int, int], Found]:
    """Return what a picture's objects are of the people in it."""
    picture = range(len(columns))
    parts = [part(each.box, picture) or Box(0, 0, 0, 0) for each in seen]
    boxes, answer = np.array(parts, np.float64).reshape(-1, 4), {}
    for person, whole in truth.items():
        box = part(whole, columns)
        if box is None or not seen:
            continue
        overlaps = iou(np.array(box), boxes)
        best = int(overlaps.argmax())
        own = seen[best].identity
        if overlaps[best] > MATCH_IOU and own in identities:
            answer[person, view] = Found(identities[own], float(overlaps[best]))
    return answer


class Score(NamedTuple):
    """What became of an entry.

    Attributes
    ----------
    any, same
        Frames until the second camera has the person, and until with the first one's identity;
        `WINDOW` if not within that time.
    overlap
        Mean overlap with the truth over `WINDOW` frames; 0 in frames without the person.
    later
        Whether the identity is the first camera's in the last of `LATER` frames.
    """

    any: int
    same: int
    overlap: float
    later: bool


def score(answers: Sequence[Mapping[tuple[int, int], Found]], entry: Entry) -> Score | None:
    """Return what became of an entry; None if the first camera did not have the person."""
    person, view, first = entry
    before = [
        answers[index][person, 1 - view].identity
        for index in range(first - KNOWN, first)
        if (person, 1 - view) in answers[index]
    ]
    if not before:
        return None
    after = [answers[first + n].get((person, view)) for n in range(WINDOW)]
    has = [n for n, each in enumerate(after) if each is not None]
    right = [n for n in has if (each := after[n]) is not None and each.identity == before[-1]]
    overlap = float(np.mean([0.0 if each is None else each.overlap for each in after]))
    names = [
        answers[index][person, view].identity
        for index in range(first, min(first + LATER, len(answers)))
        if (person, view) in answers[index]
    ]
    later = bool(names) and names[-1] == before[-1]
    return Score(min([*has, WINDOW]), min([*right, WINDOW]), overlap, later)


def handover(films: Sequence[Film], seeds: int) -> Experiment:
    """Yield what the second camera gains from samples, over all entries of all films."""
    scores: dict[str, list[Score]] = {}
    for done, film in enumerate(films, start=1):
        moments = list(film.moments())
        views = views_of(moments[0].frame.width)
        entered = entries([moment.truth for moment in moments], views)
        for seed in range(seeds):
            for name, (rig, exchange) in rigs(views).items():
                answers = run(moments, rig, exchange, seed)
                found = (score(answers, entry) for entry in entered)
                scores.setdefault(name, []).extend(each for each in found if each is not None)
        table = _table(scores)
        yield Result({"": table}, progress=f"{done} of {len(films)} films")


def _table(scores: Mapping[str, Sequence[Score]]) -> Table:
    rows: list[Row] = []
    for name, results in scores.items():
        kept = [sum(each.same < WINDOW for each in results), sum(each.later for each in results)]
        shares: list[Cell] = []
        for count in kept:
            low, high = wilson_interval(count, len(results))
            text = f"{count / len(results):.0%} ({low:.0%} to {high:.0%})" if results else NO_VALUE
            shares.append(Cell(text, low))
        rows.append(
            (
                Cell(name),
                number(len(results), 0),
                number(over(each.any for each in results), 1),
                number(over(each.same for each in results), 1),
                number(over(each.overlap for each in results), 3),
                *shares,
            )
        )
    head = (
        "cameras exchange", "entries", "frames until there", "frames until known",
        f"IoU over {WINDOW} frames", f"known after {WINDOW} frames", f"after {LATER} frames",
    )  # fmt: skip
    note = (
        f"Frames from when a quarter of the person is in the second picture; {WINDOW} if it is "
        f"not there by then. Known: with the identity of the first camera; with 95 % intervals."
    )
    return Table("Handing over between overlapping cameras", head, rows, note=note)
