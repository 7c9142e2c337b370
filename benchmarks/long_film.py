"""The memory and the time of tracking in an hour of 1080p, in each direction.

    python benchmarks/long_film.py [FOLDER] [--frames 90000] [--part 15000] [--preset NAME]
                                   [--only forward,from,keyframes,backward]

The film is that of benchmarks/studio.py: 1920x1080, 25 frames a second, a key picture every 250
frames; it repeats 600 encoded pictures. It is made in the folder (by default one for temporary
files) unless it is there. `forward` tracks all of it from the start. The others take a part: `from`
starts in the middle and tracks both ways, `keyframes` has a keyframe every 1500 frames and a range
of absence, `backward` goes back from the end.

Memory is the resident memory of the command and all its children, which counts twice what they
share. It is read every half second; the columns are its mean in each quarter of the run, and its
peak. All rows must be there, in order, with the target where it is drawn.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import math
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number
from studio import SIZE, region, render

PERIOD = 0.5
GAP = 1500
ABSENT = range(700, 721)
"""Frames that are marked as absent in the run with keyframes, counted from its first frame."""


def processes(pid: int) -> list[int]:
    """Return a process and all below it."""
    found = [pid]
    for task in Path(f"/proc/{pid}/task").glob("*"):
        try:
            children = (task / "children").read_text().split()
        except OSError:
            continue
        found += [each for child in children for each in processes(int(child))]
    return found


def resident(pid: int) -> float:
    """Return the resident megabytes of a process and all below it."""
    total = 0
    for each in processes(pid):
        try:
            lines = Path(f"/proc/{each}/status").read_text().splitlines()
        except OSError:
            continue
        total += sum(int(line.split()[1]) for line in lines if line.startswith("VmRSS:"))
    return total / 1024


def run(words: list[str]) -> tuple[float, list[float]]:
    """Run motes; return its seconds, and its memory at each reading."""
    clock, memory = time.perf_counter(), list[float]()
    with subprocess.Popen([sys.executable, "-m", "motes", *words]) as running:
        while running.poll() is None:
            memory.append(resident(running.pid))
            time.sleep(PERIOD)
    assert running.returncode == 0, running.returncode
    return time.perf_counter() - clock, memory


def wrong(rows: Path, frames: range, absent: range) -> tuple[int, float]:
    """Check that rows are complete; return how many have no target, and the largest error."""
    with rows.open() as file:
        table = list(csv.DictReader(file))
    assert [int(row["frame"]) for row in table] == [*frames], f"{rows} has {len(table)} rows"
    errors = []
    for row in table:
        if int(row["frame"]) in absent:
            assert row["status"] == "absent"
        elif row["status"] == "tracking":
            x, y, width, height = region(int(row["frame"]), SIZE)
            center = x + (width - 1) / 2, y + (height - 1) / 2
            errors.append(math.dist(center, (float(row["x"]), float(row["y"]))))
    return len(table) - len(errors) - len(absent), max(errors)


def box(frame: int) -> str:
    """Return the target of a frame as text."""
    return ",".join(f"{value:g}" for value in region(frame, SIZE))


def keyframes(path: Path, frames: range) -> None:
    """Write a keyframe every `GAP` frames, and some in which the target is absent."""
    lines = [f"{frame},{box(frame)}" for frame in [*frames[::GAP], frames[-1]]]
    lines.append(f"{frames.start + ABSENT.start}:{frames.start + ABSENT.stop - 1},absent")
    path.write_text("\n".join(lines) + "\n")


def main() -> None:
    """Print a table with a row for each run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--frames", type=int, default=90_000)
    parser.add_argument("--part", type=int, default=15_000, help="frames of a part")
    parser.add_argument("--preset", default="nummiaro")
    parser.add_argument("--only", default="forward,from,keyframes,backward")
    options = parser.parse_args()
    total, part = options.frames, options.part
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.folder or Path(temporary)
        film = folder / f"film-{total}.mp4"
        if not film.exists():
            render(film, total, SIZE)
        middle = total // 2
        around = range(middle - part // 2, middle + part // 2)
        absent = range(around.start + ABSENT.start, around.start + ABSENT.stop)
        marks = folder / "marks.csv"
        keyframes(marks, around)
        inside = ["--start", str(around.start), "--end", str(around.stop)]
        runs = {
            "forward": (range(total), ["--init", box(0)], range(0)),
            "from": (around, ["--at", f"{middle}={box(middle)}", *inside], range(0)),
            "keyframes": (around, ["--keyframes", str(marks), *inside], absent),
            "backward": (
                range(total - part, total),
                ["--at", f"{total - 1}={box(total - 1)}", "--start", str(total - part)],
                range(0),
            ),
        }
        lines, errors = list[Row](), list[float]()
        for name in options.only.split(","):
            frames, words, gone = runs[name]
            rows = folder / f"rows-{name}.csv"
            command = ["track", str(film), *words, "--preset", options.preset, "-o", str(rows)]
            seconds, memory = run([*command, "--overwrite"])
            lost, error = wrong(rows, frames, gone)
            cut = [len(memory) * i // 4 for i in range(5)]
            means = [statistics.mean(memory[a:b]) for a, b in itertools.pairwise(cut)]
            megabytes = (number(each, 0) for each in (*means, max(memory)))
            lines.append(
                (Cell(name), Cell(f"{len(frames):,}"), number(seconds / 60, 1), *megabytes)
            )
            errors.append(error)
            print(f"{name}: {lost} frames without the target", file=sys.stderr)
        head = (*("run", "frames", "minutes", "MB in the 1st quarter", "2nd", "3rd", "4th"), "peak")
        note = f"The center is never more than {max(errors):.0f} pixels off."
        print(markdown.table(Table("Memory over an hour of film", head, lines, note=note)))


if __name__ == "__main__":
    main()
