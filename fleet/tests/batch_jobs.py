"""Films and jobs for the tests of `motes_fleet.cluster`, and what their workers do."""

import csv
import os
import signal
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from clips import clip
from motes import SourceError
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.work import Made

REGION = "2,2,16,12"


def films(folder: Path, count: int = 3) -> list[Path]:
    """Write films of 10, 15, ... frames."""
    return [clip(folder / f"film-{n}.mp4", 10 + 5 * n) for n in range(count)]


def table(path: Path, rows: Sequence[Mapping[str, Any]]) -> Path:
    """Write a table of jobs in CSV; by default each tracks `REGION` with 20 particles."""
    usual = {"init": REGION, "preset": "nummiaro"}
    complete = [usual | dict(row) for row in rows]
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, list({name: None for row in complete for name in row}))
        writer.writeheader()
        writer.writerows(complete)
    return path


# The functions below run in workers.


def square(number: int) -> int:
    return number * number


def raise_error(text: str) -> None:
    raise ValueError(text)


def hang(_: object) -> None:
    time.sleep(600)


def die(_: object) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def die_first(marker: str) -> str:
    """End the process, unless the marker is there already."""
    if not Path(marker).exists():
        Path(marker).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "alive"


def make(job: Job, folder: Path, form: str, overlay: bool) -> Made:
    """Do what the name of a job begins with."""
    if job.name.startswith("dies"):
        die(None)
    if job.name.startswith("hangs"):
        hang(None)
    if job.name.startswith("fails"):
        raise SourceError("This film is broken.")
    (folder / f"rows.{form}").write_text(f"{Path(job.source).name} {job.seed}\n")
    return 3, None
