"""A rig whose cameras are watched by the nodes of a cluster of Ray."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import msgspec
from msgspec.structs import replace

from motes.cluster.camera_actor import OPEN
from motes.cluster.camera_actors import SHARE, CameraActors, reason
from motes.cluster.handover_actor import HandoverActor
from motes.cluster.rig_messages import Associated, Batch, GroupEnded, GroupNews, Restart
from motes.cluster.rig_streams import GroupStream, Numbers
from motes.core.errors import ConfigError, MotesError
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import CameraEnded, CameraMessage
from motes.mot.cameras.neighborhoods import connected
from motes.mot.cameras.rig_config import Camera, Rig
from motes.sot.known_target import KnownTarget
from motes.video.sources import is_recorded

HANDOVER = "handover"
"""The resource of the nodes on which reports meet; without such nodes, they meet where the program
runs, which then has one node on which it depends."""
LISTEN = 1.0
"""Seconds for which the program waits for news before it looks for signals."""
TRIES = 3
"""How often an actor that ends before it has got anywhere is started again."""


class Handover:
    """What all groups of cameras have handed over and merged; see `CrossCameraAssociation`."""

    def __init__(self) -> None:
        self.handed, self.merged = 0, dict[int, int]()


class ClusterRig:
    """Watches the cameras of a rig on a cluster: used like a `RigRunner`.

    Each camera has an actor, and so has each connected group of cameras: there, reports meet. The
    rows of recordings are those of a `RigRunner`.

    Parameters
    ----------
    ray
        The module, connected.
    rig, seed, target
        As for `RigRunner`.

    Raises
    ------
    ConfigError
        If no node reaches a camera.
    """

    def __init__(
        self, ray: Any, rig: Rig, seed: int = 0, target: KnownTarget | None = None
    ) -> None:
        self._ray = ray
        check_nodes(rig, ray.nodes())
        rig = replace(rig, camera=tuple(map(found_from_here, rig.camera)))
        self._order = {camera.name: n for n, camera in enumerate(rig.camera)}
        recorded = {camera.name for camera in rig.camera if is_recorded(camera.source)}
        groups = connected(rig)
        names = [[camera.name for camera in group.camera] for group in groups]
        self.handover = Handover()
        self._streams = [GroupStream(not recorded.isdisjoint(group)) for group in names]
        self._numbers = None if target is not None else Numbers(len(groups))
        known, where = target is not None, place(ray)
        self._actors = [
            ray.remote(HandoverActor)
            .options(
                num_cpus=0,
                max_restarts=-1,
                max_task_retries=-1,
                max_concurrency=2 * (len(group.camera) * (OPEN + 2) + 1),
                **where,
            )
            .remote(group, known_target=known)
            for group in groups
        ]
        self._first = [group[0] for group in names]
        handovers = {name: self._actors[n] for n, group in enumerate(names) for name in group}
        self._cameras = CameraActors(ray, rig, handovers, seed, time.time(), target)

    def __iter__(
        self,
    ) -> Iterator[tuple[CameraReport, Mapping[int, int]] | CameraMessage | CameraEnded]:
        calls: dict[Any, int] = {self._start(group): group for group in range(len(self._actors))}
        while not all(stream.over for stream in self._streams):
            for group, stream in enumerate(self._streams):
                if stream.has_room and group not in calls.values():
                    calls[self._actors[group].take.remote(stream.count)] = group
            for call in self._ray.wait([*calls], timeout=LISTEN)[0]:
                group = calls.pop(call)
                if (data := self._answer(call)) is None:
                    text = "contact with the handover actor was lost; it goes on where it was."
                    yield CameraMessage(self._first[group], text)
                    calls[self._start(group)] = group
                else:
                    self._hold(group, msgspec.msgpack.decode(data, type=Batch))
            yield from self._cameras.look()
            yield from self._ready()

    def _start(self, group: int) -> Any:
        """Give a handover actor its state; return the call, which has its first batch."""
        stream = self._streams[group]
        start = self._actors[group].start.options(max_task_retries=TRIES)
        return start.remote(stream.count, stream.state, stream.entries)

    def _answer(self, call: Any) -> bytes | None:
        """Return a batch, or None if a handover actor has lost its state."""
        lost = self._ray.exceptions
        try:
            return self._ray.get(call)  # type: ignore[no-any-return]
        except (lost.ActorUnavailableError, lost.ObjectLostError):
            return None
        except lost.RayError as error:
            raise MotesError(f"A handover actor is lost: {reason(error)}.") from None

    def _hold(self, group: int, batch: Batch) -> None:
        """Keep a batch; its news are used by and by, but a camera is started as soon as it may."""
        stream = self._streams[group]
        stream.hold(batch)
        for news in batch.news:
            if isinstance(news, Restart):
                self._cameras.start_after(news.pause, news.camera, news.life)
            else:
                stream.news.append(news)

    def _ready(
        self,
    ) -> Iterator[tuple[CameraReport, Mapping[int, int]] | CameraMessage | CameraEnded]:
        """Yield what may be used: live news as they come, recordings in the order of time."""
        while True:
            heads = []
            for n, stream in enumerate(self._streams):
                while stream.news and (head := stream.pop_urgent()) is not None:
                    yield from self._use(n, head)
                if stream.news:
                    report = stream.news[0].report
                    heads.append((report.time, self._order[report.camera], n))
            if any(each.blocks for each in self._streams) or not heads:
                return
            n = min(heads)[2]
            yield from self._use(n, self._streams[n].news.popleft())

    def _use(
        self, group: int, news: GroupNews
    ) -> Iterator[tuple[CameraReport, Mapping[int, int]] | CameraMessage | CameraEnded]:
        if isinstance(news, Associated):
            identities = news.identities
            if self._numbers is not None:
                identities = self._numbers.of(group, news)
            yield news.report, identities
        elif isinstance(news, GroupEnded):
            self._streams[group].over = True
            self.handover.handed += news.handed
            merged = news.merged
            if self._numbers is not None:
                merged = self._numbers.named(group, merged)
            self.handover.merged |= merged
        else:
            yield news

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._cameras.close()
        for actor in self._actors:
            self._ray.kill(actor)


def place(ray: Any) -> dict[str, Any]:
    """Return the options of Ray that say where handover actors run; see `HANDOVER`."""
    if HANDOVER in ray.cluster_resources():
        return {"resources": {HANDOVER: SHARE}, "scheduling_strategy": "SPREAD"}
    from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

    here = ray.get_runtime_context().get_node_id()
    return {"scheduling_strategy": NodeAffinitySchedulingStrategy(here, soft=False)}


def check_nodes(rig: Rig, nodes: Sequence[Mapping[str, Any]]) -> None:
    """Check that each camera has a node that reaches it; raise a ConfigError otherwise."""
    known = {name for node in nodes if node["Alive"] for name in node["Resources"]}
    for camera in rig.camera:
        if camera.node is not None and camera.node not in known:
            start = f"""ray start ... --resources '{{"{camera.node}": 1}}'"""
            raise ConfigError(
                f"Camera {camera.name!r} needs a node with {camera.node!r}, and the cluster has "
                f"none; start one: {start}"
            )


def found_from_here(camera: Camera) -> Camera:
    """Return a camera whose files have whole paths: workers have other current folders."""
    source, detector = camera.source, camera.detector
    if is_recorded(source):
        source = str(Path(source).absolute())
    if detector is not None and Path(detector).exists():
        detector = str(Path(detector).absolute())
    return replace(camera, source=source, detector=detector)
