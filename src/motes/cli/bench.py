"""`motes bench`: how fast trackers are on this machine, side by side in one run."""

from __future__ import annotations

import copy
import statistics
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rich.console import Console
from rich.table import Table

from motes.cli.follow import follow, on_region, prefetch
from motes.errors import ConfigError, LimitError
from motes.evaluate.peers import PEERS, peer
from motes.frame import Frame
from motes.geometry import Ellipse
from motes.synthetic import still
from motes.tracker import Tracker
from motes.video import open_source
from motes.writer import VideoWriter

SIZE = (640, 480)
MAIN, SMALLER = (120, 200), (60, 100)
"""The targets, width and height, on which trackers are compared: all, and CSRT."""
TARGETS = ((28, 44), SMALLER, MAIN)


FILE_FRAMES, FILE_ROUNDS = 1000, 3


def clip(target: tuple[int, int], frames: int) -> tuple[list[Frame], Ellipse]:
    """Return the frames of a rendered clip and the target's first region."""
    rendered = list(still(SIZE, target=target, frames=frames))
    return [frame for frame, _ in rendered], rendered[0][1][0].ellipse


def timed_updates(update: Callable[[Any], object], images: Sequence[Any]) -> list[float]:
    """Return the seconds of each update, on images just written, as a decoder leaves them."""
    seconds = []
    for image in map(copy.deepcopy, images):
        start = time.perf_counter()
        update(image)
        seconds.append(time.perf_counter() - start)
    return seconds


def started(preset: str, frames: list[Frame], region: Ellipse) -> Tracker:
    """Return one of our trackers after its first frame."""
    tracker = Tracker(preset)
    tracker.init(frames[0], region)
    return tracker


def ours(tracker: Tracker, frames: list[Frame]) -> list[float]:
    """Return the seconds of each update over a clip, from a copy of a started tracker."""
    return timed_updates(copy.copy(tracker).update, frames[1:])


def theirs(name: str, frames: list[Frame], region: Ellipse) -> list[float]:
    """Return the seconds of each update of a peer over a clip; conversion to BGR is not timed."""
    tracker = peer(name)
    images = [frame.pixels[:, :, ::-1].copy() for frame in frames]
    tracker.init(images[0], [round(value) for value in region.box])
    return timed_updates(tracker.update, images[1:])


def bench(*, frames: int = 31, rounds: int = 3) -> int:
    """Measure trackers side by side on rendered clips of 640x480 and print ratios.

    Each round runs every tracker over the same frames on one core; times are medians over all
    updates of all rounds, inside the tracker only.

    Parameters
    ----------
    frames
        Length of each clip.
    rounds
        How often everything is run.
    """
    if frames < 3 or rounds < 1:
        raise ConfigError("Medians need --frames of 3 or more and --rounds of 1 or more.")
    console = Console()
    clips = {target: clip(target, frames) for target in TARGETS}
    jobs: dict[tuple[str, tuple[int, int]], Callable[[], list[float]]] = {}
    for preset in ("nummiaro", "maggio"):
        for target in TARGETS:
            jobs[preset, target] = partial(ours, started(preset, *clips[target]), clips[target][0])
    for preset in ("nummiaro:adaptive", "mean_shift"):
        jobs[preset, MAIN] = partial(ours, started(preset, *clips[MAIN]), clips[MAIN][0])
    missing = ""
    try:
        peer("cv2:csrt")
        for name, target in [("cv2:csrt", SMALLER), *((name, MAIN) for name in PEERS)]:
            jobs[name, target] = partial(theirs, name, *clips[target])
    except LimitError as error:
        missing = str(error)
    seconds: dict[tuple[str, tuple[int, int]], list[float]] = {job: [] for job in jobs}
    with console.status("measuring"):
        for _ in range(rounds):
            for job, run in jobs.items():
                seconds[job] += run()
    print_trackers(console, seconds)
    if missing:
        console.print(missing)
    print_file(console)
    return 0


def print_trackers(
    console: Console, seconds: dict[tuple[str, tuple[int, int]], list[float]]
) -> None:
    """Print the time of an update of each tracker, and its ratio to `nummiaro` on MAIN."""
    reference = statistics.median(seconds["nummiaro", MAIN])
    table = Table(title=f"one update, {SIZE[0]}x{SIZE[1]}, one core")
    for column in ("tracker", "target", "median ms", "95 % ms", "times nummiaro"):
        table.add_column(column, justify="left" if column == "tracker" else "right")
    for (name, target), times in seconds.items():
        median = statistics.median(times)
        high = statistics.quantiles(times, n=20)[-1]
        table.add_row(
            name,
            f"{target[0]}x{target[1]}",
            f"{median * 1e3:.3f}",
            f"{high * 1e3:.3f}",
            f"{median / reference:.2f}",
        )
    console.print(table)


def print_file(console: Console) -> None:
    """Print how fast a file is followed, against how fast it is decoded."""
    rendered = still(SIZE, target=MAIN, frames=FILE_FRAMES)
    region = rendered[0][1][0].ellipse
    decoding, following = [], []
    with TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        with VideoWriter(path, 25) as writer:
            for frame, _ in rendered:
                writer.write(frame.pixels)
        for _ in range(FILE_ROUNDS):
            start = time.perf_counter()
            with open_source(path) as source:
                for _ in source:
                    pass
            decoding.append(len(rendered) / (time.perf_counter() - start))
            start = time.perf_counter()
            with open_source(path) as source, prefetch(source) as frames:
                for _ in follow(Tracker("nummiaro"), on_region(region), frames):
                    pass
            following.append(len(rendered) / (time.perf_counter() - start))
    decode, track = statistics.median(decoding), statistics.median(following)
    console.print(
        f"H.264 file of {SIZE[0]}x{SIZE[1]}, {FILE_FRAMES} frames: decoded at {decode:.0f}/s, "
        f"followed whole at {track:.0f}: {track / decode:.0%}."
    )
