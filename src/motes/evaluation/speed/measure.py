"""How long an update takes: trackers side by side, more and more targets, and particles.

Times are taken inside the tracker, on images written right before, as a decoder or a camera leaves
them in the processor's cache. Whatever is compared takes its turn in every round.
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
"""Of a frame, width and height; targets become more and more in the large one."""
MAIN = (60, 100)
TARGETS = ((28, 44), MAIN, (120, 200), (190, 316))
"""Width and height; OpenCV's trackers get the main one. The last has ten times its area."""
REFERENCE = "nummiaro"
OURS = ("default", REFERENCE, "nummiaro:adaptive", "ng_delp", "maggio", "mean_shift")
COUNTS, THREADS = (1, 10, 100, 1000), (1, 2)
PARTICLES = (50, 100, 500, 1000, 5000)

Job = tuple[str, tuple[int, int]]
"""A tracker's name and a target."""
Step = tuple[str, int]
"""A line of a plot, and how many things there are."""
Run = Callable[[], list[float]]
"""Returns seconds."""
K = TypeVar("K")


class Film(NamedTuple):
    """A rendered clip: its frames, and where its targets are in the first."""

    frames: list[Frame]
    regions: list[Ellipse]

    @classmethod
    def of(cls, clip: Clip) -> Self:
        """Render a clip."""
        frames, truths = zip(*clip, strict=True)
        return cls([*frames], [truth.ellipse for truth in truths[0]])


def interleaved(jobs: Mapping[K, Run], rounds: int) -> Iterator[dict[K, list[float]]]:
    """Yield the seconds of each job after each round of all of them: noise hits all alike."""
    seconds: dict[K, list[float]] = {key: [] for key in jobs}
    for _ in range(rounds):
        for key, run in jobs.items():
            seconds[key] += run()
        yield seconds


def trackers(films: Mapping[tuple[int, int], Film]) -> tuple[dict[Job, Run], str]:
    """Return runs over films, by target: of ours over all, of OpenCV's trackers over the main one.

    Also returns why there are none of OpenCV's trackers, or not all.
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
            jobs[name, MAIN] = partial(_theirs, name, films[MAIN])
    return jobs, " ".join(missing)


def particles(film: Film) -> dict[Step, Run]:
    """Return runs of the reference tracker with more and more particles."""
    config = preset(REFERENCE)
    return {(REFERENCE, n): ours(replace(config, particles=n), film) for n in PARTICLES}


def targets(film: Film) -> dict[Step, Run]:
    """Return runs of more and more reference trackers over one film, in one and more threads.

    Where there are more trackers than targets in the film, several follow the same one.
    """
    jobs: dict[Step, Run] = {}
    for n in COUNTS:
        ready = Trackers(soon_started())
        ready.init(film.frames[0], [film.regions[i % len(film.regions)] for i in range(n)])
        for threads in THREADS:
            line = f"{threads} thread{'s' * (threads > 1)}"
            jobs[line, n] = partial(_many, threads, ready.each, film.frames[1:])
    return jobs


def soon_started() -> TrackerConfig:
    """Return the reference tracker with a coarse look at the background of the first frame.

    Each target needs such a look at the whole frame, which for a thousand of them on a large one
    would take minutes, and starting is not what is timed.
    """
    config = preset(REFERENCE)
    assert not isinstance(config, Discriminative)
    return replace(config, presence=replace(config.presence, stride=60))


def ours(config: TrackerConfig, film: Film) -> Run:
    """Return a run of one of our trackers over a film's target; it has been started already."""
    tracker = Tracker(config)
    tracker.init(film.frames[0], film.regions[0])
    copy.copy(tracker).update(film.frames[1])  # imports what it needs
    return lambda: timed(copy.copy(tracker).update, film.frames[1:])


def _many(threads: int, each: list[Tracker], frames: Sequence[Frame]) -> list[float]:
    """Return the seconds of each update of copies of started trackers."""
    with Trackers(soon_started(), threads=threads) as trackers:
        trackers.each = [copy.copy(tracker) for tracker in each]
        return timed(trackers.update, frames)


def _theirs(name: str, film: Film) -> list[float]:
    """Return the seconds of each update of a peer over a film; conversion to BGR is not timed."""
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
