"""A rig whose cameras are watched by the nodes of a cluster of Ray."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import msgspec
from msgspec.structs import replace

from motes.cluster.camera_actor import OPEN
from motes.cluster.handover_actor import ROOM, HandoverActor
from motes.cluster.remote_camera import SHARE, reason
from motes.cluster.rig_messages import Associated, PartEnded, PartNews
from motes.core.errors import ConfigError, MotesError
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import CameraEnded, CameraMessage
from motes.mot.cameras.neighborhoods import components, parts_of
from motes.mot.cameras.rig_config import Camera, Rig
from motes.sot.known_target import Target
from motes.video.sources import is_recorded

CAMERAS = 40
"""Largest number of live cameras of a handover actor: with 25 frames a second each, they send the
1,000 reports a second that one busy core receives through Ray and tells its neighbors."""
HANDOVER = "handover"
"""The resource of the nodes on which reports meet; without such nodes, they meet where the program
runs, which then has one node on which it depends."""
LISTEN = 1.0
"""Seconds for which the program waits for news before it looks for signals."""


class Handover:
    """What the parts of a rig have handed over and merged; see `CrossCameraAssociation`."""

    def __init__(self) -> None:
        self.handed, self.merged = 0, dict[int, int]()


class ClusterRig:
    """Watches the cameras of a rig on a cluster: used like a `RigRunner`.

    Each neighborhood of cameras has a handover actor. A neighborhood of more than `CAMERAS` live
    cameras has several, which exchange news at their borders. Recordings of a neighborhood stay
    together: they wait for each other anyway, and their rows are those of a `RigRunner`.

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

    def __init__(self, ray: Any, rig: Rig, seed: int = 0, target: Target | None = None) -> None:
        self._ray = ray
        check_nodes(rig, ray.nodes())
        rig = replace(rig, camera=tuple(map(found_from_here, rig.camera)))
        self._order = {camera.name: n for n, camera in enumerate(rig.camera)}
        recorded = {camera.name for camera in rig.camera if is_recorded(camera.source)}
        whole = target is not None or bool(recorded)
        parts = components(rig) if whole else parts_of(rig, CAMERAS)
        self.handover = Handover()
        self._streams = [_Stream(not recorded.isdisjoint(part)) for part in parts]
        self._numbers = None if target is not None else _Numbers(len(parts))
        maker = ray.remote(HandoverActor).options(
            num_cpus=0, max_concurrency=len(rig.camera) * (OPEN + 2) + len(parts), **place(ray)
        )
        known = target is not None
        self._actors = [maker.remote(rig, parts, n, known_target=known) for n in range(len(parts))]
        peers, epoch = dict(enumerate(self._actors)), time.time()
        ray.get([actor.start.remote(peers, seed, epoch, target) for actor in self._actors])

    def __iter__(
        self,
    ) -> Iterator[tuple[CameraReport, Mapping[int, int]] | CameraMessage | CameraEnded]:
        calls: dict[Any, int] = {}
        while not all(stream.over for stream in self._streams):
            for part, stream in enumerate(self._streams):
                if stream.wants_news and part not in calls.values():
                    calls[self._actors[part].take.remote()] = part
            for call in self._ray.wait([*calls], timeout=LISTEN)[0]:
                part = calls.pop(call)
                try:
                    data = self._ray.get(call)
                except self._ray.exceptions.RayError as error:
                    raise MotesError(f"A handover actor is lost: {reason(error)}.") from None
                stream = self._streams[part]
                stream.news += msgspec.msgpack.decode(data, type=list[PartNews])
            yield from self._ready()

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
        self, part: int, news: PartNews
    ) -> Iterator[tuple[CameraReport, Mapping[int, int]] | CameraMessage | CameraEnded]:
        if isinstance(news, Associated):
            identities = news.identities
            if self._numbers is not None and self._streams[part].recorded:
                identities = self._numbers.of(part, news)
            yield news.report, identities
        elif isinstance(news, PartEnded):
            self._streams[part].over = True
            self.handover.handed += news.handed
            merged = news.merged
            if self._numbers is not None and self._streams[part].recorded:
                merged = self._numbers.named(merged)
            self.handover.merged |= merged
        else:
            yield news

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for actor in self._actors:
            self._ray.kill(actor)  # and with it the actors of its cameras


class _Stream:
    """The news of a part that have come."""

    def __init__(self, recorded: bool) -> None:
        self.news: deque[Any] = deque()
        self.recorded, self.over = recorded, False

    @property
    def wants_news(self) -> bool:
        """Whether more may come: recordings that are ahead of others wait with their news."""
        ended = self.over or (bool(self.news) and isinstance(self.news[-1], PartEnded))
        return not ended and len(self.news) <= ROOM

    @property
    def blocks(self) -> bool:
        """Whether others must wait, since an earlier report may come."""
        return self.recorded and not self.over and not self.news

    def pop_urgent(self) -> PartNews | None:
        """Take the first news, unless it is a report of a recording; else return None."""
        first = self.news[0]
        if isinstance(first, Associated) and not first.live:
            return None
        return self.news.popleft()  # type: ignore[no-any-return]


class _Numbers:
    """Numbers the identities of recordings in the order of their births, as one process does.

    Parts count on their own, and their numbers have gaps.
    """

    def __init__(self, step: int) -> None:
        self._step, self._names = step, dict[int, int]()
        self._newest = [n + 1 - step for n in range(step)]

    def of(self, part: int, news: Associated) -> dict[int, int]:
        """Return the identities of a report."""
        for number in range(self._newest[part] + self._step, news.newest + 1, self._step):
            self._names[number] = len(self._names) + 1
        self._newest[part] = max(self._newest[part], news.newest)
        return {own: self._names[number] for own, number in news.identities.items()}

    def named(self, merged: Mapping[int, int]) -> dict[int, int]:
        """Return the numbers of merged identities."""
        return {self._names[gone]: self._names[kept] for gone, kept in merged.items()}


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
