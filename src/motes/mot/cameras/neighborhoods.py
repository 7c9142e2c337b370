"""The graph of doors: two cameras are neighbors if a passage or an overlap joins them.

Identities move between neighbors alone.
"""

from __future__ import annotations

from collections import defaultdict

from motes.mot.cameras.rig_config import CameraLink, Rig

Way = tuple[CameraLink, str, str]
"""A passage, and its places in the camera that it leaves and in the one that it comes to."""


def ways_of(rig: Rig) -> dict[tuple[str, str], list[Way]]:
    """Return the ways from one camera to another, by the names of the two."""
    ways: defaultdict[tuple[str, str], list[Way]] = defaultdict(list)
    for passage in rig.passage:
        for ends in (passage.between, passage.between[::-1]):
            (first, _, out), (second, _, into) = (each.rpartition("/") for each in ends)
            ways[first, second].append((passage, out, into))
    return dict(ways)


def neighbors_of(rig: Rig) -> dict[str, tuple[str, ...]]:
    """Return the neighbors of each camera, in the order of the rig, by its name."""
    pairs = set(ways_of(rig))
    pairs |= {pair for each in rig.overlap for pair in (each.cameras, each.cameras[::-1])}
    found: dict[str, set[str]] = {camera.name: set() for camera in rig.camera}
    for one, other in pairs:
        if one != other:
            found[one].add(other)
    order = {camera.name: n for n, camera in enumerate(rig.camera)}
    return {name: tuple(sorted(near, key=order.__getitem__)) for name, near in found.items()}
