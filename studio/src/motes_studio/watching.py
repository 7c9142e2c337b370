"""The many-object mode of a session: its run, and all parts that pages have still to get."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Any

import msgspec

from motes import MotesError
from motes_studio.board import Board, StudioJob
from motes_studio.commands import Places, Watch
from motes_studio.document import regions_of
from motes_studio.messages import FoundScene
from motes_studio.pool import LONG, WorkerPool
from motes_studio.scenes import ScenePart, config_of, joined, shown
from motes_studio.store import Store
from motes_studio.tracking import watch_film
from motes_studio.workplace import Task

PARTS, RUN_OF, ENDED = "scene", "scene run", "scene ended"
"""Keys in the store: of the parts, of what was asked for, and of the mark that it has ended."""


class Watching:
    """Tracks all that moves in a session's film, which has `frames` frames."""

    def __init__(
        self, session: str, store: Store, frames: int, pool: WorkerPool, board: Board
    ) -> None:
        self._session, self._store = session, store
        self._frames, self._pool, self._board = frames, pool, board
        self.job: StudioJob | None = None
        self._task: asyncio.Task[None] | None = None
        data = self._store.parts(self._session, RUN_OF)
        self.asked = msgspec.json.decode(data, type=tuple[Watch, Places]) if data else None

    def begin(self, watch: Watch, places: Places) -> StudioJob:
        """Begin a run; an earlier one ends, and its objects go."""
        task = partial(
            watch_film, config=config_of(watch), places=regions_of(places), seed=watch.seed
        )
        if self.job is not None:
            self.stop(self.job)
        self.asked = watch, places
        for key in (PARTS, RUN_OF, ENDED):
            self._store.forget(self._session, key)
        self._store.add_part(self._session, RUN_OF, msgspec.json.encode(self.asked))
        self._board.extend_scene(reset=True)
        job = self._board.begin_job("watch", [])
        job.left = self._frames
        self.job = job
        self._task = asyncio.create_task(self._run(job, task))
        return job

    def go_on(self) -> None:
        """Begin the run again that was under way when the session was closed."""
        if self.asked is not None and not self._store.parts_from(self._session, ENDED):
            self.begin(*self.asked)

    def stop(self, job: StudioJob) -> None:
        """End the run; what it has found stays."""
        if job.active:
            job.status = "stopped"
            self._store.add_part(self._session, ENDED, b"")
            self.close()
            self._board.progress(job)

    def close(self) -> None:
        """Stop the run, which goes on when the session is opened again."""
        if self._task is not None:
            self._task.cancel()

    async def _run(self, job: StudioJob, task: Task) -> None:
        def part(data: bytes) -> None:
            if self.job is not job or not job.active:
                return
            self._store.add_part(self._session, PARTS, data)
            found = msgspec.json.decode(data, type=ScenePart)
            job.note, frames = found.note, len(found.frames)
            job.done, job.left = job.done + frames, max(job.left - frames, 0)
            self._board.extend_scene()
            self._board.progress(job)

        try:
            async with self._pool.worker(LONG) as worker:
                if job.status == "waiting":
                    job.status = "running"
                await worker.run(task, part)
            self._store.add_part(self._session, ENDED, b"")
            job.status, job.left = "done", 0
        except MotesError as error:  # also of the store, as on a full disk
            job.status, job.error = "failed", str(error)
        self._board.progress(job)

    def since(self, first: int) -> tuple[FoundScene | None, int]:
        """Return what the parts from `first` on have, and the number of the part after them."""
        found = self._parts(first, STEP)
        if not found:
            return None if first else FoundScene([], [], 0, {}, reset=True), first
        part = joined(found)
        frames = [*map(shown, part.frames)]
        scene = FoundScene(frames, part.events, part.objects, part.totals, reset=first == 0)
        return scene, first + len(found)

    def parts(self, first: int = 0, most: int = -1) -> list[bytes]:
        """Return the JSON of `ScenePart`s: `most` at most from one on, or all."""
        return self._store.parts_from(self._session, PARTS, first, most)

    def _parts(self, first: int = 0, most: int = -1) -> list[ScenePart]:
        return [msgspec.json.decode(each, type=ScenePart) for each in self.parts(first, most)]

    def events(self) -> list[dict[str, Any]]:
        """Return all events so far."""
        return [event for part in self._parts() for event in part.events]


STEP = 50
"""Parts of a message at most."""
