"""Tasks of a worker: one at a time; what nobody waits for any more ends, or never begins."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
import time
from collections.abc import Callable
from functools import partial
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import pytest

import loops
from motes.core.errors import MotesError
from motes.sot.presets import preset
from motes.studio.pictures import picture
from motes.studio.plan import RunPass
from motes.studio.processes import Wish, Worker, film_worker
from motes.studio.safety import Limits
from motes.studio.sessions import LiveSession
from motes.studio.studio import Studio
from motes.studio.tracking import run_passes
from motes.studio.workplace import PAUSE, STOP, Done, Part, Task
from studios import begin, film, running

pytestmark = pytest.mark.slow

PATIENCE = 600.0


class Begun:
    """The tasks that workers have begun and ended.

    Attributes
    ----------
    workers
        The workers that make pictures.
    asked, begun, ended
        The pictures that were asked for, those whose work has begun, and those for which nobody
        waits any more.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.workers: list[Worker] = []
        self.asked: list[int] = []
        self.begun: list[int] = []
        self.ended: list[int] = []
        asked, begin = LiveSession.picture, Worker._run

        async def noted(session: LiveSession, index: int, width: int) -> bytes:
            self.asked.append(index)
            try:
                return await asked(session, index, width)
            finally:
                self.ended.append(index)

        async def noted_begin(worker: Worker, task: Task, *rest: Any) -> Done:
            if isinstance(task, partial) and task.func is picture:
                self.workers.append(worker)
                self.begun.append(task.keywords["index"])
            return await begin(worker, task, *rest)

        monkeypatch.setattr(LiveSession, "picture", noted)
        monkeypatch.setattr(Worker, "_run", noted_begin)


def until(so: Callable[[], object]) -> None:
    """Wait until something is so."""
    end = time.monotonic() + PATIENCE
    while not so():
        assert time.monotonic() < end
        time.sleep(0.01)


def test_a_picture_that_is_given_up_is_not_decoded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "films").mkdir()
    film(tmp_path / "films" / "film.mkv", frames=12)
    found = Begun(monkeypatch)
    with running(tmp_path / "films", tmp_path / "data") as client:
        address = f"/api/sessions/{begin(client)}/frames"
        assert client.get(f"{address}/0.jpg").status_code == 200
        worker = found.workers[-1]
        os.kill(worker.pid, signal.SIGSTOP)
        busy = threading.Thread(target=lambda: client.get(f"{address}/5.jpg"))
        busy.start()
        until(lambda: 5 in found.begun)
        for index in (6, 7):
            page = HTTPConnection(client.base_url.host, client.base_url.port or 80)
            page.request("GET", f"{address}/{index}.jpg")
            until(lambda n=index: n in found.asked)  # type: ignore[misc]
            page.close()
        until(lambda: {6, 7} <= {*found.ended})
        os.kill(worker.pid, signal.SIGCONT)
        busy.join()
        assert client.get(f"{address}/8.jpg").status_code == 200
    assert found.begun == [0, 5, 8]


def test_a_wish_counts_from_before_the_begin(tmp_path: Path) -> None:
    path = film(tmp_path / "film.mkv", frames=12)
    run = RunPass(preset("mean_shift"), 0, 0, (45.0, 45.0, 15.0, 20.0, 0.0), 11)
    task = partial(run_passes, passes=[run])

    async def tried() -> None:
        worker, paused, stopped = film_worker(path, Limits(), background=True), Wish(), Wish()
        parts: list[Part] = []
        first = asyncio.Event()

        def part(part: Part) -> None:
            parts.append(part)
            first.set()

        paused.set(PAUSE)
        stopped.set(STOP)
        work = asyncio.create_task(worker.run(task, part, paused))
        await first.wait()
        assert worker._wish.value == PAUSE
        paused.set(STOP)
        assert (await work).stopped
        parts.clear()
        assert (await worker.run(task, part, stopped)).stopped
        assert not parts
        assert not (await worker.run(task, part)).stopped
        worker.close()

    loops.run(tried(), PATIENCE)


def test_a_session_that_is_removed_while_it_opens_is_gone(tmp_path: Path) -> None:
    (tmp_path / "films").mkdir()
    film(tmp_path / "films" / "film.mkv", frames=12)

    async def tried() -> None:
        studio = Studio(tmp_path / "films", tmp_path / "data", Limits())
        name = studio.store.begin("film.mkv", uploaded=False)
        opening = asyncio.create_task(studio.session(name))
        while name not in studio._open:
            await asyncio.sleep(0)
        assert studio._open[name].busy
        studio.remove(name)
        with pytest.raises(MotesError, match="was closed"):
            await opening
        studio.close()

    loops.run(tried(), PATIENCE)
