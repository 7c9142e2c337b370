"""Time of an update: for all trackers, for growing numbers of targets, and of particles.

Times are measured inside the tracker, on images written right before, since a decoder or a camera
also leaves them in the processor's cache. All compared trackers run in turn in every round.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, Self, TypeVar

from msgspec.structs import replace

from motes.core.errors import MissingDependencyError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.evaluation.adapters.opencv import PEERS, peer
from motes.evaluation.synthetic.clips import Clip
from motes.sot.batch import Trackers
from motes.sot.discriminative.tracker import Discriminative
from motes.sot.presets import TrackerConfig, preset
from motes.sot.tracker import Tracker

SIZE, LARGE = (640, 480), (1920, 1080)
"""Width and height of a frame; growing numbers of targets are measured in the large one."""
MAIN = (60, 100)
TARGETS = ((28, 44), MAIN, (120, 200), (190, 316))
"""Width and height; OpenCV's trackers get the main one. The last has ten times its area."""
REFERENCE = "nummiaro"
OURS = ("default", REFERENCE, "nummiaro:adaptive", "ng_delp", "maggio", "mean_shift")
COUNTS, THREADS = (1, 10, 100, 1000), (1, 2)
PARTICLES = (50, 100, 500, 1000, 5000)

Job = tuple[str, tuple[int, int]]
"""A tracker's name and a target."""
Count = tuple[str, int]
"""A line of a plot, and a number of targets or particles."""
Run = Callable[[], list[float]]
"""A function that returns running times in seconds."""
K = TypeVar("K")


class Film(NamedTuple):
    """A rendered clip: its frames, and the regions of its targets in the first frame."""

    frames: list[Frame]
    regions: list[Ellipse]

    @classmethod
    def of(cls, clip: Clip) -> Self:
        """Render a clip."""
        frames, truths = zip(*clip, strict=True)
        return cls([*frames], [truth.ellipse for truth in truths[0]])


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
    missing: dict[str, None] = {}
    for name in PEERS:
        try:
            peer(name)
        except MissingDependencyError as error:
            missing[str(error)] = None
        else:
            jobs[name, MAIN] = partial(_peer_run, name, films[MAIN])
    return jobs, " ".join(missing)


def particles(film: Film) -> dict[Count, Run]:
    """Return runs of the reference tracker with growing numbers of particles."""
    config = preset(REFERENCE)
    return {(REFERENCE, n): ours(replace(config, particles=n), film) for n in PARTICLES}


def targets(film: Film) -> dict[Count, Run]:
    """Return runs of growing numbers of reference trackers on one film, by number of threads.

    If there are more trackers than targets in the film, several follow the same target.
    """
    jobs: dict[Count, Run] = {}
    for n in COUNTS:
        ready = Trackers(quick_start_config())
        ready.init(film.frames[0], [film.regions[i % len(film.regions)] for i in range(n)])
        for threads in THREADS:
            line = f"{threads} thread{'s' * (threads > 1)}"
            jobs[line, n] = partial(_many, threads, ready.each, film.frames[1:])
    return jobs


def quick_start_config() -> TrackerConfig:
    """Return the reference tracker with a coarse grid for the background of the first frame.

    Each target is compared with the whole first frame. For a thousand targets in a large frame this
    would take minutes, and the start is not measured.
    """
    config = preset(REFERENCE)
    assert not isinstance(config, Discriminative)
    return replace(config, presence=replace(config.presence, stride=60))


def ours(config: TrackerConfig, film: Film) -> Run:
    """Return a run of one tracker of motes on a film's target; the tracker is already started."""
    tracker = Tracker(config)
    tracker.init(film.frames[0], film.regions[0])
    copy.copy(tracker).update(film.frames[1])  # the first call compiles kernels
    return lambda: timed(copy.copy(tracker).update, film.frames[1:])


def _many(threads: int, each: list[Tracker], frames: Sequence[Frame]) -> list[float]:
    """Return the seconds of each update of copies of started trackers."""
    with Trackers(quick_start_config(), threads=threads) as trackers:
        trackers.each = [copy.copy(tracker) for tracker in each]
        return timed(trackers.update, frames)


def _peer_run(name: str, film: Film) -> list[float]:
    """Return the seconds of each update of a peer on a film, without the conversion to BGR."""
    tracker = peer(name)
    images = [frame.pixels[:, :, ::-1].copy() for frame in film.frames]
    tracker.init(images[0], [round(value) for value in film.regions[0].box])
    return timed(tracker.update, images[1:])


def timed(update: Callable[[Any], object], images: Sequence[Any]) -> list[float]:
    """Return the seconds of each update, on images that have just been written."""
    seconds = []
    for image in map(copy.deepcopy, images):
        start = time.perf_counter()
        update(image)
        seconds.append(time.perf_counter() - start)
    return seconds
