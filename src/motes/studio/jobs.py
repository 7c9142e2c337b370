"""The jobs of a session: which passes run, which rows are shown, and how far all is."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from functools import partial

import numpy as np
from msgspec.structs import replace

from motes.core.errors import MotesError
from motes.studio.document import Document, DrawnTarget
from motes.studio.job import Desk, StudioJob
from motes.studio.messages import JobStatus, Overlay
from motes.studio.plan import PassNeed, StretchNeed, needs, own_frames
from motes.studio.pool import LONG
from motes.studio.processes import Wish
from motes.studio.results import Results, cues_of
from motes.studio.tables import (
    CUES,
    DISTANCE,
    FINAL,
    FRAME,
    MILLISECONDS,
    SIZE,
    Table,
    unpack,
)
from motes.studio.tracking import join_stretch, run_passes
from motes.studio.workplace import PAUSE, RUN, STOP, Part
from motes.video.shared import fits

SHORT = 0
"""The length of a task that does not track: it comes first."""


class _Run:
    """Passes that run, or wait for a worker; a run that is stopped keeps what it has made."""

    def __init__(self, needs: list[PassNeed]) -> None:
        self.needs = needs
        self.wanted = {need.key: need.frames for need in needs}
        self.wish = Wish()
        self.task: asyncio.Task[None] | None = None


class Jobs:
    """Tracks the objects of a session, and keeps their rows."""

    def __init__(self, desk: Desk) -> None:
        self.results = Results(desk.session, desk.store)
        self._pool, self._film = desk.pool, desk.film
        self._numbers, self._audience = desk.numbers, desk.audience
        self._plans: dict[int, tuple[DrawnTarget, list[StretchNeed]]] = {}
        self._shown: dict[int, Table] = {}
        self._displayed: dict[int, set[str]] = {}
        self._users: dict[str, list[tuple[DrawnTarget, StretchNeed, int]]] = {}
        self._runs: dict[str, _Run] = {}
        self._joins: dict[str, asyncio.Task[None]] = {}
        self.jobs: dict[int, StudioJob] = {}

    # What others ask for.

    def track(self, objects: Iterable[int]) -> StudioJob:
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
        job = StudioJob(next(self._numbers), wanted)
        self.jobs[job.number] = job
        self._forget_old()
        self._reconcile()
        return job

    def pause(self, job: StudioJob) -> None:
        """Let a job wait."""
        if job.status in ("waiting", "running"):
            job.status = "paused"
            self._reconcile()

    def resume(self, job: StudioJob) -> None:
        """Let a job go on."""
        if job.status == "paused":
            job.status = "running"
            self._reconcile()

    def stop(self, job: StudioJob, status: JobStatus = "stopped", error: str | None = None) -> None:
        """End a job; the rows so far stay."""
        if job.active:
            job.status, job.error = status, error
            self._reconcile()
            self._audience.progress(job.progress())

    def update(self, document: Document) -> None:
        """Take a changed document: rows that are void go, and rows that are known come."""
        numbers = {each.object for each in document.targets}
        for number in [each for each in self._plans if each not in numbers]:
            del self._plans[number]
            self._shown.pop(number, None)
            self._displayed.pop(number, None)
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

    def complete(self, number: int) -> bool:
        """Return whether all stretches of an object are tracked."""
        target, plan = self._plans[number]
        return all(self.results.of_stretch(need.key, target) is not None for need in plan)

    def _reconcile(self) -> None:
        """Show what is known, start what is missing, and stop what is not needed any more."""
        wanted: dict[str, PassNeed] = {}
        groups: list[list[PassNeed]] = []
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
                if self.results.of_stretch(need.key, target) is not None:
                    continue
                missing = [
                    each for each in need.passes if self.results.have(each, target) < each.frames
                ]
                groups += [missing] if self._share(need) else [[each] for each in missing]
                for each in missing:
                    if each.key not in wanted or wanted[each.key].frames < each.frames:
                        wanted[each.key] = each
                    waits = job.status == "paused"
                    paused[each.key] = paused.get(each.key, True) and waits
                if not missing and need.key not in self._joins:
                    self._joins[need.key] = asyncio.create_task(self._join(target, need))
        for run in {*self._runs.values()}:
            left = [key for key in run.wanted if key in wanted]
            if not left:
                run.wish.set(STOP)
                continue
            run.wanted |= {key: wanted[key].frames for key in left}
            run.wish.set(PAUSE if all(paused[key] for key in left) else RUN)
        for group in groups:
            new = {each.key: wanted[each.key] for each in group if not paused[each.key]}
            begun = [need for key, need in new.items() if key not in self._runs]
            if begun:
                self._begin(begun)
        self.results.keep({*used, *self._runs})
        self._count()

    def _share(self, need: StretchNeed) -> bool:
        """Return whether the passes over a stretch run together, and share what is decoded."""
        frames = need.stretch.last - need.stretch.first + 1
        return frames < LONG and fits(frames, self._film.width, self._film.height)

    def _job_of(self, number: int) -> StudioJob | None:
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
                    if self.results.of_stretch(need.key, target) is not None:
                        continue
                    joins += 1
                    for each in need.passes:
                        more = each.frames - self.results.have(each, target)
                        left[each.key] = max(left.get(each.key, 0), more)
            job.left = sum(left.values())
            if not joins:
                job.status = "done"
            elif job.status == "waiting":
                job.status = "running"
            self._audience.progress(job.progress())

    def _begin(self, needs: list[PassNeed]) -> None:
        run = _Run(needs)
        for need in needs:
            self.results.begin_pass(need.key)
            self._runs[need.key] = run
        run.task = asyncio.create_task(self._run(run))

    def _forget(self, run: _Run) -> None:
        for need in run.needs:
            if self._runs.get(need.key) is run:
                del self._runs[need.key]

    async def _run(self, run: _Run) -> None:
        """Make passes."""
        error = None
        try:
            async with self._pool.worker(sum(run.wanted.values())) as worker:
                task = partial(run_passes, passes=[need.task for need in run.needs])
                await worker.run(task, lambda part: self._part(run, part), run.wish)
        except MotesError as failed:  # also of the store, as on a full disk
            error = str(failed)
        finally:
            self._forget(run)
        if error is not None:
            for need in run.needs:
                self._fail(need.key, error)
        self._reconcile()

    def _fail(self, key: str, error: str) -> None:
        for number, (_, plan) in self._plans.items():
            keys = {each.key for need in plan for each in need.passes} | {n.key for n in plan}
            job = self._job_of(number)
            if key in keys and job is not None:
                self.stop(job, "failed", error)

    def _part(self, run: _Run, part: Part) -> None:
        """Take rows of a pass."""
        pass_need = run.needs[part.run]
        key = pass_need.key
        objects = self._users.get(key, [])
        if not objects:
            return
        target = objects[0][0]
        table = unpack(part.data, cues_of(target))
        before = self.results.have(pass_need, target)
        self.results.add_to_pass(key, part.data, table)
        if before + len(table) >= run.wanted[key] < pass_need.frames:
            run.wish.set(STOP)
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

    async def _join(self, target: DrawnTarget, need: StretchNeed) -> None:
        """Make the rows of a stretch from its passes."""
        forward, backward = (self.results.over(target, need, each) for each in need[2:])
        task = partial(
            join_stretch,
            stretch=need.stretch,
            forward=forward,
            backward=backward,
            cues=cues_of(target),
        )
        try:
            async with self._pool.worker(SHORT) as worker:
                done = await worker.run(task)
            self.results.set_stretch(need.key, done.data, target)
        except MotesError as error:  # also of the store, as on a full disk
            del self._joins[need.key]
            self._fail(need.key, str(error))
            return
        del self._joins[need.key]
        self._reconcile()

    def _show_finals(self, target: DrawnTarget, plan: list[StretchNeed]) -> None:
        """Show the stretches that are known and not shown."""
        before = self._displayed.get(target.object, set())
        now = set()
        for need, first in own_frames(plan):
            final = self.results.of_stretch(need.key, target)
            if final is None:
                self._outdate(target.object, first, need.stretch.last)
                continue
            now.add(need.key)
            if need.key in before:
                continue
            table = final[first - need.stretch.first :].copy()
            seen = self.results.over(target, need, need.forward or need.backward)
            if seen is not None and len(seen) == len(final):
                seen = seen[first - need.stretch.first :]
                table[:, DISTANCE : SIZE + 1] = seen[:, DISTANCE : SIZE + 1]
                table[:, MILLISECONDS:] = seen[:, MILLISECONDS:]
            self._show(target, table)
        self._displayed[target.object] = now

    def _outdate(self, number: int, first: int, last: int) -> None:
        """Mark rows as no result any more; they stay until there are better ones."""
        shown = self._shown.get(number)
        if shown is not None:
            old = first + np.flatnonzero(shown[first : last + 1, FINAL] == 1)
            shown[old, FINAL] = 0
            self._audience.rows(number, old.tolist())

    def _show(self, target: DrawnTarget, table: Table) -> None:
        shown = self._shown.get(target.object)
        if shown is None:
            shown = np.full((self._film.frames, CUES + cues_of(target)), np.nan)
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
