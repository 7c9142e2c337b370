"""`motes demo`: films of three kinds, followed, counted, and shown on one page.

What only the playing of films needs is imported late, so that its processes begin sooner.
"""

from __future__ import annotations

import contextlib
import html
import io
import json
import pickle
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from importlib import resources
from itertools import islice
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Annotated, NamedTuple

from cyclopts import Parameter

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_counts, prepared_folder
from motes.cli.option_groups import OUTPUT, RUN, Overwrite, Whole
from motes.cli.streams import log
from motes.core import interrupts
from motes.core.errors import ConfigError, FormatError
from motes.core.frame import FRAME_INTERVAL, Frame
from motes.core.geometry import Ellipse, iou
from motes.core.platforms import blocked_signals
from motes.core.worker import Alive, Done, Worker, environment, thread_limits

if TYPE_CHECKING:
    from motes.synthetic.clips import Truth

ROAD = 130, 235
"""The rows between which the line of counting goes."""


class Story(NamedTuple):
    """A film of the demo, whose first object is followed."""

    name: str
    """The first part of the names of its files."""
    title: str
    """What happens."""
    line: int | None = None
    """x of an upright line at which objects are counted; None for none."""


STORIES = (
    Story("beetle", "An animal hides behind a stem, turns, grows, leaps and leaves"),
    Story("street", "A car passes behind a lorry, and cars are counted", 150),
    Story("player", "A player runs among others who look alike, before a moving camera"),
)


def films() -> dict[str, Callable[..., Iterable[tuple[Frame, tuple[Truth, ...]]]]]:
    """Return what renders each film, given a seed, by its name."""
    from motes import synthetic

    street, player = synthetic.Street, synthetic.Pitch
    return {"beetle": partial(synthetic.demo, (480, 360)), "street": street, "player": player}


PAGE = "index.html"
TRACKED = ".mp4", "-tracked.mp4", ".csv", ".csv.run.json"
COUNTED = "-counted.mp4", "-objects.csv", "-objects.csv.run.json", "-events.jsonl"
"""The ends of the names of a film's files, and of one with a line."""
FILES = (
    PAGE,
    *(story.name + end for story in STORIES for end in TRACKED),
    *(story.name + end for story in STORIES if story.line is not None for end in COUNTED),
)


def demo(
    *,
    frames: Annotated[Whole | None, Parameter(group=RUN)] = None,
    seed: Annotated[Whole, Parameter(group=RUN)] = 0,
    out: Annotated[Path, Parameter(group=OUTPUT)] = Path("demo"),
    overwrite: Overwrite = False,
) -> int:
    """Render three films, follow what is in them, and show all on a page.

    The films are an animal that hides and grows, a street whose cars are counted, and a player
    among others who look alike. Open index.html in the folder.

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
    plays: list[Played] = []
    # A film's files appear together, when all are done.
    with (
        prepared_folder(out, FILES, overwrite),
        tempfile.TemporaryDirectory(prefix=".demo-", dir=out) as partial_folder,
    ):
        folder = Path(partial_folder)
        play = partial(_played, seed=seed, frames=frames, folder=folder)
        try:
            for story, played in zip(STORIES, _in_processes(play), strict=True):
                plays.append(played)
                log(f"{story.title}.")
        except KeyboardInterrupt as interrupt:
            log(f"{interrupts.word(interrupt)}{len(plays)} films; nothing is kept of a part.")
            return interrupts.code(interrupt)
        try:
            (folder / PAGE).write_text(_page(plays), encoding="utf-8")
            for path in sorted(folder.iterdir()):
                path.replace(out / path.name)
        except OSError as error:
            raise FormatError(f"{out} cannot be written: {error.strerror}; make room.") from None
    print(f"Open {out / PAGE}: the films, what was followed and counted, and the next steps.")
    print("Next: motes track your_video.mp4 --init x,y,w,h --overlay out.mp4")
    return DONE


class Played(NamedTuple):
    """What a film of the demo gave."""

    hits: str
    """The share of the frames with an IoU above 0.5, of those in which half of it is visible."""
    states: Sequence[tuple[str, float]]
    """Status and confidence of the tracker in each frame."""
    counted: int | None
    crossings: int | None
    """How many objects were counted, and how many crossed the line; None without a line."""


def _in_processes(play: Callable[[Story], Played]) -> Iterator[Played]:
    """Make each film in a process of its own; yield what they gave, in their order.

    Raises a FormatError if a film is not made.
    """
    workers: list[Worker] = []
    try:
        for story in STORIES:
            with environment(thread_limits()):
                workers.append(Worker())
            workers[-1].give(partial(_packed, play, story))
        for story, worker in zip(STORIES, workers, strict=True):
            while isinstance(answer := worker.receive(), Alive):
                pass
            if not isinstance(answer, Done):
                why = answer.error if answer else f"Its process ended with {worker.cause()}."
                raise FormatError(f"The film {story.name} is not made. {why}")
            yield pickle.loads(answer.data)
    finally:
        with blocked_signals():
            for worker in workers:
                worker.end()


def _packed(play: Callable[[Story], Played], story: Story, _: object) -> bytes:
    """Make a film in a worker."""
    return pickle.dumps(play(story))


def _played(story: Story, *, seed: int, frames: int | None, folder: Path) -> Played:
    """Render a film into a folder, follow its target and count; return what came of it."""
    from motes import read_track
    from motes.video.writer import VideoWriter

    film, rows = folder / f"{story.name}.mp4", folder / f"{story.name}.csv"
    shown = []
    with VideoWriter(film, 1 / FRAME_INTERVAL) as writer:
        for frame, objects in islice(films()[story.name](seed=seed), frames):
            writer.write(frame.pixels)
            shown.append(objects)
    truths = [objects[0] for objects in shown]
    marked = ",".join(f"{value:.2f}" for value in truths[0].ellipse)
    overlay = folder / f"{story.name}-tracked.mp4"
    _run("track", film, "--init", marked, "--seed", seed, "-o", rows, "--overlay", overlay)
    found = read_track(rows)
    boxes = [Ellipse(*row).box for row in found[["x", "y", "a", "b", "theta"]].tolist()]
    hits = [
        iou(box, truth.ellipse.box) > 0.5
        for box, truth in zip(boxes, truths, strict=True)
        if truth.visible >= 0.5
    ]
    return Played(
        hits=f"{sum(hits) / len(hits):.0%}",
        states=[*zip(found["status"].tolist(), found["confidence"].round(2).tolist(), strict=True)],
        counted=None if story.line is None else _counted(story.name, story.line, folder),
        crossings=None if story.line is None else _crossings(story.line, shown[0], shown[-1]),
    )


def _run(*words: object) -> None:
    """Run a command of motes, as a user would type it."""
    from motes.cli.app import app

    with contextlib.redirect_stderr(io.StringIO()):
        app([*map(str, words)])


def _counted(name: str, line: int, folder: Path) -> int:
    """Return how many objects `motes watch` counts at an upright line."""
    events = folder / f"{name}-events.jsonl"
    _run(
        "watch", folder / f"{name}.mp4", "--line", f"{line},{ROAD[0]},{line},{ROAD[1]}",
        "-o", folder / f"{name}-objects.csv", "--events", events,
        "--overlay", folder / f"{name}-counted.mp4",
    )  # fmt: skip
    return sum(json.loads(row)["event"] == "crosses" for row in events.read_text().splitlines())


def _crossings(line: int, first: Sequence[Truth], last: Sequence[Truth]) -> int:
    """Return how many objects are on the other side of an upright line at the end."""
    sides = [[truth.ellipse.x < line for truth in truths] for truths in (first, last)]
    return sum(before is not after for before, after in zip(*sides, strict=True))


def _page(plays: Sequence[Played]) -> str:
    """Return the page that shows the films."""
    text = resources.files("motes.cli").joinpath("demo.html").read_text(encoding="utf-8")
    head, film, count, end = map(Template, text.split("<!-- part -->\n"))
    parts = [head.substitute()]
    for story, played in zip(STORIES, plays, strict=True):
        told = story._asdict() | played._asdict()
        states = html.escape(json.dumps(played.states))
        counted = "" if played.counted is None else count.substitute(told)
        parts.append(film.substitute(told, states=states, count=counted))
    return "".join([*parts, end.substitute(rate=1 / FRAME_INTERVAL)])
