"""The jobs of a session: which stretches are tracked, which rows are shown, how far all is."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterable
from functools import partial

import msgspec
import numpy as np
from msgspec.structs import replace

from motes import MotesError
from motes.video import fits
from motes_studio.board import Board, StudioJob
from motes_studio.document import Document, DrawnTarget
from motes_studio.messages import JobStatus, OpenFilm
from motes_studio.plan import PassNeed, StretchNeed, needs, own_frames
from motes_studio.pool import LONG, WorkerPool
from motes_studio.results import Results, cues_of
from motes_studio.tables import DISTANCE, FRAME, MILLISECONDS, SIZE, Table, unpack
from motes_studio.tracking import PassPart, join_stretch, run_passes

Left = Callable[[set[int]], None]
"""Takes the numbers of objects."""


class _Run:
    """A stretch that is being tracked, for the objects that need it."""

    def __init__(self, need: StretchNeed) -> None:
        self.need = need
        self.users: list[tuple[DrawnTarget, int]] = []
        """The objects, each with its first frame in this stretch that is not of the one before."""
        self.parts: dict[str, list[Table]] = {each.key: [] for each in need.passes}
        """The rows so far of its passes, by their keys."""
        self.task: asyncio.Task[None]

    def stop(self) -> None:
        """Stop the passes; nobody sees what may still come of them."""
        self.users = []
        self.task.cancel()


class Jobs:
    """Tracks the objects of a session, and keeps their rows.

    Parameters
    ----------
    results
        Where rows are kept.
    film, pool, board
        The film, its workers, and what pages see.
    incomplete
        Called with the objects that a job leaves without all of their rows.
    """

    def __init__(
        self, results: Results, film: OpenFilm, pool: WorkerPool, board: Board, incomplete: Left
    ) -> None:
        self.results, self._film, self._pool, self._board = results, film, pool, board
        self._incomplete = incomplete
        self._plans: dict[int, tuple[DrawnTarget, list[StretchNeed]]] = {}
        self._displayed: dict[int, set[str]] = {}
        self._runs: dict[str, _Run] = {}

    # What others ask for.

    @property
    def active(self) -> list[StudioJob]:
        """The jobs that track and have not ended."""
        return [job for job in self._board.jobs.values() if job.active and job.kind == "track"]

    def track(self, objects: Iterable[int]) -> StudioJob:
        """Track objects; return their job."""
        wanted = [*dict.fromkeys(objects)]
        for job in self.active:
            if set(wanted) <= set(job.objects):
                self._reconcile()
                return job
        for job in self.active:
            job.objects = [each for each in job.objects if each not in wanted]
        job = self._board.begin_job("track", wanted)
        self._reconcile()
        return job

    def stop(self, job: StudioJob, status: JobStatus = "stopped", error: str | None = None) -> None:
        """End a job; the rows so far stay."""
        if job.active:
            job.status, job.error = status, error
            self._reconcile()
            self._board.progress(job)
            self._incomplete({each for each in job.objects if not self.complete(each)})

    def update(self, document: Document) -> None:
        """Take a changed document: rows that are void go, and rows that are known come."""
        numbers = {each.object for each in document.targets}
        for number in [each for each in self._plans if each not in numbers]:
            del self._plans[number], self._displayed[number]
            self._board.forget(number)
        for job in self.active:
            job.objects = [each for each in job.objects if each in numbers]
        for target in document.targets:
            old, _ = self._plans.get(target.object, (None, None))
            if old != target:
                self._plans[target.object] = target, needs(target)
            if old is None or (old.tracker, old.seed) != (target.tracker, target.seed):
                self._board.void(target.object, cues_of(target))
                self._displayed[target.object] = set()
            elif old.frames != target.frames:  # as after a split
                kept = self._board.rows(target.object, target.first, target.last)
                self._board.void(target.object, cues_of(target))
                self._board.show(target.object, kept)
        self._reconcile()

    def runs(self, number: int) -> bool:
        """Return whether an object is being tracked."""
        return self._job_of(number) is not None

    def complete(self, number: int) -> bool:
        """Return whether all stretches of an object are tracked."""
        target, plan = self._plans[number]
        return all(self.results.get(need.key, target) is not None for need in plan)

    def close(self) -> None:
        """Stop all."""
        for run in self._runs.values():
            run.stop()
        self._runs.clear()

    # What follows.

    def _reconcile(self) -> None:
        """Show what is known, start what is missing, and stop what is not needed any more."""
        used: set[str] = set()
        wanted: dict[str, StretchNeed] = {}
        users: dict[str, list[tuple[DrawnTarget, int]]] = {}
        for number, (target, plan) in self._plans.items():
            self._show_finals(target, plan)
            job = self._job_of(number)
            for need, first in own_frames(plan):
                used.update((need.key, *(each.key for each in need.passes)))
                if job is not None and self.results.get(need.key, target) is None:
                    wanted[need.key] = need
                    users.setdefault(need.key, []).append((target, first))
        for key in self._runs.keys() - wanted.keys():
            self._runs.pop(key).stop()
        for key, need in wanted.items():
            if key not in self._runs:
                run = self._runs[key] = _Run(need)
                run.task = asyncio.create_task(self._run(run, users[key][0][0]))
            self._runs[key].users = users[key]
        self.results.keep(used)
        self._count()

    def _job_of(self, number: int) -> StudioJob | None:
        return next((job for job in self.active if number in job.objects), None)

    def _count(self) -> None:
        """Count the frames that are left of each job; a job without any is done."""
        for job in self.active:
            left: dict[str, int] = {}
            for number in job.objects:
                target, plan = self._plans[number]
                for need in plan:
                    if self.results.get(need.key, target) is None:
                        left[need.key] = self._left(target, need)
            job.left = sum(left.values())
            if not left:
                job.status = "done"
            elif job.status == "waiting":
                job.status = "running"
            self._board.progress(job)

    def _left(self, target: DrawnTarget, need: StretchNeed) -> int:
        """Return how many frames of the passes over a stretch are left."""
        run = self._runs.get(need.key)
        made = {} if run is None else {key: sum(map(len, each)) for key, each in run.parts.items()}
        missing = self.results.missing(need, target)
        return sum(each.frames - made.get(each.key, 0) for each in missing)

    async def _run(self, run: _Run, target: DrawnTarget) -> None:
        """Make the passes over a stretch that are missing, and join them."""
        need, errors = run.need, list[Exception]()
        try:
            missing = self.results.missing(need, target)
            groups = [missing] if self._share(need) else [[each] for each in missing]
            async with asyncio.TaskGroup() as together:
                for group in filter(None, groups):
                    together.create_task(self._track(run, target, group))
            await self._join(need, target)
        except* MotesError as found:  # also of the store, as on a full disk
            errors.extend(found.exceptions)
        if self._runs.get(need.key) is not run:
            return  # it was stopped
        del self._runs[need.key]
        for user, _ in run.users if errors else ():
            if job := self._job_of(user.object):
                self.stop(job, "failed", str(errors[0]))
        self._reconcile()

    def _share(self, need: StretchNeed) -> bool:
        """Return whether the passes over a stretch run together, and share what is decoded."""
        frames = need.stretch.last - need.stretch.first + 1
        return frames < LONG and fits(frames, self._film.width, self._film.height)

    async def _track(self, run: _Run, target: DrawnTarget, passes: list[PassNeed]) -> None:
        """Make passes; what they find is shown while they run."""

        def take(data: bytes) -> None:
            part = msgspec.msgpack.decode(data, type=PassPart)
            need = passes[part.run]
            parts = run.parts[need.key]
            parts.append(unpack(part.rows, cues_of(target)))
            self._show_part(run, need, part)
            if sum(map(len, parts)) == need.frames:
                self.results.put(need.key, np.concatenate(parts))

        async with self._pool.worker(sum(each.frames for each in passes)) as worker:
            task = partial(run_passes, passes=[each.task for each in passes])
            await worker.run(task, take)

    def _show_part(self, run: _Run, need: PassNeed, part: PassPart) -> None:
        table = run.parts[need.key][-1]
        for target, first in run.users:
            job = self._job_of(target.object)
            if job is None:
                continue
            job.done += len(table)
            job.note = job.note or part.note
            job.left = max(job.left - len(table), 0)
            self._board.progress(job)
            if need is (run.need.forward or run.need.backward):
                self._board.show(target.object, table[table[:, FRAME] >= first])
                if part.overlay is not None:
                    self._board.overlay(replace(part.overlay, object=target.object))

    async def _join(self, need: StretchNeed, target: DrawnTarget) -> None:
        """Make the rows of a stretch from its passes."""
        forward, backward = (self.results.of_pass(each, target) for each in need[2:])
        cues = cues_of(target)
        task = partial(
            join_stretch, stretch=need.stretch, forward=forward, backward=backward, cues=cues
        )
        self.results.put(need.key, unpack(await self._pool.run(task), cues))

    def _show_finals(self, target: DrawnTarget, plan: list[StretchNeed]) -> None:
        """Show the stretches that are known and not shown."""
        before, now = self._displayed[target.object], set()
        for need, first in own_frames(plan):
            final = self.results.get(need.key, target)
            if final is None:
                self._board.outdate(target.object, first, need.stretch.last)
                continue
            now.add(need.key)
            if need.key in before:
                continue
            table = final.copy()
            seen = self.results.of_pass(need.forward or need.backward, target)
            if seen is not None:
                table[:, DISTANCE : SIZE + 1] = seen[:, DISTANCE : SIZE + 1]
                table[:, MILLISECONDS:] = seen[:, MILLISECONDS:]
            self._board.show(target.object, table[first - need.stretch.first :])
        self._displayed[target.object] = now
