"""The jobs of a session: which passes run, which rows are shown, and how far all is."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterable, Iterator
from typing import Literal, Protocol

import numpy as np
from msgspec.structs import replace

from motes.studio.document import Document, Target
from motes.studio.plan import PassNeed, StretchNeed, absences, needs, own_frames
from motes.studio.pool import Pool
from motes.studio.processes import Worker, WorkerError
from motes.studio.protocol import JobStatus, Overlay, Progress
from motes.studio.store import Store
from motes.studio.tables import CUES, DISTANCE, FINAL, FRAME, SIZE, Table, pack, unpack
from motes.studio.tasks import PAUSE, RUN, STOP, JoinStretch, Part

SHORT = 0
"""The length of a task that does not track: it comes first."""


class Audience(Protocol):
    """Those that see what happens."""

    def rows(self, number: int, frames: Iterable[int]) -> None:
        """Note that rows of an object have changed."""

    def reset(self, number: int) -> None:
        """Note that all rows of an object are void."""

    def overlay(self, overlay: Overlay) -> None:
        """Take what a tracker sees in a frame."""

    def progress(self, progress: Progress) -> None:
        """Take the state of a job."""

    def scene(self, *, reset: bool = False) -> None:
        """Note that many-object mode has more; with `reset`, earlier parts are void."""


class Job:
    """Objects that are tracked together, or a run of the many-object mode."""

    def __init__(
        self,
        number: int,
        objects: Iterable[int],
        *,
        kind: Literal["track", "watch"] = "track",
        left: int = 0,
    ) -> None:
        self.number, self.objects, self._kind = number, [*objects], kind
        self.status: JobStatus = "waiting"
        self.error: str | None = None
        self.done, self.left = 0, left
        self._since = time.monotonic()

    @property
    def active(self) -> bool:
        """Whether it has not ended."""
        return self.status in ("waiting", "running", "paused")

    def progress(self) -> Progress:
        """Return its state."""
        seconds = time.monotonic() - self._since
        rate = self.done / seconds if self.done and seconds > 0 else None
        left = self.left / rate if rate and self.active else None
        return Progress(
            self.number, self._kind, self.objects, self.done, self.done + self.left, rate, left,
            self.status, self.error,
        )  # fmt: skip


class _Run:
    """A pass that runs or waits for a worker."""

    def __init__(self, need: PassNeed) -> None:
        self.need, self.frames = need, need.frames
        self.worker: Worker | None = None
        self.task: asyncio.Task[None] | None = None


class Jobs:
    """Tracks the objects of a session, and keeps their rows.

    Parameters
    ----------
    session
        Its name in the store.
    store
        Where rows are kept.
    pool
        The workers.
    frames
        Number of frames of the film.
    numbers
        Of jobs.
    audience
        Those that see what happens.
    """

    def __init__(
        self,
        session: str,
        store: Store,
        pool: Pool,
        frames: int,
        numbers: Iterator[int],
        audience: Audience,
    ) -> None:
        self._numbers = numbers
        self._session, self._store, self._pool = session, store, pool
        self._frames, self._audience = frames, audience
        self._document = Document()
        self._plans: dict[int, tuple[Target, list[StretchNeed]]] = {}
        self._parts: dict[str, list[Table]] = {}
        self._finals: dict[str, Table] = {}
        self._shown: dict[int, Table] = {}
        self._displayed: dict[int, set[str]] = {}
        self._users: dict[str, list[tuple[Target, StretchNeed, int]]] = {}
        self._runs: dict[str, _Run] = {}
        self._joins: dict[str, asyncio.Task[None]] = {}
        self.jobs: dict[int, Job] = {}

    # What others ask for.

    def track(self, objects: Iterable[int]) -> Job:
        """Track objects, or go on; return their job."""
        wanted = [*dict.fromkeys(objects)]
        for job in self.jobs.values():
            if job.active and set(wanted) <= set(job.objects):
                if job.status == "paused":
                    self.resume(job)
                self._reconcile()
                return job
        for job in self.jobs.values():
            if job.active:
                job.objects = [each for each in job.objects if each not in wanted]
        job = Job(next(self._numbers), wanted)
        self.jobs[job.number] = job
        self._forget_old()
        self._reconcile()
        return job

    def pause(self, job: Job) -> None:
        """Let a job wait."""
        if job.status in ("waiting", "running"):
            job.status = "paused"
            self._reconcile()

    def resume(self, job: Job) -> None:
        """Let a job go on."""
        if job.status == "paused":
            job.status = "running"
            self._reconcile()

    def stop(self, job: Job, status: JobStatus = "stopped", error: str | None = None) -> None:
        """End a job; the rows so far stay."""
        if job.active:
            job.status, job.error = status, error
            self._reconcile()
            self._audience.progress(job.progress())

    def update(self, document: Document) -> None:
        """Take a changed document: rows that are void go, and rows that are known come."""
        self._document = document
        numbers = {each.object for each in document.targets}
        for number in [each for each in self._shown if each not in numbers]:
            del self._shown[number]
            self._displayed.pop(number, None)
            self._plans.pop(number, None)
        for job in self.jobs.values():
            if job.active:
                job.objects = [each for each in job.objects if each in numbers]
        for target in document.all():
            old = self._plans.get(target.object)
            if old is None or old[0] != target:
                self._plans[target.object] = target, needs(target)
            if old is not None and (old[0].tracker, old[0].seed) != (target.tracker, target.seed):
                self.void(target.object)
        self._reconcile()

    def void(self, number: int) -> None:
        """Forget what is shown of an object."""
        self._shown.pop(number, None)
        self._displayed.pop(number, None)
        self._audience.reset(number)

    def shown(self, number: int) -> Table | None:
        """Return the rows that are shown: one for each frame of the film, NaN where none is."""
        return self._shown.get(number)

    def final(self, target: Target) -> Table | None:
        """Return the rows of all frames of an object; None unless it is tracked completely."""
        tables = []
        for need, first in own_frames(needs(target)):
            table = self._final(need.key, target)
            if table is None:
                return None
            tables.append(table[first - need.stretch.first :])
        return np.concatenate(tables)

    def know(self, target: Target, table: Table) -> None:
        """Take the rows of all frames of an object, which need not be tracked then."""
        for need in needs(target):
            first, last = (frame - target.first for frame in need.stretch[:2])
            self._store.forget(self._session, need.key)
            self._store.add_part(self._session, need.key, pack(table[first : last + 1]))

    def complete(self, number: int) -> bool:
        """Return whether all stretches of an object are tracked."""
        target, plan = self._plans[number]
        return all(self._final(need.key, target) is not None for need in plan)

    # How it is done.

    def _cues(self, target: Target) -> int:
        return len(target.tracker.cues)

    def _final(self, key: str, target: Target) -> Table | None:
        if key not in self._finals:
            data = self._store.parts(self._session, key)
            if not data:
                return None
            self._finals[key] = unpack(data, self._cues(target))
        return self._finals[key]

    def _made(self, need: PassNeed, target: Target) -> Table:
        """Return the rows of a pass so far, in order of the pass."""
        cues = self._cues(target)
        if need.key not in self._parts:
            data = self._store.parts(self._session, need.key)
            self._parts[need.key] = [unpack(data, cues)]
        parts = self._parts[need.key]
        if len(parts) != 1:
            parts[:] = [np.concatenate(parts) if parts else np.empty((0, CUES + cues))]
        return parts[0]

    def _have(self, need: PassNeed, target: Target) -> int:
        if need.key not in self._parts:
            self._made(need, target)
        return sum(map(len, self._parts[need.key]))

    def _reconcile(self) -> None:
        """Show what is known, start what is missing, and stop what is not needed any more."""
        wanted: dict[str, PassNeed] = {}
        paused: dict[str, bool] = {}
        used: set[str] = set()
        self._users.clear()
        for number, (target, plan) in self._plans.items():
            for need, first in own_frames(plan):
                used.update((need.key, *(each.key for each in need.passes)))
                for each in need.passes:
                    self._users.setdefault(each.key, []).append((target, need, first))
            self._show_finals(target, plan)
            job = self._job_of(number)
            if job is None:
                continue
            for need in plan:
                if self._final(need.key, target) is not None:
                    continue
                missing = [each for each in need.passes if self._have(each, target) < each.frames]
                for each in missing:
                    if each.key not in wanted or wanted[each.key].frames < each.frames:
                        wanted[each.key] = each
                    waits = job.status == "paused"
                    paused[each.key] = paused.get(each.key, True) and waits
                if not missing and need.key not in self._joins:
                    self._joins[need.key] = asyncio.create_task(self._join(target, need))
        for key, run in [*self._runs.items()]:
            if key not in wanted:
                self._end(run)
            else:
                run.frames = wanted[key].frames
                if run.worker is not None:
                    run.worker.wish(PAUSE if paused[key] else RUN)
        for key, pass_need in wanted.items():
            if key not in self._runs and not paused[key]:
                self._begin(pass_need)
        self._drop_unused(used)
        self._count()

    def _drop_unused(self, used: set[str]) -> None:
        """Keep in memory only what the document needs; all else is on disk."""
        for key in [*self._parts]:
            if key not in used and key not in self._runs:
                del self._parts[key]
        for key in [*self._finals]:
            if key not in used:
                del self._finals[key]

    def _job_of(self, number: int) -> Job | None:
        for job in self.jobs.values():
            if job.active and number in job.objects:
                return job
        return None

    def _count(self) -> None:
        """Count the frames that are left of each job; a job without any is done."""
        for job in self.jobs.values():
            if not job.active:
                continue
            left: dict[str, int] = {}
            joins = 0
            for number in job.objects:
                target, plan = self._plans[number]
                for need in plan:
                    if self._final(need.key, target) is not None:
                        continue
                    joins += 1
                    for each in need.passes:
                        more = each.frames - self._have(each, target)
                        left[each.key] = max(left.get(each.key, 0), more)
            job.left = sum(left.values())
            if not joins:
                job.status = "done"
            elif job.status == "waiting":
                job.status = "running"
            self._audience.progress(job.progress())

    def _begin(self, need: PassNeed) -> None:
        self._parts[need.key] = []  # a pass that was stopped begins anew
        self._store.forget(self._session, need.key)
        run = _Run(need)
        self._runs[need.key] = run
        run.task = asyncio.create_task(self._run(run))

    def _end(self, run: _Run) -> None:
        """Stop a run; what it has made stays."""
        if run.worker is not None:
            run.worker.wish(STOP)
        elif run.task is not None:
            run.task.cancel()
            self._runs.pop(run.need.key, None)

    async def _run(self, run: _Run) -> None:
        """Make a pass."""
        error = None
        try:
            async with self._pool.worker(run.frames) as worker:
                run.worker = worker
                await worker.run(run.need.task, lambda part: self._part(run, part))
        except WorkerError as failed:
            error = str(failed)
        finally:
            if self._runs.get(run.need.key) is run:
                del self._runs[run.need.key]
        if error is not None:
            self._fail(run.need.key, error)
        self._reconcile()

    def _fail(self, key: str, error: str) -> None:
        for number, (_, plan) in self._plans.items():
            keys = {each.key for need in plan for each in need.passes} | {n.key for n in plan}
            job = self._job_of(number)
            if key in keys and job is not None:
                self.stop(job, "failed", error)

    def _part(self, run: _Run, part: Part) -> None:
        """Take rows of a pass."""
        key = run.need.key
        objects = self._users.get(key, [])
        if not objects:
            return
        target = objects[0][0]
        table = unpack(part.data, self._cues(target))
        before = self._have(run.need, target)
        self._parts[key].append(table)
        self._store.add_part(self._session, key, part.data)
        if before + len(table) >= run.frames and run.frames < run.need.frames:
            self._end(run)
        for target, need, first in objects:
            job = self._job_of(target.object)
            if job is None:
                continue
            job.done += len(table)
            job.left = max(job.left - len(table), 0)
            self._audience.progress(job.progress())
            if need.forward is None or need.forward.key == key:
                frames = table[:, FRAME]
                inside = (frames >= first) & (frames <= need.stretch.last)
                self._show(target, table[inside])
                if part.overlay is not None:
                    self._audience.overlay(_named(part.overlay, target.object))

    async def _join(self, target: Target, need: StretchNeed) -> None:
        """Make the rows of a stretch from its passes."""
        begin, end = (
            None if each is None else tuple(each) for each in (need.stretch.begin, need.stretch.end)
        )
        forward, backward = (self._over(target, need, each) for each in need[2:])
        task = JoinStretch(
            need.stretch.first, need.stretch.last, begin, end, absences(need.stretch),
            None if forward is None else pack(forward),
            None if backward is None else pack(backward), self._cues(target),
        )  # fmt: skip
        try:
            async with self._pool.worker(SHORT) as worker:
                done = await worker.run(task)
        except WorkerError as error:
            del self._joins[need.key]
            self._fail(need.key, str(error))
            return
        self._store.forget(self._session, need.key)
        self._store.add_part(self._session, need.key, done.data)
        self._finals[need.key] = unpack(done.data, self._cues(target))
        del self._joins[need.key]
        self._reconcile()

    def _over(self, target: Target, need: StretchNeed, each: PassNeed | None) -> Table | None:
        """Return the rows of a pass over a stretch, in order of the frames."""
        if each is None:
            return None
        table = self._made(each, target)[: each.frames]
        return table[::-1] if each is need.backward else table

    def _show_finals(self, target: Target, plan: list[StretchNeed]) -> None:
        """Show the stretches that are known and not shown."""
        before = self._displayed.get(target.object, set())
        now = set()
        for need, first in own_frames(plan):
            final = self._final(need.key, target)
            if final is None:
                self._outdate(target.object, first, need.stretch.last)
                continue
            now.add(need.key)
            if need.key in before:
                continue
            table = final[first - need.stretch.first :].copy()
            seen = self._over(target, need, need.forward or need.backward)
            if seen is not None and len(seen) == len(final):
                seen = seen[first - need.stretch.first :]
                table[:, DISTANCE : SIZE + 1] = seen[:, DISTANCE : SIZE + 1]
                table[:, CUES:] = seen[:, CUES:]
            self._show(target, table)
        self._displayed[target.object] = now

    def _outdate(self, number: int, first: int, last: int) -> None:
        """Mark rows as no result any more; they stay until there are better ones."""
        shown = self._shown.get(number)
        if shown is not None:
            old = first + np.flatnonzero(shown[first : last + 1, FINAL] == 1)
            shown[old, FINAL] = 0
            self._audience.rows(number, old.tolist())

    def _show(self, target: Target, table: Table) -> None:
        shown = self._shown.get(target.object)
        if shown is None:
            shown = np.full((self._frames, CUES + self._cues(target)), np.nan)
            self._shown[target.object] = shown
        frames = table[:, FRAME].astype(int)
        shown[frames] = table
        self._audience.rows(target.object, frames.tolist())

    def _forget_old(self) -> None:
        """Keep only the last jobs that have ended."""
        ended = [number for number, job in self.jobs.items() if not job.active]
        for number in ended[:-KEPT]:
            del self.jobs[number]

    def close(self) -> None:
        """Stop all."""
        for run in [*self._runs.values()]:
            if run.task is not None:
                run.task.cancel()
        for join in self._joins.values():
            join.cancel()


KEPT = 20
"""Jobs that have ended and are still listed."""


def _named(overlay: Overlay, number: int) -> Overlay:
    return replace(overlay, object=number)
