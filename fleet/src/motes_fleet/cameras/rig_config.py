"""The cameras of a rig, and how they are joined: the graph of doors.

Two cameras are neighbors if a passage or an overlap joins them. Identities move between neighbors
alone.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Annotated

from msgspec import Meta

from motes import Config, ConfigError, Ground, Place

Triple = tuple[float, float, float]
Positive = Annotated[float, Meta(gt=0, le=1e9)]
DISTANCE = 0.9
"""Largest distance between the colors of the same object in two views."""
SECONDS = 0.0, 60.0
"""Least and most time of a passage, where none is given."""


class Camera(Config, frozen=True):
    """A camera of a rig."""

    name: str
    """Its name in rows and messages, and before the names of its places: "name/place"."""
    source: str
    """Its video, as for `motes.open_source`."""
    detector: str | None = None
    """The detector, as for `motes watch`."""
    preset: str | None = None
    """The particle filter that follows each object, as for `motes watch`; by default
    `nummiaro:adaptive`, and `nummiaro` where all cameras wait for a known target."""
    offset: float = 0.0
    """Seconds from the start of the rig to the start of a recording."""
    fps: Positive | None = None
    """Frames per second of images, as for `motes.open_source`."""
    place: tuple[Place, ...] = ()
    """Doors and borders through which objects come and go."""


class CameraLink(Config, frozen=True):
    """A way from a place of one camera to a place of another, and back."""

    between: tuple[str, str]
    """The two places, each as "camera/place"."""
    seconds: tuple[Annotated[float, Meta(ge=0, le=1e9)], Positive] = SECONDS
    """Shortest and longest time from the last detection at one place to the first report at the
    other. Which times are usual is learned within it."""
    distance: Annotated[float, Meta(ge=0, le=1)] = DISTANCE
    """Largest distance between the color histograms of the same object."""
    scale: Positive | None = None
    """Height of an object in the second camera, divided by that in the first. By default, heights
    are not compared."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.seconds[0] >= self.seconds[1]:
            raise ConfigError(
                f"seconds: The least time comes first, then a longer one; got {self.seconds}"
            )

    def scale_to(self, camera: str) -> float | None:
        """Return how many times higher an object is in the camera at one end, if known."""
        if self.scale is None:
            return None
        onward = self.between[1].rpartition("/")[0] == camera
        return self.scale if onward else 1 / self.scale


class Overlap(Config, frozen=True):
    """Two cameras that see the same ground."""

    cameras: tuple[str, str]
    """Their names."""
    homography: tuple[Triple, Triple, Triple] | None = None
    """Maps points (x, y, 1) of the ground in the first camera's picture to those in the second
    camera's, up to scale. Without it, the map is learned from objects that both cameras see at the
    same time."""
    reach: Positive = 1.0
    """Largest distance between the feet of the same object in the second camera's picture, in
    widths of the object."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.cameras[0] == self.cameras[1]:
            raise ConfigError(f"An overlap needs two cameras; got {self.cameras[0]!r} twice")
        if self.homography is not None:
            Ground(homography=self.homography)  # refuses one that cannot be inverted


class Rig(Config, frozen=True):
    """Several cameras. In TOML: [[camera]] with [[camera.place]], [[passage]] and [[overlap]]."""

    camera: tuple[Camera, ...]
    """The cameras; at least one."""
    passage: tuple[CameraLink, ...] = ()
    """The ways between places of two cameras."""
    overlap: tuple[Overlap, ...] = ()
    """The pairs of cameras that see the same ground."""

    def __post_init__(self) -> None:
        super().__post_init__()
        names = [camera.name for camera in self.camera]
        places = [f"{camera.name}/{p.name}" for camera in self.camera for p in camera.place]
        if not names:
            raise ConfigError("A rig needs a [[camera]], got none")
        for known, what in ((names, "cameras"), (places, "places")):
            if len(set(known)) < len(known) or not all(each.split("/")[-1] for each in known):
                raise ConfigError(
                    f"The {what} of a rig need names, each its own; got {', '.join(known)}"
                )
        for known, used in (
            (places, [end for passage in self.passage for end in passage.between]),
            (names, [name for overlap in self.overlap for name in overlap.cameras]),
        ):
            for name in used:
                if name not in known:
                    raise ConfigError(
                        f"A passage or overlap got {name!r}, which is not in this rig; known are "
                        f"{', '.join(known) or 'none'}"
                    )


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
