"""A handover actor under Ray, with senders that stand for cameras; see `handover.py`."""

from __future__ import annotations

import asyncio
import time
from collections import Counter
from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np

from motes.cluster.handover_actor import HandoverActor
from motes.core.types import Floats
from motes.mot.cameras.messages import CameraEnded, CameraReady
from motes_lab.report.tables import Cell, Row, number
from simulated_cameras import Building, Simulation

SHARED = {"memory_monitor_refresh_ms": 0, "worker_niceness": 0}
"""Settings of Ray for a machine that others use: no process waits for them, or ends for them."""
WINDOW = 64
"""Reports of a sender that are on the way at a time, at full speed."""
SENDERS = 1


class Meeting(HandoverActor):
    """A handover actor that knows what it takes of the processor."""

    async def busy(self) -> float:
        """Return the seconds of the processor that this process has taken."""
        return time.process_time()


class Sender:
    """Sends the reports of some simulated cameras."""

    def __init__(
        self, building: Building, seconds: float, people: float, names: Sequence[str],
        meeting: Any,
    ) -> None:  # fmt: skip
        self._meeting, self._names = meeting, names
        self._numbers: Counter[str] = Counter()
        mine = set(names)
        reports = Simulation(building, seconds, people).reports()
        self._reports = [
            (report.camera, msgspec.msgpack.encode(report))
            for report in reports
            if report.camera in mine
        ]
        self._sent = 0

    async def open(self) -> int:
        """Open the cameras; return the number of reports, and in bytes their mean."""
        for name in self._names:
            await self._call(name, msgspec.msgpack.encode(CameraReady(name, True)))
        return len(self._reports)

    async def send(self, count: int, rate: float | None) -> list[float]:
        """Send some reports, at full speed or at a rate; return the seconds until each answer."""
        begun, taken, running = time.perf_counter(), list[float](), set[asyncio.Task[None]]()

        async def timed(name: str, data: bytes) -> None:
            start = time.perf_counter()
            await self._call(name, data)
            taken.append(time.perf_counter() - start)

        for n, (name, data) in enumerate(self._reports[self._sent : self._sent + count]):
            if rate is not None:
                await asyncio.sleep(max(begun + n / rate - time.perf_counter(), 0))
            elif len(running) >= WINDOW:
                _, running = await asyncio.wait(running, return_when=asyncio.FIRST_COMPLETED)
            running.add(asyncio.ensure_future(timed(name, data)))
            running = {task for task in running if not task.done()} if n % WINDOW == 0 else running
        await asyncio.wait(running)
        self._sent += count
        return taken

    async def close(self) -> None:
        """End the cameras."""
        for name in self._names:
            await self._call(name, msgspec.msgpack.encode(CameraEnded(name, 0)))

    async def _call(self, name: str, data: bytes) -> None:
        number = self._numbers[name]
        self._numbers[name] += 1
        await self._meeting.receive.remote(name, 0, number, data)


def measure(building: Building, people: float) -> Row:
    """Return a row: the rate of reports through Ray, and the latency at half of it."""
    import ray

    ray.init(
        "local",
        num_cpus=2,
        include_dashboard=False,
        logging_level="ERROR",
        _system_config=SHARED,
    )
    try:
        rig = building.rig()
        cameras = [camera.name for camera in rig.camera]
        make = ray.remote(Meeting).options(num_cpus=0, max_concurrency=1000)
        actor = make.remote(rig)
        taking = ray.remote(_take).options(num_cpus=0).remote(actor)
        seconds = max(1.5, 1200 / len(cameras))  # 10 reports of a camera in each
        sending = ray.remote(Sender).options(num_cpus=0, max_concurrency=1000)
        senders = [
            sending.remote(building, seconds, people, cameras[n::SENDERS], actor)
            for n in range(SENDERS)
        ]
        third = min(ray.get([sender.open.remote() for sender in senders])) // 3
        ray.get([sender.send.remote(third, None) for sender in senders])  # imports, connections
        before = ray.get(actor.busy.remote())
        begun = time.perf_counter()
        ray.get([sender.send.remote(third, None) for sender in senders])
        wall = time.perf_counter() - begun
        busy = ray.get(actor.busy.remote()) - before
        total = SENDERS * third
        rate = total / wall
        answers = ray.get([sender.send.remote(third, rate / 2 / SENDERS) for sender in senders])
        latency: Floats = 1e3 * np.concatenate(answers)
        ray.get([sender.close.remote() for sender in senders])
        ray.get(taking)
        rates = (Cell(f"{each:,.0f}") for each in (len(cameras), rate, total / busy))
        half = np.median(latency), np.quantile(latency, 0.99)
        return *rates, *(number(float(each), 1) for each in half)
    finally:
        ray.shutdown()


def _take(actor: Any) -> int:
    """Take all batches, as the program does; return of how many reports."""
    import ray

    from motes.cluster.rig_messages import Associated, Batch, GroupEnded

    over, count, call = False, 0, actor.start.remote(0, None, [])
    while not over:
        batch = msgspec.msgpack.decode(ray.get(call), type=Batch)
        over = any(isinstance(each, GroupEnded) for each in batch.news)
        count += sum(isinstance(each, Associated) for each in batch.news)
        call = actor.take.remote(batch.count)
    return count
