"""Kill motes with SIGKILL at random moments, run it again, and count what is lost.

    PYTHONPATH=tests python -m fuzzing.kills --kills 210 --seed 0

A trial runs a command in an empty folder and kills it, up to four times in a row; each run takes up
what the one before left, as its user would. The last one is left alone. What is there before and
after each kill, and in the end, is compared byte by byte with an undisturbed run. The moments are
the same for the same seed, but for the time that the system takes to start a process.
"""

from __future__ import annotations

import argparse
import csv
import io
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from PIL import Image

from motes import synthetic
from motes.synthetic.clips import Clip
from motes.video.writer import VideoWriter
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

PROGRAM = [sys.executable, "-m"]
SIZE = (160, 120)
PATIENCE = 60.0
"""Seconds that the processes of a killed run have to clean up after it."""
TIMES = ("seconds", "ms_median", "ms_95", "fps")
"""Columns of an evaluation that no run repeats."""

NUMBERS = {
    "kills": "kills",
    "writing": "of them after the first bytes",
    "kept": "bytes there after a kill",
    "lost": "bytes lost",
    "different": "bytes different",
    "blocked": "runs blocked",
    "left": "temporary folders left",
}
"""Columns of the table, by what they are of a tally."""

Files = dict[str, bytes]


@dataclass(frozen=True)
class Case:
    """A command that is killed: its arguments, how it goes on, and which of its files count.

    Attributes
    ----------
    name
        For people.
    arguments
        The same for the first run and those after it.
    files
        Patterns of the files that are compared.
    continues
        Whether a run keeps what an earlier one wrote; otherwise it starts anew.
    timed
        Whether the files hold times, which no run repeats.
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


@dataclass
class Tally:
    """What came of the trials of a case.

    Attributes
    ----------
    kills
        How many runs were killed.
    writing
        After how many of these kills something was written.
    kept
        Bytes that were there after the kills.
    lost, different
        Bytes that were there before a kill and not after it or in the end, and bytes that are not
        as in an undisturbed run; both shall be 0.
    blocked
        Last runs that did not end well; shall be 0.
    unfinished
        Partial files beside the results, which a killed run leaves.
    left
        Temporary folders that nobody removed, as of a run killed before its first worker was there.
    notes
        What went wrong.
    """

    kills: int = 0
    writing: int = 0
    kept: int = 0
    lost: int = 0
    different: int = 0
    blocked: int = 0
    unfinished: int = 0
    left: int = 0
    notes: list[str] = field(default_factory=list)

    @property
    def good(self) -> bool:
        """Whether nothing was lost, changed or blocked."""
        return not (self.lost or self.different or self.blocked)


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
    with VideoWriter(film, 25) as writer:
        for frame, _ in synthetic.crossing(SIZE, 400):
            writer.write(frame.pixels)
    for name, clip in (("a", synthetic.crossing(SIZE, 60)), ("b", synthetic.turning(SIZE, 60))):
        _sequence(folder / "sequences" / name, clip)
    return film, folder / "sequences"


def _sequence(folder: Path, clip: Clip) -> None:
    (folder / "img").mkdir(parents=True)
    rows = []
    for frame, truths in clip:
        Image.fromarray(frame.pixels).save(folder / "img" / f"{frame.index + 1:04d}.png")
        x, y, width, height = truths[0].ellipse.box
        rows.append(f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f}\n")
    (folder / "groundtruth_rect.txt").write_text("".join(rows))


def trial(
    case: Case, rng: random.Random, folder: Path, whole: Files, seconds: float, tally: Tally
) -> float:
    """Kill a command up to four times, let it end, and note what it did to its files.

    `whole` is what an undisturbed run writes in so many `seconds`. Return how many that are now,
    as other programs may take more or less of the machine: less if the command ended sooner.
    """
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
        tally.kills += 1
        tally.writing += any(after.values())
        tally.kept += sum(map(len, after.values()))
        for known in (seen, before) if case.continues else (seen,):
            _compare(known, after, tally, "lost", case.name)
        if not case.timed:
            _compare(after, whole, tally, "different", case.name)
        before = after
    process = case.start(folder)
    if process.wait() != 0:
        tally.blocked += 1
        tally.notes.append(f"{case.name}: {(folder / 'errors').read_text()}")
    ended = case.written(folder)
    if case.continues:
        _compare(before, ended, tally, "lost", case.name)
    expected, got = case.comparable(whole), case.comparable(ended)
    _compare(expected, got, tally, "different", case.name)
    _compare(got, expected, tally, "different", case.name)
    _look_for_remains(case, folder, tally)
    return seconds


def _compare(first: Mapping[str, bytes], later: Files, tally: Tally, what: str, name: str) -> None:
    """Count the bytes of files that later ones do not begin with."""
    for file, data in first.items():
        kept = _agreeing(data, later.get(file, b""))
        if kept < len(data):
            setattr(tally, what, getattr(tally, what) + len(data) - kept)
            tally.notes.append(f"{name}: {file} has {len(data) - kept} bytes {what}")


def _agreeing(first: bytes, second: bytes) -> int:
    """Return with how many equal bytes two files begin."""
    pairs = enumerate(zip(first, second, strict=False))
    shorter = min(len(first), len(second))
    return next((place for place, (one, other) in pairs if one != other), shorter)


def _look_for_remains(case: Case, folder: Path, tally: Tally) -> None:
    """Count unfinished files, and temporary ones that are still there after a while."""
    tally.unfinished += sum(1 for _ in folder.rglob("*.partial-*"))
    waited = time.monotonic() + PATIENCE
    while (remains := os.listdir(folder / "tmp")) and time.monotonic() < waited:
        time.sleep(0.5)
    tally.left += len(remains)
    tally.notes += [f"{case.name}: {name} is left" for name in remains]


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
    rows, good, unfinished = list[Row](), True, 0
    with tempfile.TemporaryDirectory(prefix="kills-") as scratch:
        commands = cases(*render(Path(scratch)))
        for case in commands:
            rng, tally = random.Random(f"{options.seed} {case.name}"), Tally()
            whole, seconds = _undisturbed(case, Path(scratch))
            while tally.kills < options.kills / len(commands):
                with tempfile.TemporaryDirectory(prefix="trial-", dir=scratch) as folder:
                    seconds = trial(case, rng, Path(folder), whole, seconds, tally)
            cells = (Cell(f"{getattr(tally, name):,}") for name in NUMBERS)
            rows.append((Cell(case.name), *cells))
            print(*tally.notes, sep="\n", file=sys.stderr)
            good &= tally.good
            unfinished += tally.unfinished
    head = "command", *NUMBERS.values()
    note = f"{unfinished} partial files of overlays are left."
    print(markdown.table(Table("Commands that are killed", head, rows, note=note)))
    return 0 if good else 1


def _undisturbed(case: Case, scratch: Path) -> tuple[Files, float]:
    """Return what a whole run writes, and its seconds; the one before it compiles kernels."""
    for _ in range(2):
        with tempfile.TemporaryDirectory(prefix="whole-", dir=scratch) as folder:
            start = time.monotonic()
            process = case.start(Path(folder))
            if process.wait() != 0:
                raise SystemExit(f"{case.name}: {(Path(folder) / 'errors').read_text()}")
            whole, seconds = case.written(Path(folder)), time.monotonic() - start
    return whole, seconds


if __name__ == "__main__":
    sys.exit(main())
