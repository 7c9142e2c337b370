"""`motes demo`: films of three kinds, followed, counted, and shown on one page.

What only the playing of films needs is imported late, so that its processes begin sooner.
"""

from __future__ import annotations

import contextlib
import html
import importlib
import io
import json
import math
import pickle
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import resources
from itertools import islice
from multiprocessing.connection import Connection, wait
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from cyclopts import Parameter
from numpy.typing import ArrayLike
from rich.console import Console
from rich.table import Table

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_counts, prepared_folder
from motes.cli.messages import log
from motes.cli.option_groups import OUTPUT, RUN, Overwrite
from motes.core import interrupts
from motes.core.errors import ConfigError, FormatError
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Box, iou
from motes.core.resources import environment, thread_limits
from motes.core.track import Status
from motes.core.types import Bytes
from motes.core.worker import Answer, Done, Failed, Worker, blocked_signals, do_tasks, receive
from motes.output.overlay import draw, font

if TYPE_CHECKING:
    from motes.sot.tracker import Tracker
    from motes.synthetic.clips import Truth

Films = Callable[[int], "Iterable[tuple[Frame, tuple[Truth, ...]]]"]

HIT = 0.1
"""An estimate that overlaps the truth by less has lost the target."""
PATIENCE = 15
"""Frames off the target after which another tracker is stopped: OpenCV's do not search."""
RIVALS = {"CSRT": (230, 159, 0), "KCF": (204, 121, 167), "mean shift": (230, 159, 0)}
"""Trackers beside the default one, and the colors of their boxes."""
ROAD = 130, 235
"""The rows between which the line of counting goes."""
TRUTH_COLUMNS = "frame,time,x,y,a,b,theta,visible"


class Story(NamedTuple):
    """A film of the demo."""

    name: str
    """The first part of the names of its files."""
    title: str
    """What happens."""
    film: Films
    """Renders it, given a seed; the first object is followed."""
    line: int | None = None
    """x of an upright line at which objects are counted; None for none."""
    peers: Sequence[str] = ("KCF",)
    """Trackers of OpenCV that follow the target too."""


def _film(name: str, *size: tuple[int, int]) -> Films:
    """Return a film of `motes.synthetic`."""
    return lambda seed: getattr(importlib.import_module("motes.synthetic"), name)(*size, seed=seed)


STORIES = (
    Story(
        "beetle",
        "An animal hides behind a stem, turns, grows, leaps and leaves",
        _film("demo", (480, 360)),
        peers=("CSRT", "KCF"),  # CSRT is slow: once is enough
    ),
    Story("street", "A car passes behind a lorry, and cars are counted", _film("Street"), 150),
    Story(
        "player",
        "A player runs among others who look alike, before a moving camera",
        _film("Pitch"),
    ),
)
PAGE = "index.html"
TRACKED = ".mp4", "-tracked.mp4", ".csv", "-truth.csv"
COUNTED = "-counted.mp4", "-objects.csv", "-objects.csv.run.json", "-events.jsonl"
"""The ends of the names of a film's files, and of one with a line."""
FILES = (
    PAGE,
    *(story.name + end for story in STORIES for end in TRACKED),
    *(story.name + end for story in STORIES if story.line is not None for end in COUNTED),
)


def demo(
    *,
    frames: Annotated[int | None, Parameter(group=RUN)] = None,
    seed: Annotated[int, Parameter(group=RUN)] = 0,
    out: Annotated[Path, Parameter(group=OUTPUT)] = Path("demo"),
    overwrite: Overwrite = False,
) -> int:
    """Render three films, follow what is in them, and show all on a page.

    The films are an animal that hides and grows, a street whose cars are counted, and a player
    among others who look alike. The default tracker is drawn beside KCF, in the first film also
    beside CSRT, where OpenCV has them, and beside mean shift elsewhere. Open index.html in the
    folder.

    Parameters
    ----------
    frames
        Largest number of frames of each film; by default all.
    seed
        Seed of the scenery and of the particles: 0 or more.
    out
        Folder for the films, rows and the page.
    overwrite
        Whether existing files are replaced.
    """
    if seed < 0:
        raise ConfigError(f"The seed is {seed}; give 0 or more.")
    if frames is not None:
        check_counts(frames=frames)
    console = Console()
    plays: dict[int, Played] = {}
    # A film's files appear together, when all are done.
    with (
        prepared_folder(out, FILES, overwrite),
        tempfile.TemporaryDirectory(prefix=".demo-", dir=out) as partial_folder,
    ):
        folder = Path(partial_folder)
        play = partial(_played, seed=seed, frames=frames, folder=folder)
        try:
            for number, played in _in_processes(play):
                plays[number] = played
                Console(stderr=True).print(f"{STORIES[number].title}.", highlight=False)
        except KeyboardInterrupt as interrupt:
            log(f"{interrupts.word(interrupt)}{len(plays)} films; nothing is kept of a part.")
            return interrupts.code(interrupt)
        in_order = [plays[number] for number in range(len(STORIES))]
        try:
            (folder / PAGE).write_text(_page(in_order), encoding="utf-8")
            for path in sorted(folder.iterdir()):
                path.replace(out / path.name)
        except OSError as error:
            raise FormatError(f"{out} cannot be written: {error.strerror}; make room.") from None
    console.print(_table(in_order))
    for words in (
        f"Open {out / PAGE}: the films, what was followed and counted, and the next steps.",
        "Next: motes track your_video.mp4 --init x,y,w,h --overlay out.mp4",
    ):
        console.print(words, markup=False, highlight=False, soft_wrap=True)
    return DONE


@dataclass
class TrackerRun:
    """A tracker with its results so far."""

    name: str
    """Of the tracker."""
    start: Callable[[Frame, Box], object]
    follow: Callable[[Frame], tuple[bool, Sequence[float]]]
    """Start it on a box of a frame; return whether it is sure of the next frame, and its box there:
    none if it stays where it was."""
    patience: float = PATIENCE
    """Frames in turn off the target after which it is stopped, and has no box."""
    box: Sequence[float] = ()
    sure: bool = True
    off: int = 0
    overlaps: list[float] = field(default_factory=list)
    tracking: list[bool] = field(default_factory=list)
    seconds: list[float] = field(default_factory=list)

    def step(self, frame: Frame, truth: Truth) -> None:
        """Track the target in a frame; the first starts it on the true box, in whole pixels."""
        begun = time.process_time()  # other films are made meanwhile
        if not self.seconds:
            self.box = Box(*(round(value) for value in truth.ellipse.box))
            self.start(frame, self.box)
        elif self.off >= self.patience:
            self.box = ()
        else:
            self.sure, box = self.follow(frame)
            self.box = box or self.box
        if self.box:
            self.seconds.append(time.process_time() - begun)
        self.overlaps.append(float(iou(self.box, truth.ellipse.box)) if self.box else 0.0)
        self.off = self.off + 1 if self.overlaps[-1] < HIT else 0
        self.tracking.append(self.sure)

    def said(self, visible: ArrayLike) -> tuple[str, str, str]:
        """Return the values of `WORDS`: the score, and the median processor time of an update."""
        half, missed, admitted = score(self.overlaps, visible, self.tracking)
        time = 1000 * float(np.median(self.seconds))
        return f"{half:.0%}", f"{admitted} of {missed}", f"{time:.1f} ms"


class Score(NamedTuple):
    """The quality of a run."""

    half: float
    """Share of the frames with an IoU above 0.5, of those in which half of the target is
    visible."""
    missed: int
    admitted: int
    """Number of frames with an IoU below `HIT`, and of those in which the tracker was not sure."""


WORDS = "frames with IoU > 0.5", "off the target, and says so", "time"
"""The rows of the table: how well a tracker followed the target of a film, and how fast."""


class Played(NamedTuple):
    """What a film of the demo gave."""

    said: Mapping[str, Sequence[str]]
    """Of each tracker, by name: the values of `WORDS`."""
    states: Sequence[tuple[str, float]]
    """Status and confidence of the default tracker in each frame."""
    counted: int | None
    crossings: int | None
    """How many objects were counted, and how many crossed the line; None without a line."""


def score(overlaps: ArrayLike, visible: ArrayLike, tracking: ArrayLike) -> Score:
    """Score a run from each frame's IoU, visible fraction and whether the tracker was sure.

    All have shape (frames,); half of the target must be visible in some frame.
    """
    overlap, seen = np.asarray(overlaps), np.asarray(visible) >= 0.5
    missed = overlap < HIT
    return Score(
        half=float((overlap[seen] > 0.5).mean()),
        missed=int(missed.sum()),
        admitted=int((missed & ~np.asarray(tracking)).sum()),
    )


def _in_processes(play: Callable[[int], Played]) -> Iterator[tuple[int, Played]]:
    """Make each film in a process of its own; yield its number and what it gave, as they end.

    Raises
    ------
    FormatError
        If a film is not made.
    """
    workers: dict[Connection, tuple[int, Worker]] = {}
    try:
        for number in range(len(STORIES)):
            with environment(thread_limits()):
                worker = Worker(do_tasks)
            workers[worker.pipe] = number, worker
            worker.give(partial(_packed, play=play, number=number))
        running = [*workers]
        while running:
            ready = wait(running)
            for pipe in [each for each in running if each in ready]:
                number, worker = workers[pipe]
                answer: Answer | None = receive(pipe, Answer)
                if isinstance(answer, Done):
                    running.remove(pipe)
                    yield number, pickle.loads(answer.data)
                elif answer is None or isinstance(answer, Failed):
                    why = answer.error if answer else f"Its process ended with {worker.cause()}."
                    raise FormatError(f"The film {STORIES[number].name} is not made. {why}")
    finally:
        with blocked_signals():
            for _, worker in workers.values():
                worker.end()


def _packed(_: object, play: Callable[[int], Played], number: int) -> bytes:
    """Make a film in a worker."""
    return pickle.dumps(play(number))


def _played(number: int, *, seed: int, frames: int | None, folder: Path) -> Played:
    """Render a film into a folder, follow its target and count; return what came of it."""
    from motes import Tracker, TrackWriter, open_source
    from motes.video.writer import VideoWriter

    story = STORIES[number]
    path = folder / f"{story.name}.mp4"
    shown = []
    with VideoWriter(path, 1 / FRAME_INTERVAL) as film:
        for frame, objects in islice(story.film(seed), frames):
            film.write(frame.pixels)
            shown.append(objects)
    truths = [objects[0] for objects in shown]
    rows = [
        f"{n},{n * FRAME_INTERVAL:.6f},"
        + ",".join(f"{value:.5f}" for value in (*truth.ellipse, truth.visible))
        for n, truth in enumerate(truths)
    ]
    (folder / f"{story.name}-truth.csv").write_text("\n".join([TRUTH_COLUMNS, *rows, ""]))
    tracker = Tracker(seed=seed)
    runs = [replace(_motes("motes", tracker), patience=math.inf), *_rivals(story.peers)]
    states = []
    with (
        open_source(path) as source,
        TrackWriter(folder / f"{story.name}.csv") as writer,
        VideoWriter(folder / f"{story.name}-tracked.mp4", 1 / FRAME_INTERVAL) as view,
    ):
        for frame, truth in zip(source, truths, strict=True):
            for run in runs:
                run.step(frame, truth)
            track = tracker.info.track
            writer.write(frame.index, frame.time, track)
            states.append((str(track.status), round(track.confidence, 2)))
            view.write(_drawn(frame, tracker, runs[1:]))
    visible = [truth.visible for truth in truths]
    return Played(
        said={run.name: run.said(visible) for run in runs},
        states=states,
        counted=None if story.line is None else _counted(story.name, story.line, folder),
        crossings=None if story.line is None else _crossings(story.line, shown[0], shown[-1]),
    )


def _motes(name: str, tracker: Tracker) -> TrackerRun:
    """Return a run of a tracker of motes."""

    def follow(frame: Frame) -> tuple[bool, Sequence[float]]:
        track = tracker.update(frame)
        return track.status is Status.TRACKING, track.box

    return TrackerRun(name, tracker.init, follow)


def _rivals(peers: Sequence[str]) -> list[TrackerRun]:
    """Return trackers of OpenCV, or mean shift where OpenCV does not have them."""
    from motes import Tracker

    try:
        opencv: Any = importlib.import_module("cv2")
    except ImportError:
        opencv = None
    makers = {name: getattr(opencv, f"Tracker{name}_create", None) for name in peers}
    runs = [_opencv(opencv, name, make()) for name, make in makers.items() if make is not None]
    return runs or [_motes("mean shift", Tracker("mean_shift"))]


def _opencv(opencv: Any, name: str, tracker: Any) -> TrackerRun:
    """Return a run of a tracker of OpenCV. It stays where it was when it says that it is lost."""

    def bgr(frame: Frame) -> Bytes:
        pixels: Bytes = opencv.cvtColor(frame.pixels, opencv.COLOR_RGB2BGR)
        return pixels

    def follow(frame: Frame) -> tuple[bool, Sequence[float]]:
        sure, box = tracker.update(bgr(frame))
        return sure, box if sure else ()

    return TrackerRun(name, lambda frame, box: tracker.init(bgr(frame), tuple(box)), follow)


def _drawn(frame: Frame, tracker: Tracker, rivals: Sequence[TrackerRun]) -> Bytes:
    """Return a frame with the boxes of the others, and the default tracker's particles."""
    from PIL import Image, ImageDraw

    info = tracker.info
    image = Image.fromarray(frame.pixels)
    pen, letters = ImageDraw.Draw(image), font(11)
    for n, run in enumerate(rivals):
        if not run.box:
            continue
        x, y, width, height = run.box
        color = RIVALS[run.name]
        pen.rectangle((x, y, x + width, y + height), outline=color)
        place = (8 + 60 * n, frame.height - 18)
        pen.text(place, run.name, color, letters, stroke_width=2, stroke_fill="black")
    dots = {"particles": info.ellipses, "weights": info.weights}
    return draw(np.asarray(image), info.track, label="", **dots)


def _counted(name: str, line: int, folder: Path) -> int:
    """Return how many objects `motes watch` counts at an upright line."""
    from motes.cli.app import app

    events = folder / f"{name}-events.jsonl"
    with contextlib.redirect_stderr(io.StringIO()):
        app([
            "watch", str(folder / f"{name}.mp4"), "--line", f"{line},{ROAD[0]},{line},{ROAD[1]}",
            "-o", str(folder / f"{name}-objects.csv"), "--events", str(events),
            "--overlay", str(folder / f"{name}-counted.mp4"),
        ])  # fmt: skip
    return sum(json.loads(row)["event"] == "crosses" for row in events.read_text().splitlines())


def _crossings(line: int, first: Sequence[Truth], last: Sequence[Truth]) -> int:
    """Return how many objects are on the other side of an upright line at the end."""
    sides = [[truth.ellipse.x < line for truth in truths] for truths in (first, last)]
    return sum(before is not after for before, after in zip(*sides, strict=True))


def _table(plays: Sequence[Played]) -> Table:
    """Return the scores of all trackers in all films."""
    table = Table("", *(story.name for story in STORIES))
    for n, words in enumerate(WORDS):
        for name in plays[0].said:
            row = (played.said[name][n] if name in played.said else "" for played in plays)
            table.add_row(f"{name}: {words}", *row)
    counts = ["" if p.counted is None else f"{p.counted} of {p.crossings}" for p in plays]
    table.add_row("counted by motes watch", *counts)
    return table


def _page(plays: Sequence[Played]) -> str:
    """Return the page that shows the films."""
    text = resources.files("motes.cli").joinpath("demo.html").read_text(encoding="utf-8")
    head, film, count, end = map(Template, text.split("<!-- part -->\n"))
    parts = [head.substitute()]
    for story, played in zip(STORIES, plays, strict=True):
        told = story._asdict() | played._asdict()
        rows = ("<td>".join([f"<tr><th>{name}", *said]) for name, said in played.said.items())
        states = html.escape(json.dumps(played.states))
        counted = "" if played.counted is None else count.substitute(told)
        parts.append(film.substitute(told, states=states, rows="".join(rows), count=counted))
    return "".join([*parts, end.substitute(rate=1 / FRAME_INTERVAL)])
