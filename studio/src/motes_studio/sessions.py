"""A session while it is open: its document with undo and redo, its jobs, and the pages on it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path

import msgspec
import numpy as np

from motes import ConfigError, Ellipse, MotesError
from motes_studio import commands, messages, pictures
from motes_studio.board import Board, StudioJob
from motes_studio.clients import Client
from motes_studio.commands import Command, Region
from motes_studio.document import Document, DrawnTarget, asks_no_tracker, changed, renumbered
from motes_studio.film_worker import FilmWorker
from motes_studio.jobs import Jobs
from motes_studio.messages import Keyframe, OpenFilm, Reply
from motes_studio.pool import WorkerPool
from motes_studio.results import Results
from motes_studio.safety import Limits
from motes_studio.store import Store
from motes_studio.tables import ELLIPSE, Table
from motes_studio.watching import Watching
from motes_studio.workplace import Opened, Task

WHOLE = "film read whole"
"""The key in the store of the mark that a film is damaged; and the times of its frames before that,
until the documents have the frames of now."""


class LiveSession:
    """An open session.

    Parameters
    ----------
    name
        Its name in the store.
    path
        Its film.
    store, limits
        Where it is kept, and what it may use.
    reopen
        Called if the session has to be opened anew: its film is damaged.
    """

    def __init__(
        self, name: str, path: Path, store: Store, limits: Limits, reopen: Callable[[], None]
    ) -> None:
        self.name, self.path = name, path
        self._store, self._limits = store, limits
        self._film, _, self._place, tracked = store.session(name)
        self._tracked = set(tracked)
        self.document = store.document(name, self._place)
        self._last = store.last_place(name)
        self._revision = self._place
        self.clients: set[Client] = set()
        self._closed = False
        self._reopen = reopen
        self.whole = bool(store.parts_from(name, WHOLE))
        """Whether the film is known to be damaged, and is read as a whole."""
        workers = partial(FilmWorker, path, limits, whole=self.whole, damaged=self._find_damage)
        self._pool = WorkerPool(workers)
        waited_for = partial(workers, background=False)
        self._pictures, self._files = (WorkerPool(waited_for, most=1) for _ in range(2))
        self.facts: OpenFilm
        self.times: list[float]
        self.files: list[str]
        """The time of each frame, and the names of its images; none of a video."""
        self.board: Board
        self.jobs: Jobs
        self.watching: Watching

    async def open(self) -> None:
        """Open the film, and go on with what was under way.

        Raises
        ------
        WorkerError
            If it cannot be read.
        """
        async with self._pictures.worker() as worker:
            opened = msgspec.msgpack.decode(await worker.ready(), type=Opened)
        facts, self.times, self.files = opened
        self.facts = msgspec.structs.replace(facts, name=self._film)
        if before := self._store.parts(self.name, WHOLE):
            times = np.frombuffer(before).tolist()
            self._store.rewrite(self.name, lambda each: renumbered(each, times, self.times), WHOLE)
            self.document = self._store.document(self.name, self._place)
        self._pool.warm()
        self.board = Board(self.facts.frames)
        results = Results(self.name, self._store)
        self.jobs = Jobs(results, self.facts, self._pool, self.board, self._forget_tracked)
        self.watching = Watching(self.name, self._store, self.facts.frames, self._pool, self.board)
        self.jobs.update(self.document)
        self._go_on()
        self.watching.go_on()

    def _find_damage(self) -> None:
        """Note that the film is damaged: it is read as a whole when the session is opened next."""
        if not self.whole:
            self.whole = True
            self._store.add_part(self.name, WHOLE, np.array(self.times).tobytes())
            self._reopen()

    def _go_on(self) -> None:
        """Track what was tracked, and is not complete any more."""
        numbers = [each.object for each in self.document.targets if each.object in self._tracked]
        if left := [each for each in numbers if not self.jobs.complete(each)]:
            self.jobs.track(left)

    @property
    def busy(self) -> bool:
        """Whether somebody looks at it, or something runs; also while it is opened."""
        opening = not hasattr(self, "watching")
        return bool(opening or self.clients) or any(job.active for job in self.board.jobs.values())

    def close(self) -> None:
        """End all processes; nothing is lost. Pages that look may come again."""
        self._closed = True
        for client in self.clients:
            client.end()
        if hasattr(self, "watching"):
            self.jobs.close()
            self.watching.close()
        for pool in (self._pool, self._pictures, self._files):
            pool.close()

    # Pictures.

    async def picture(self, index: int, width: int) -> bytes:
        """Return a frame as JPEG; raise a MotesError if there is none, or it cannot be read."""
        if index >= self.facts.frames:
            raise ConfigError(
                f"There is no frame {index}; the last one is {self.facts.frames - 1}."
            )
        return await self._pictures.run(partial(pictures.picture, index=index, width=width))

    async def strip(self, count: int, height: int) -> bytes:
        """Return thumbnails side by side as JPEG."""
        return await self._pictures.run(partial(pictures.strip, count=count, height=height))

    async def ask(self, task: Task, frames: int = 0) -> bytes:
        """Let a tracking worker do a task; `frames` is its length, 0 for a short one."""
        return await self._pool.run(task, frames)

    async def work(self, task: Task) -> bytes:
        """Let a worker do a task about a file that comes in or goes out; runs do not wait for it.

        One is done at a time, so that the memory of one worker is enough for all.
        """
        return await self._files.run(task)

    # What pages see.

    def join(self) -> Client:
        """Let a page look: it gets the state and all rows."""
        client = Client(self.board, self.state, self.watching.since)
        self.clients.add(client)
        self.board.news.add(client.news)
        return client

    def leave(self, client: Client) -> None:
        """Let a page go."""
        self.clients.discard(client)
        self.board.news.discard(client.news)

    def state(self) -> messages.WholeSession:
        """Return the session without rows."""
        return messages.WholeSession(
            id=self.name,
            film=self.facts,
            revision=self._revision,
            objects=[self._item(each) for each in self.document.targets],
            places=self.document.places,
            jobs=[job.progress() for job in self.board.jobs.values()],
            effort=self.document.effort,
            undo=self._place > 0,
            redo=self._place < self._last,
        )

    def _item(self, target: DrawnTarget) -> messages.Item:
        return messages.Item(
            *(getattr(target, name) for name in messages.Subject.__struct_fields__),
            keyframes=[Keyframe(*each) for each in target.keys.items()],
            cues=[*target.tracker.cues],
            tracked=target.object in self._tracked,
            imported=bool(target.imported),
        )

    # What pages ask for.

    def obey(self, command: Command) -> Reply:
        """Do what a page asks for, or begin it, and return the reply."""
        if self._closed:
            return Reply(command.id, "The session is opened anew; ask again.")
        try:
            return self._obey(command)
        except MotesError as error:
            return Reply(command.id, str(error))

    def _obey(self, command: Command) -> Reply:
        match command:
            case commands.TrackCommand():
                return Reply(command.id, job=self._track(command.objects).number)
            case commands.Watch():
                job = self.watching.begin(command, self.document.places)
                self.board.change_state()
                return Reply(command.id, job=job.number)
            case commands.Stop():
                if command.job not in self.board.jobs:
                    raise ConfigError(f"There is no job {command.job}.")
                job = self.board.jobs[command.job]
                (self.watching if job.kind == "watch" else self.jobs).stop(job)
                self.board.change_state()
            case commands.Undo():
                self._go(self._place - 1, "There is nothing to take back.")
            case commands.Redo():
                self._go(self._place + 1, "There is nothing to make again.")
            case _:
                return self._change(command)
        return Reply(command.id)

    def _change(self, command: Command) -> Reply:
        document, number = changed(
            self.document, command, self.facts, self._row_at, self._limits.networks
        )
        if asks_no_tracker(self.document, command):
            document = self.jobs.results.carried(self.document, document, self.times)
        self._put(document)
        if isinstance(command, commands.Split) and command.object in self._tracked:
            assert number is not None
            self._set_tracked({*self._tracked, number})
        self._take(document)
        return Reply(command.id, object=number)

    def _put(self, document: Document) -> None:
        """Store a changed document: it can be taken back from here."""
        self._store.change(self.name, self._place + 1, document)
        self._place += 1
        self._last = self._place

    def take_rows(self, document: Document, tables: dict[int, Table]) -> None:
        """Take objects whose rows are known, by their numbers, as from a file."""
        for number, table in tables.items():
            self.jobs.results.know(document.target(number), table)
        self._put(document)
        self._take(document)

    def _go(self, place: int, error: str) -> None:
        if not 0 <= place <= self._last:
            raise ConfigError(error)
        self._store.go(self.name, place)
        self._place = place
        self._take(self._store.document(self.name, place))

    def _take(self, document: Document) -> None:
        """Take a changed document; what was tracked is tracked again where it has changed.

        With another tracker or seed an object is not tracked, unless all its rows are known.
        """
        made_by = {each.object: each.made_by for each in self.document.targets}
        self.document = document
        self._revision += 1
        self.jobs.update(document)
        tracked = set(self._tracked)
        for each in document.targets:
            if self.jobs.complete(each.object):
                tracked.add(each.object)
            elif each.made_by != made_by.get(each.object, each.made_by):
                tracked.discard(each.object)
        if tracked != self._tracked:
            self._set_tracked(tracked)
        self._go_on()
        self.board.change_state()

    def _row_at(self, number: int, frame: int) -> Region | None:
        shown = self.board.rows(number, frame, frame)
        if not len(shown) or np.isnan(shown[0, ELLIPSE]).any():
            return None
        ellipse = Ellipse(*shown[0, ELLIPSE].tolist())
        return tuple(ellipse.box if self.document.target(number).boxed else ellipse)

    def _track(self, objects: list[int]) -> StudioJob:
        numbers = objects or [each.object for each in self.document.targets]
        if not numbers:
            raise ConfigError("There is nothing to track; draw an object first.")
        for number in numbers:
            self.document.target(number)
        if len(self.jobs.active) >= self._limits.jobs:
            raise ConfigError(f"{self._limits.jobs} jobs run already; wait for one, or stop it.")
        self._set_tracked({*self._tracked, *numbers})
        job = self.jobs.track(numbers)
        self.board.change_state()
        return job

    def _forget_tracked(self, objects: set[int]) -> None:
        with suppress(MotesError):  # as on a full disk: they are tracked again after a restart
            self._set_tracked(self._tracked - objects)
        self.board.change_state()

    def _set_tracked(self, tracked: set[int]) -> None:
        self._tracked = tracked
        self._store.set_tracked(self.name, sorted(tracked))
