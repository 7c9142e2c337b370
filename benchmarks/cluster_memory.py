"""The largest memory of a job against the size of its frames.

python benchmarks/cluster_memory.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from motes.core.worker import thread_limits
from motes.video.writer import VideoWriter
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

SIZES = ((320, 240), (1280, 720), (1920, 1080), (3840, 2160))
PRESETS = ("default", "nummiaro", "maggio", "ng_delp", "zhao_pei", "mean_shift")
FRAMES = 24
MEASURED = """\
import sys
from pathlib import Path
from motes.cli import main
code = main(sys.argv[1:])
print(Path("/proc/self/status").read_text().partition("VmHWM:")[2].split()[0], code)
"""
"""A job that prints its peak. That of `resource` is at least the memory of who starts the job."""


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
    with tempfile.TemporaryDirectory() as folder:
        for width, height in SIZES:
            path, rows = Path(folder) / f"{width}.mp4", str(Path(folder) / "rows.csv")
            box = film(path, width, height)
            kinds: dict[str, tuple[str, ...]]
            kinds = {name: ("track", "--init", box, "--preset", name) for name in PRESETS}
            kinds |= {"keyframes": ("track", "--at", f"0={box}"), "watch": ("watch",)}
            for name, (command, *options) in kinds.items():
                found = measured(command, str(path), *options, "-o", rows, "--overwrite") / 1e6
                cells.setdefault(name, []).append(number(found, 0))
    lines: list[Row] = [(Cell(name), *each) for name, each in cells.items()]
    head = "job", *(f"{width}x{height}" for width, height in SIZES)
    print(markdown.table(Table("Largest memory in MB", head, lines)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
