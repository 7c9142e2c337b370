"""The largest memory of a job against the size of its frames: `motes_fleet.cluster.estimate`.

python benchmarks/cluster_memory.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from motes.core.resources import thread_limits
from motes.video.writer import VideoWriter
from motes_fleet.cluster.estimate import memory_of
from motes_fleet.cluster.jobs import Job
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

SIZES = ((320, 240), (1280, 720), (1920, 1080), (3840, 2160))
PRESETS = ("default", "nummiaro", "maggio", "ng_delp", "zhao_pei", "mean_shift")
FRAMES = 24
MEASURED = """\
import resource, sys
from motes.cli import main
code = main(sys.argv[1:])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, code)
"""


def film(path: Path, width: int, height: int) -> str:
    """Render a box that moves over noise; return the box in the first frame."""
    noise = np.random.default_rng(0).integers(0, 255, (height // 8, width // 8, 3), np.uint8)
    ground = noise.repeat(8, 0).repeat(8, 1)
    x, y, w, h = width // 4, height // 3, width // 10, height // 6
    with VideoWriter(path, 25) as writer:
        for frame in range(FRAMES):
            picture = ground.copy()
            picture[y : y + h, x + 4 * frame : x + 4 * frame + w] = 200, 30, 30
            writer.write(picture)
    return f"{x},{y},{w},{h}"


def measured(*arguments: str) -> int:
    """Return the largest resident memory of a command, in bytes."""
    done = subprocess.run(
        [sys.executable, "-c", MEASURED, *arguments],
        env=os.environ | thread_limits(1),
        capture_output=True,
        text=True,
    )
    return int(done.stdout.split()[-2]) << 10


def main() -> int:
    """Print a table with a row for each kind of job."""
    cells: dict[str, list[Cell]] = {}
    worst = 0.0
    with tempfile.TemporaryDirectory() as folder:
        for width, height in SIZES:
            path, rows = Path(folder) / f"{width}.mp4", str(Path(folder) / "rows.csv")
            box = film(path, width, height)
            region = tuple(map(float, box.split(",")))
            kinds: list[tuple[str, Job, tuple[str, ...]]] = [
                (
                    preset,
                    Job(source=str(path), init=(region,), preset=preset),
                    ("track", str(path), "--init", box, "--preset", preset),
                )
                for preset in PRESETS
            ]
            kinds += [
                (
                    "keyframes",
                    Job(source=str(path), keyframes="k"),
                    ("track", str(path), "--at", f"0={box}"),
                ),
                ("watch", Job(source=str(path), do="watch"), ("watch", str(path))),
            ]
            for name, job, arguments in kinds:
                found = measured(*arguments, "-o", rows, "--overwrite")
                expected = memory_of(job)
                worst = max(worst, found / expected)
                text = f"{found / 1e6:.0f} of {expected / 1e6:.0f}"
                cells.setdefault(name, []).append(Cell(text, found))
    lines: list[Row] = [(Cell(name), *each) for name, each in cells.items()]
    head = "job", *(f"{width}x{height}" for width, height in SIZES)
    note = f"The largest share of an estimate is {worst:.2f}."
    print(markdown.table(Table("Largest memory in MB, of the estimate", head, lines, note=note)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
