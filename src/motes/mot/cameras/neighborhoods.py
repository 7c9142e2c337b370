"""The graph of doors: which cameras are neighbors, and how a rig falls into groups.

Two cameras are neighbors if a passage or an overlap joins them. Identities move between neighbors
alone, so cameras of two connected components need to know nothing of each other.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping

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


def connected(rig: Rig) -> list[Rig]:
    """Return the connected components of the graph, each with its cameras in the order of the rig.

    Passages and overlaps are those between the cameras of the component.
    """
    return [_limited(rig, names) for names in _components(neighbors_of(rig))]


def _limited(rig: Rig, names: set[str]) -> Rig:
    """Return a component of a rig: either both ends of a passage are in it or none."""
    return Rig(
        tuple(camera for camera in rig.camera if camera.name in names),
        tuple(each for each in rig.passage if each.between[0].rpartition("/")[0] in names),
        tuple(each for each in rig.overlap if each.cameras[0] in names),
    )


def _components(near: Mapping[str, Iterable[str]]) -> list[set[str]]:
    """Return the connected components of a graph, in its order."""
    found, left = [], dict.fromkeys(near)
    while left:
        start = next(iter(left))
        reached, waiting = {start}, [start]
        while waiting:
            for name in near[waiting.pop()]:
                if name not in reached:
                    reached.add(name)
                    waiting.append(name)
        found.append(reached)
        for name in reached:
            del left[name]
    return found
