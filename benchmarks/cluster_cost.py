"""Processor time of a frame in a worker of one core: what `lab/docs/scale.md` reckons with.

    python benchmarks/cluster_cost.py FILM X,Y,WIDTH,HEIGHT
    python benchmarks/cluster_cost.py                          a rendered film of 640x480

Processor time is steady on a busy machine; the clock is not. The time of a film of one frame is
taken off: that of starting Python.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from motes import synthetic
from motes.core.worker import thread_limits
from motes.video.sources import open_source
from motes.video.writer import VideoWriter
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

FPS = 25
"""Frames a second of the film whose cost is printed."""


def used(*arguments: str) -> float:
    """Return the processor seconds of a command."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    line = [sys.executable, "-m", "motes", *arguments]
    done = subprocess.run(line, capture_output=True, env=os.environ | thread_limits(1))
    if done.returncode not in (0, 4):  # 4: nothing was found, as in a film of one frame
        raise SystemExit(done.stderr.decode())
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> int:
    """Print a table with a row for each command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("film", nargs="?")
    parser.add_argument("box", nargs="?", default="240,180,60,100")
    parser.add_argument("--frames", type=int, default=300)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        film = options.film
        if film is None:
            film = str(Path(folder) / "film.mp4")
            with VideoWriter(Path(film), FPS) as writer:
                for frame, _ in synthetic.crossing((640, 480), options.frames):
                    writer.write(frame.pixels)
        with open_source(film, end=options.frames) as source:
            size, frames = f"{source.width}x{source.height}", sum(1 for _ in source)
        end = ["-o", str(Path(folder) / "rows.csv"), "--overwrite", "--end"]
        rows: list[Row] = []
        for words in (
            ["track", film, "--init", options.box],
            ["track", film, "--init", options.box, "--preset", "nummiaro"],
            ["watch", film],
        ):
            rest = used(*words, *end, str(frames)) - used(*words, *end, "1")
            each = rest / (frames - 1)
            shown = " ".join([words[0], *words[4:]])
            cells = number(1000 * each, 1), number(FPS * each, 2)
            rows.append((Cell(shown), Cell(size), *cells))
    head = "command", "film", "ms of a core for a frame", "core hours for an hour of film"
    print(markdown.table(Table("What a frame costs a worker", head, rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
