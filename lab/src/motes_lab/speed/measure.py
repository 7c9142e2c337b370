"""Time of an update of all trackers, on rendered clips and on real sequences.

Times are measured inside the tracker, on images written right before, since a decoder or a camera
also leaves them in the processor's cache. All compared trackers run in turn in every round. On real
sequences they take turns frame by frame.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from itertools import islice
from typing import Any, NamedTuple, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from motes import (
    Ellipse,
    Frame,
    MissingDependencyError,
    OpenCVTracker,
    Tracker,
    TrackerConfig,
    open_source,
    preset,
)
from motes.core import explain
from motes.synthetic import Clip
from motes_lab.adapters.opencv import PEERS, is_peer, peer
from motes_lab.datasets.sot import Problem, Sequence as TrueSequence

SIZE = (640, 480)
"""Width and height of a frame."""
MAIN = (60, 100)
TARGETS = ((28, 44), MAIN, (120, 200), (190, 316))
"""Width and height; OpenCV's trackers get the main one. The last has ten times its area."""
REFERENCE = "nummiaro"
OURS = ("default", REFERENCE, "nummiaro:adaptive", "ng_delp", "maggio", "mean_shift")
SEQUENCES = ("David", "Jogging-1", "Surfer", "vot14-car", "Skiing")
"""Real sequences: gray and color, small and large targets in small and large frames."""
FOLLOWERS = ("default", REFERENCE)
RIVALS = ("cv2:csrt", "cv2:kcf", "cv2:mosse")
"""Trackers of motes and of OpenCV that run on real sequences."""

Job = tuple[str, tuple[int, int]]
"""A tracker's name and a target."""
Run = Callable[[], list[float]]
"""A function that returns running times in seconds."""
K = TypeVar("K")


class Film(NamedTuple):
    """A rendered clip: its frames, and the regions of its targets in the first frame."""

    frames: list[Frame]
    regions: list[Ellipse]

    @classmethod
    def of(cls, clip: Clip, frames: int | None = None) -> Self:
        """Render a clip, or its first frames."""
        rendered, truths = zip(*islice(clip, frames), strict=True)
        return cls([*rendered], [truth.ellipse for truth in truths[0]])


def interleaved(jobs: Mapping[K, Run], rounds: int) -> Iterator[dict[K, list[float]]]:
    """Yield the seconds of each job after each round of all, so that noise affects all equally."""
    seconds: dict[K, list[float]] = {key: [] for key in jobs}
    for _ in range(rounds):
        for key, run in jobs.items():
            seconds[key] += run()
        yield seconds


def trackers(films: Mapping[tuple[int, int], Film]) -> tuple[dict[Job, Run], str]:
    """Return runs by tracker and target: motes on all films, OpenCV's trackers on the main one.

    The second return value is the reason why trackers of OpenCV are missing, or "".
    """
    jobs: dict[Job, Run] = {}
    for name in OURS:
        for target, film in films.items():
            jobs[name, target] = ours(preset(name), film)
    names, missing = available(PEERS)
    for name in names:
        jobs[name, MAIN] = partial(_peer_run, name, films[MAIN])
    return jobs, missing


def available(names: Iterable[str]) -> tuple[list[str], str]:
    """Return the trackers of OpenCV that are installed, and the reason why others are missing."""
    found: list[str] = []
    missing: dict[str, None] = {}
    for name in names:
        try:
            peer(name)
        except MissingDependencyError as error:
            missing[str(error)] = None
        else:
            found.append(name)
    return found, " ".join(missing)


def ours(config: TrackerConfig, film: Film) -> Run:
    """Return a run of one tracker of motes on a film's target; the tracker is already started."""
    tracker = started(config, film.frames[0], film.regions[0])
    return lambda: timed(copy.copy(tracker).update, film.frames[1:])


def started(config: TrackerConfig, frame: Frame, region: Ellipse) -> Tracker:
    """Return a tracker that has started on a region of a frame."""
    tracker = Tracker(config)
    tracker.init(frame, region)
    return tracker


def _peer_run(name: str, film: Film) -> list[float]:
    """Return the seconds of each update of a peer on a film, without the conversion to BGR."""
    tracker = peer(name)
    images = [_bgr(frame) for frame in film.frames]
    tracker.init(images[0], [round(value) for value in film.regions[0].box])
    return timed(tracker.update, images[1:])


def in_lockstep(
    names: Sequence[str], sequence: TrueSequence, frames: int
) -> tuple[dict[str, list[float]], list[Problem]]:
    """Return the seconds of each update of each tracker on the first frames of a real sequence.

    Each tracker has a decoder of its own. A frame is decoded, and made BGR, right before the
    tracker gets it, as in a program that reads a film with OpenCV; only the update is measured. The
    trackers of motes are `OpenCVTracker`s. A tracker of OpenCV that fails is left out from there
    on; the second return value has its error.
    """
    seconds: dict[str, list[float]] = {name: [] for name in names}
    problems: list[Problem] = []
    first = int(np.argmin(np.isnan(sequence.boxes[:, 0])))
    box = [round(value) for value in sequence.boxes[first].tolist()]
    with ExitStack() as stack:
        films = {
            name: islice(stack.enter_context(open_source(sequence.source)), first, first + frames)
            for name in names
        }
        trackers = {name: peer(name) if is_peer(name) else OpenCVTracker(name) for name in names}
        for name, film in films.items():
            trackers[name].init(_bgr(next(film)), box)
        for _ in range(min(frames, sequence.frames - first) - 1):
            for name, film in [*films.items()]:
                image = _bgr(next(film))
                try:
                    start = time.perf_counter()
                    trackers[name].update(image)
                    seconds[name].append(time.perf_counter() - start)
                except Exception as error:  # some raise OpenCV's errors at the border of a frame
                    if not is_peer(name):
                        raise
                    problems.append(Problem(f"{name} on {sequence.name}", explain(error)))
                    del films[name]
    return seconds, problems


def _bgr(frame: Frame) -> NDArray[np.uint8]:
    return np.ascontiguousarray(frame.pixels[:, :, ::-1])


def timed(update: Callable[[Any], object], images: Iterable[Any]) -> list[float]:
    """Return the seconds of each update, on images that have just been written."""
    seconds = []
    for image in map(copy.deepcopy, images):
        start = time.perf_counter()
        update(image)
        seconds.append(time.perf_counter() - start)
    return seconds
