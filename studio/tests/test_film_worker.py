"""Tasks of a worker: one at a time; what nobody waits for any more ends, or never begins."""

import asyncio
import os
import signal
import threading
from collections.abc import Callable
from functools import partial
from http.client import HTTPConnection
from pathlib import Path

import msgspec
import pytest

import loops
from motes import MotesError
from motes.core import Worker
from motes_studio.document import tracker_of
from motes_studio.film_worker import FilmWorker
from motes_studio.pictures import picture
from motes_studio.plan import RunPass
from motes_studio.safety import Limits
from motes_studio.sessions import LiveSession
from motes_studio.studio import Studio
from motes_studio.tables import unpack
from motes_studio.tracking import PassPart, run_passes
from motes_studio.workplace import Task
from studios import SLOW, begin, film, running
from waiting import PATIENCE, wait_until

pytestmark = pytest.mark.slow


class Begun:
    """Pictures that were asked for, begun, and those for which nobody waits; and their workers."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.workers: list[Worker] = []
        self.asked: list[int] = []
        self.begun: list[int] = []
        self.ended: list[int] = []
        asked, give = LiveSession.picture, Worker.give

        async def noted(session: LiveSession, index: int, width: int) -> bytes:
            self.asked.append(index)
            try:
                return await asked(session, index, width)
            finally:
                self.ended.append(index)

        def noted_give(worker: Worker, task: Task) -> None:
            if isinstance(task, partial) and task.func is picture:
                self.workers.append(worker)
                self.begun.append(task.keywords["index"])
            give(worker, task)

        monkeypatch.setattr(LiveSession, "picture", noted)
        monkeypatch.setattr(Worker, "give", noted_give)


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
        wait_until(lambda: 5 in found.begun)
        for index in (6, 7):
            page = HTTPConnection(client.base_url.host, client.base_url.port or 80)
            page.request("GET", f"{address}/{index}.jpg")
            wait_until(lambda n=index: n in found.asked)  # type: ignore[misc]
            page.close()
        wait_until(lambda: {6, 7} <= {*found.ended})
        os.kill(worker.pid, signal.SIGCONT)
        busy.join()
        assert client.get(f"{address}/8.jpg").status_code == 200
    assert found.begun == [0, 5, 8]


def test_a_task_that_is_cancelled_ends_or_never_begins(tmp_path: Path) -> None:
    path = film(tmp_path / "film.mkv", frames=12)
    ellipse = (45.0, 45.0, 15.0, 20.0, 0.0)
    slow, quick = (
        partial(run_passes, passes=[RunPass(tracker_of(*each), 0, 0, ellipse, 11)])
        for each in (("nummiaro", SLOW), ("mean_shift", None))
    )

    async def tried() -> None:
        worker, first = FilmWorker(path, Limits()), asyncio.Event()
        frames: dict[str, int] = {"slow": 0, "waiting": 0, "quick": 0}

        def count(name: str) -> Callable[[bytes], None]:
            def part(data: bytes) -> None:
                part = msgspec.msgpack.decode(data, type=PassPart)
                frames[name] += len(unpack(part.rows, 1))
                first.set()

            return part

        begun = asyncio.create_task(worker.run(slow, count("slow")))
        await first.wait()
        waiting = asyncio.create_task(worker.run(slow, count("waiting")))
        await asyncio.sleep(0)
        for each in (begun, waiting):
            each.cancel()
        await worker.run(quick, count("quick"))
        worker.close()
        assert begun.cancelled()
        assert 0 < frames["slow"] < 12
        assert (frames["waiting"], frames["quick"]) == (0, 12)

    loops.run(tried(), PATIENCE)


def test_a_part_that_cannot_be_used_ends_the_worker(tmp_path: Path) -> None:
    """As of a worker that a film has taken over: its job fails, and does not wait for ever."""
    path = film(tmp_path / "film.mkv", frames=12)
    ellipse = (45.0, 45.0, 15.0, 20.0, 0.0)
    task = partial(run_passes, passes=[RunPass(tracker_of("mean_shift", None), 0, 0, ellipse, 11)])

    def refuse(data: bytes) -> None:
        unpack(data[1:], 1)

    async def tried() -> None:
        worker = FilmWorker(path, Limits())
        with pytest.raises(MotesError, match=r"film\.mkv has spoilt its worker \(ValueError"):
            await worker.run(task, refuse)
        assert worker.ended

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
