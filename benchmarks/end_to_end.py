"""What a frame costs from file to file: decoding, tracking, and writing the overlay.

    python benchmarks/end_to_end.py FILM X,Y,WIDTH,HEIGHT

The film is scaled to each size first, with the box of its target, and written as H.264 into a
temporary folder. Whole commands then run in turn, in every round: one that only decodes, `motes
track` with rows, and the same with an overlay. Each runs over few frames and over more; the
difference is divided by the frames between, so that starting is left out. Tracking is what rows
add to decoding, writing is what the overlay adds to that.

Milliseconds are of the processor, all threads and processes together: load of the machine adds
little to them. Frames a second are by the clock. Each run counts with its least of the rounds.
"""

from __future__ import annotations

import argparse
import itertools
import math
import os
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import av

from motes.core.frame import as_rgb
from motes.video.writer import VideoWriter
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number, percent

SIZES = ["854x480", "1920x1080", "3840x2160"]
PRESETS = ["nummiaro", "default"]
FEW = 10
"""Frames of the short runs."""
DECODE = """
import sys
from motes import open_source
with open_source(sys.argv[1], end=int(sys.argv[2])) as film:
    for frame in film:
        pass
"""


class Cost(NamedTuple):
    """Seconds of the processor, and by the clock."""

    processor: float
    clock: float


def scaled(film: str, path: Path, width: int, height: int, frames: int) -> tuple[float, float]:
    """Write the first frames of a film in another size; return the factors of x and y."""
    with av.open(film) as source, VideoWriter(path, 25) as writer:
        for frame in itertools.islice(source.decode(video=0), frames):
            factors = width / frame.width, height / frame.height
            picture = frame.reformat(width, height, format="rgb24", interpolation="BICUBIC")
            writer.write(as_rgb(picture.to_ndarray()))
    return factors


def cost(command: list[str]) -> Cost:
    """Run a command of Python and return its cost; end with what it prints if it fails."""
    start = time.perf_counter()
    with subprocess.Popen([sys.executable, *command], stderr=subprocess.PIPE) as process:
        assert process.stderr is not None
        said = process.stderr.read().decode()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    clock = time.perf_counter() - start
    if process.returncode:
        sys.exit(f"{' '.join(command)} failed: {said}")
    return Cost(usage.ru_utime + usage.ru_stime, clock)


def a_frame(costs: list[tuple[Cost, Cost]], frames: int) -> Cost:
    """Return the cost of a frame from the least of short and long runs, as load only adds.

    It is NaN if it is lost in noise.
    """
    less, more = (map(min, zip(*each, strict=True)) for each in zip(*costs, strict=True))
    each = ((long - short) / (frames - FEW) for short, long in zip(less, more, strict=True))
    return Cost(*(value if value > 0 else math.nan for value in each))


def commands(path: Path, box: str, presets: list[str]) -> dict[str, list[str]]:
    """Return the commands by what they do; the last word, a number of frames, is missing."""
    named = {"decode": ["-c", DECODE, str(path)]}
    for preset in presets:
        rows, film = (str(path.with_name(f"{preset}.{ending}")) for ending in ("csv", "mp4"))
        track = ["-m", "motes", "track", str(path), "--init", box, "--preset", preset]
        track += ["-o", rows, "--overwrite"]
        named[f"{preset} track"] = [*track, "--end"]
        named[f"{preset} write"] = [*track, "--overlay", film, "--end"]
    return named


def rows(size: str, presets: list[str], costs: dict[str, Cost]) -> list[Row]:
    """Return the lines of a size."""
    decode = costs["decode"]
    lines: list[Row] = []
    for preset in presets:
        track, write = costs[f"{preset} track"], costs[f"{preset} write"]
        parts = (decode.processor, track.processor - decode.processor,
                 write.processor - track.processor)  # fmt: skip
        lines.append(
            (
                Cell(size),
                Cell(preset),
                *(number(1e3 * part, 2) for part in parts),
                percent(decode.processor / track.processor),
                percent(decode.processor / write.processor),
                *(number(1 / each.clock, 0) for each in (decode, track, write)),
            )
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("film")
    parser.add_argument("box", help="x,y,width,height of the target in the first frame")
    parser.add_argument("--frames", type=int, default=240)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--size", action="append", help="WIDTHxHEIGHT; may be repeated")
    parser.add_argument("--preset", action="append", help="may be repeated")
    given = parser.parse_args()
    if given.frames <= FEW:
        parser.error(f"--frames is {given.frames}; give more than {FEW}.")
    presets, lines = given.preset or PRESETS, []
    for size in given.size or SIZES:
        width, height = map(int, size.split("x"))
        with TemporaryDirectory(prefix="motes-") as folder:
            path = Path(folder, "film.mp4")
            x, y = scaled(given.film, path, width, height, given.frames)
            box = [float(each) for each in given.box.split(",")]
            text = ",".join(f"{each * by:.1f}" for each, by in zip(box, (x, y, x, y), strict=True))
            works = commands(path, text, presets)
            costs: dict[str, list[tuple[Cost, Cost]]] = {what: [] for what in works}
            for _, (what, command) in itertools.product(range(given.rounds), works.items()):
                both = (cost([*command, str(n)]) for n in (FEW, given.frames))
                costs[what].append((next(both), next(both)))
                print(size, what, *costs[what][-1], file=sys.stderr)
        each = {what: a_frame(found, given.frames) for what, found in costs.items()}
        lines += rows(size, presets, each)
    head = (
        *("size", "preset", "decode, ms", "track, ms", "write, ms", "decoding of decode and track"),
        *("of all three", "decoded a second", "tracked", "written"),
    )
    print(markdown.table(Table("A frame from file to file", head, lines)))


if __name__ == "__main__":
    main()
