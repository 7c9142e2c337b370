"""Kill motes with SIGKILL at random moments, run it again, and count what is lost.

    PYTHONPATH=tests python -m fuzzing.kills --kills 210 --seed 0

A trial runs a command in an empty folder and kills it, up to four times in a row; each run takes up
what the one before left, as its user would. The last one is left alone. What is there before and
after each kill, and in the end, is compared byte by byte with an undisturbed run. The moments are
the same for the same seed, but for the time that the system takes to start a process.
"""

import argparse
import csv
import io
import os
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from arena import write_sequence
from clips import write_film
from motes import synthetic
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

PROGRAM = [sys.executable, "-m"]
SIZE = (160, 120)
PATIENCE = 60.0
"""Seconds that the processes of a killed run have to clean up after it."""
TIMES = ("seconds", "ms_median", "ms_95", "fps")
"""Columns of an evaluation that no run repeats."""

NUMBERS = (
    "kills", "of them after the first bytes", "bytes there after a kill", "bytes lost",
    "bytes different", "runs blocked", "temporary folders left",
)  # fmt: skip
"""What is counted of the trials of a command; of what is lost, different or blocked there shall be
none. Temporary folders are left by a run that is killed before its first worker is there."""
WRONG = NUMBERS[3:6]

Files = dict[str, bytes]


class Case(NamedTuple):
    """A command that is killed, the same for the first run and those after it.

    `files` are patterns of what is compared. A run `continues` what an earlier one wrote, or it
    starts anew; and its files may hold times, which no run repeats.
    """

    name: str
    arguments: tuple[str, ...]
    files: tuple[str, ...]
    continues: bool = True
    timed: bool = False

    def start(self, folder: Path) -> subprocess.Popen[bytes]:
        """Run the command in a folder."""
        scratch = folder / "tmp"
        scratch.mkdir(exist_ok=True)
        with (folder / "errors").open("wb") as errors:
            return subprocess.Popen(
                [*PROGRAM, *self.arguments],
                cwd=folder,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                env=os.environ | {"TMPDIR": str(scratch)},
            )

    def written(self, folder: Path) -> Files:
        """Return what the files hold at this moment, by name."""
        found = (path for pattern in self.files for path in sorted(folder.glob(pattern)))
        return {str(path.relative_to(folder)): path.read_bytes() for path in found}

    def comparable(self, files: Files) -> Files:
        """Return files without what no run repeats."""
        return {name: _untimed(data) for name, data in files.items()} if self.timed else files


def cases(clip: Path, sequences: Path) -> list[Case]:
    """Return the commands that are killed."""
    follow = ("motes", "track", str(clip), "--init", "20,50,30,24")
    return [
        Case(
            "track -o .csv --resume",
            (*follow, "-o", "rows.csv", "--overlay", "film.mp4", "--resume"),
            ("rows.csv",),
        ),
        Case("track -o .jsonl --resume", (*follow, "-o", "rows.jsonl", "--resume"), ("*.jsonl",)),
        Case(
            "watch -o .csv --events",
            ("motes", "watch", str(clip), "-o", "o.csv", "--events", "e.jsonl", "--overwrite"),
            ("o.csv", "e.jsonl"),
            continues=False,
        ),
        Case(
            "evaluate --resume",
            (
                "motes_lab", "evaluate", str(sequences), "--tracker", "nummiaro",
                "--tracker", "mean_shift", "--seeds", "3", "--workers", "2", "--out", "out",
                "--resume",
            ),
            ("out/tracks/*/*/*.csv", "out/results.csv"),
            timed=True,
        ),
    ]  # fmt: skip


def render(folder: Path) -> tuple[Path, Path]:
    """Render a clip and a dataset; return both."""
    film = folder / "clip.mp4"
    write_film(film, synthetic.crossing(SIZE, 400))
    for name, clip in (("a", synthetic.crossing(SIZE, 60)), ("b", synthetic.turning(SIZE, 60))):
        write_sequence(folder / "sequences" / name, clip)
    return film, folder / "sequences"


def trial(
    case: Case, rng: random.Random, folder: Path, whole: Files, seconds: float, tally: Counter[str]
) -> float:
    """Kill a command up to four times, let it end, and count what it did to its files.

    `whole` is what an undisturbed run writes in so many `seconds`. Return how many that are now,
    as other programs may take more or less of the machine: less if the command ended sooner.
    """

    def compare(first: Files, later: Files, what: str) -> None:
        """Count the bytes of files that later ones do not begin with."""
        for name, data in first.items():
            if missing := len(data) - _agreeing(data, later.get(name, b"")):
                tally[what] += missing
                print(f"{case.name}: {name} has {missing} {what}", file=sys.stderr)

    before: Files = {}
    for _ in range(rng.randint(1, 4)):
        process = case.start(folder)
        try:
            process.wait(rng.uniform(0, 1.1 * seconds))
            seconds *= 0.8
            break
        except subprocess.TimeoutExpired:
            seen = case.written(folder)
            seconds *= 1.05
        process.kill()
        process.wait()
        after = case.written(folder)
        tally["kills"] += 1
        tally["of them after the first bytes"] += any(after.values())
        tally["bytes there after a kill"] += sum(map(len, after.values()))
        for known in (seen, before) if case.continues else (seen,):
            compare(known, after, "bytes lost")
        if not case.timed:
            compare(after, whole, "bytes different")
        before = after
    if case.start(folder).wait() != 0:
        tally["runs blocked"] += 1
        print(f"{case.name}: {(folder / 'errors').read_text()}", file=sys.stderr)
    ended = case.written(folder)
    if case.continues:
        compare(before, ended, "bytes lost")
    expected, got = case.comparable(whole), case.comparable(ended)
    compare(expected, got, "bytes different")
    compare(got, expected, "bytes different")
    tally["partial files"] += sum(1 for _ in folder.rglob("*.partial-*"))
    waited = time.monotonic() + PATIENCE
    while (remains := os.listdir(folder / "tmp")) and time.monotonic() < waited:
        time.sleep(0.5)
    tally["temporary folders left"] += len(remains)
    return seconds


def _agreeing(first: bytes, second: bytes) -> int:
    """Return with how many equal bytes two files begin."""
    pairs = enumerate(zip(first, second, strict=False))
    shorter = min(len(first), len(second))
    return next((place for place, (one, other) in pairs if one != other), shorter)


def _untimed(data: bytes) -> bytes:
    """Return CSV without the columns of times."""
    rows = list(csv.reader(io.StringIO(data.decode())))
    kept = [i for i, name in enumerate(rows[0]) if name not in TIMES]
    return "\n".join(",".join(row[i] for i in kept) for row in rows).encode()


def main() -> int:
    """Kill each command so many times, and print what came of it."""
    parser = argparse.ArgumentParser(prog="python -m fuzzing.kills", description=__doc__)
    parser.add_argument("--kills", type=int, default=200, help="of all commands together")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rows, all_of_them = list[Row](), Counter[str]()
    with tempfile.TemporaryDirectory(prefix="kills-") as scratch:
        commands = cases(*render(Path(scratch)))
        for case in commands:
            rng, tally = random.Random(f"{options.seed} {case.name}"), Counter[str]()
            whole, seconds = _undisturbed(case, Path(scratch))
            while tally["kills"] < options.kills / len(commands):
                with tempfile.TemporaryDirectory(prefix="trial-", dir=scratch) as folder:
                    seconds = trial(case, rng, Path(folder), whole, seconds, tally)
            rows.append((Cell(case.name), *(Cell(f"{tally[each]:,}") for each in NUMBERS)))
            all_of_them += tally
    note = f"{all_of_them['partial files']} partial files of overlays are left."
    print(markdown.table(Table("Commands that are killed", ("command", *NUMBERS), rows, note=note)))
    return int(any(all_of_them[each] for each in WRONG))


def _undisturbed(case: Case, scratch: Path) -> tuple[Files, float]:
    """Return what a whole run writes, and its seconds; the one before it compiles kernels."""
    for _ in range(2):
        with tempfile.TemporaryDirectory(prefix="whole-", dir=scratch) as folder:
            start = time.monotonic()
            if case.start(Path(folder)).wait() != 0:
                raise SystemExit(f"{case.name}: {(Path(folder) / 'errors').read_text()}")
            whole, seconds = case.written(Path(folder)), time.monotonic() - start
    return whole, seconds


if __name__ == "__main__":
    sys.exit(main())
