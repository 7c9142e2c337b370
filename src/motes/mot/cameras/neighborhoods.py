"""The graph of doors: which cameras are neighbors, and how a rig falls into neighborhoods.

Two cameras are neighbors if a passage or an overlap joins them. Identities move between neighbors
alone, so cameras of two connected components need to know nothing of each other.
"""

from __future__ import annotations

from collections import defaultdict, deque
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
    pairs = set(ways_of(rig)) | _overlapping(rig)
    found: dict[str, set[str]] = {camera.name: set() for camera in rig.camera}
    for one, other in pairs:
        if one != other:
            found[one].add(other)
    order = {camera.name: n for n, camera in enumerate(rig.camera)}
    return {name: tuple(sorted(near, key=order.__getitem__)) for name, near in found.items()}


def components(rig: Rig) -> list[tuple[str, ...]]:
    """Return the connected components of the graph, each in the order of the rig."""
    return _components(neighbors_of(rig))


def parts_of(rig: Rig, largest: int) -> list[tuple[str, ...]]:
    """Return the cameras of a rig in parts of at most `largest` cameras, where that is possible.

    Each component is a part, unless it is larger. Then it is cut at passages: cameras that see the
    same ground stay together, even if they are more than `largest`. A part grows from one camera to
    its neighbors, to those first that have the most ways into it, so few ways are cut.

    Raises
    ------
    ValueError
        If `largest` is not positive.
    """
    if largest < 1:
        raise ValueError(f"A part has at least one camera; got largest={largest}")
    near = neighbors_of(rig)
    seen_together = {name: tuple[str, ...]() for name in near}
    for one, other in _overlapping(rig):
        seen_together[one] = (*seen_together[one], other)
    parts = []
    for component in _components(near):
        groups = _components({name: seen_together[name] for name in component})
        parts += _grown(groups, near, largest)
    return parts


def _overlapping(rig: Rig) -> set[tuple[str, str]]:
    """Return the pairs of cameras that see the same ground, both ways round."""
    return {pair for each in rig.overlap for pair in (each.cameras, each.cameras[::-1])}


def _components(near: Mapping[str, Iterable[str]]) -> list[tuple[str, ...]]:
    """Return the connected components of a graph, in its order."""
    order = {name: n for n, name in enumerate(near)}
    found, left = [], dict.fromkeys(near)
    while left:
        start = next(iter(left))
        reached, waiting = {start}, deque([start])
        while waiting:
            for name in near[waiting.popleft()]:
                if name not in reached:
                    reached.add(name)
                    waiting.append(name)
        found.append(tuple(sorted(reached, key=order.__getitem__)))
        for name in reached:
            del left[name]
    return found


def _grown(
    groups: list[tuple[str, ...]], near: Mapping[str, tuple[str, ...]], largest: int
) -> list[tuple[str, ...]]:
    """Return the groups of one component, put together to parts."""
    if sum(map(len, groups)) <= largest:
        return [tuple(name for name in near if name in {each for one in groups for each in one})]
    group_of = {name: n for n, group in enumerate(groups) for name in group}
    left, parts = dict.fromkeys(range(len(groups))), []
    while left:
        part: list[str] = []
        ways: dict[int, int] = {next(iter(left)): 0}
        while ways:
            best = max(ways, key=lambda n: (ways[n], -n))
            del ways[best]
            if part and len(part) + len(groups[best]) > largest:
                continue
            part += groups[best]
            del left[best]
            for name in groups[best]:
                for other in near[name]:
                    if (n := group_of[other]) in left:
                        ways[n] = ways.get(n, 0) + 1
        parts.append(tuple(sorted(part, key=list(near).index)))
    return parts
