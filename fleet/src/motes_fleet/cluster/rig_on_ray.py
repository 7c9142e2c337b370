"""A rig whose cameras are watched by the nodes of a cluster of Ray."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from motes import ConfigError, KnownTarget
from motes.video import is_recorded
from motes_fleet.cameras.rig import RigRunner
from motes_fleet.cameras.rig_config import Camera, Rig
from motes_fleet.cluster.camera_actor import ClusterCamera


def cluster_rig(ray: Any, rig: Rig, seed: int = 0, target: KnownTarget | None = None) -> RigRunner:
    """Return what watches the cameras of a rig on a cluster, with an actor for each camera.

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
    check_nodes(rig, ray.nodes())
    rig = replace(rig, camera=tuple(map(found_from_here, rig.camera)))
    return RigRunner(rig, seed, target, partial(ClusterCamera, ray))


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
