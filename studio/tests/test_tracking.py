"""Passes over a stretch: they run together, and what they share is decoded once."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, cast

import msgspec
import numpy as np
import pytest

from motes import preset
from motes.core import Part
from motes.video import Film
from motes_studio.board import Board
from motes_studio.commands import Region
from motes_studio.document import Document, DrawnTarget
from motes_studio.jobs import Jobs
from motes_studio.messages import OpenFilm
from motes_studio.plan import RunPass
from motes_studio.pool import WorkerPool
from motes_studio.results import Results
from motes_studio.store import Store
from motes_studio.tables import MILLISECONDS, unpack
from motes_studio.tracking import PassPart, run_passes
from motes_studio.workplace import Task, Workplace
from studios import BOX, film

MOVED: Region = (32.0, *BOX[1:])


class Sent:
    """A workplace that keeps what is sent."""

    def __init__(self, path: Path) -> None:
        self.film = Film(path)
        self.parts: list[PassPart] = []

    def send(self, part: Part) -> None:
        """Keep rows."""
        self.parts.append(msgspec.msgpack.decode(part.data, type=PassPart))

    def check(self) -> None:
        """Nothing is wanted."""


def test_passes_have_rows_as_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sent = Sent(film(tmp_path / "film.mkv", frames=12))
    config = preset("nummiaro")
    ellipses = (45.0, 45.0, 15.0, 20.0, 0.0), (46.0, 45.0, 15.0, 20.0, 0.0)
    forward = RunPass(config, 0, 2, ellipses[0], 9, (9, ellipses[1]))
    backward = RunPass(config, 0, 9, ellipses[1], 2, (2, ellipses[0]))

    def rows(*passes: RunPass) -> list[list[list[float]]]:
        sent.parts.clear()
        run_passes(cast(Workplace, sent), passes)
        tables = [
            (part.run, np.delete(unpack(part.rows, 1), MILLISECONDS, axis=1).tolist())
            for part in sent.parts
        ]
        return [
            [row for run, table in tables if run == place for row in table]
            for place in range(len(passes))
        ]

    alone = rows(forward) + rows(backward)
    loads, begun = Film.loads, list[int]()

    def counted(self: Film, first: int) -> Iterator[object]:
        begun.append(first)
        return loads(self, first)

    monkeypatch.setattr(Film, "loads", counted)
    assert repr(rows(forward, backward)) == repr(alone)
    assert [row[0] for row in alone[1]] == [*range(9, 1, -1)]
    assert begun == [2]


class Waiting:
    """Workers that note their tasks, and never end."""

    def __init__(self) -> None:
        self.tasks: list[Task] = []

    @asynccontextmanager
    async def worker(self, frames: int) -> AsyncIterator[Waiting]:
        """Give itself."""
        yield self

    async def run(self, task: Task, part: Callable[[bytes], None]) -> bytes:
        """Note a task, and wait."""
        self.tasks.append(task)
        await asyncio.Event().wait()
        return b""


@pytest.mark.parametrize(("width", "together"), [(96, 2), (60_000, 1)])
def test_a_correction_runs_the_passes_of_a_stretch_together(
    tmp_path: Path, width: int, together: int
) -> None:
    """Where their frames fit into memory."""

    async def tasks() -> list[Any]:
        store, pool = Store(tmp_path / "studio.sqlite"), Waiting()
        session = store.begin("film.mkv", uploaded=False)
        facts = OpenFilm("film.mkv", width, 80, 101, 25.0)
        results, board = Results(session, store), Board(facts.frames)
        jobs = Jobs(results, facts, cast(WorkerPool, pool), board, incomplete=lambda _: None)
        keys: dict[int, Region] = {0: BOX, 40: MOVED, 100: BOX}
        target = DrawnTarget(1, "disk", "#000000", "mean_shift", None, 0, 0, 100, keys=keys)
        jobs.update(Document((target,)))
        jobs.track([1])
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        jobs.close()
        store.close()
        return pool.tasks

    found = asyncio.run(tasks())
    passes = [task.keywords["passes"] for task in found]
    assert [*map(len, passes)] == [together] * (4 // together)
    ends = {(each.start, each.stop) for runs in passes for each in runs}
    assert ends == {(0, 40), (40, 0), (40, 100), (100, 40)}
