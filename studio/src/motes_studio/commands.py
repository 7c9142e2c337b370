"""The commands of the protocol: what a page asks for; see `motes_studio.protocol`."""

from __future__ import annotations

from typing import Annotated, Literal

import msgspec
from msgspec import UNSET, Meta, UnsetType

Region = Annotated[tuple[float, ...], Meta(min_length=4, max_length=5)]
Name = Annotated[str, Meta(max_length=100)]
Color = Annotated[str, Meta(pattern=r"\A#[0-9a-fA-F]{6}\Z")]  # $ would take a line break
Toml = Annotated[str, Meta(max_length=1 << 16)]
"""The text of a configuration file; it takes the place of a preset."""
Number = Annotated[int, Meta(ge=0, le=2**53 - 1)]
"""A frame, an object, a job or a seed."""
Coordinate = Annotated[float, Meta(ge=-1e6, le=1e6)]
"""A place in pixels or metres."""
Few = Annotated[list[Number], Meta(max_length=100)]


class _Command(msgspec.Struct, frozen=True, tag=str.lower, forbid_unknown_fields=True):
    """What the page asks for; `id` is repeated in the reply."""

    id: Number


class AddObject(_Command, frozen=True, tag="add_object"):
    """Add an object that a person has drawn; the drawing is its first keyframe.

    The reply has the number of the object, which also names it where the name is empty.
    """

    name: Name
    color: Color
    frame: Number
    region: Region
    preset: Name = "default"
    config: Toml | None = None
    seed: Number = 0


class ChangeObject(_Command, frozen=True, tag="change_object"):
    """Change what is given of an object; another tracker or seed makes its rows void."""

    object: Number
    name: Name | UnsetType = UNSET
    color: Color | UnsetType = UNSET
    preset: Name | UnsetType = UNSET
    config: Toml | UnsetType | None = UNSET
    seed: Number | UnsetType = UNSET


class RemoveObject(_Command, frozen=True, tag="remove_object"):
    """Remove an object."""

    object: Number


class SetKeyframe(_Command, frozen=True, tag="set_keyframe"):
    """Mark the object in a frame.

    If the object has been tracked, the stretch between the neighboring keyframes is tracked again.
    """

    object: Number
    frame: Number
    region: Region


class RemoveKeyframe(_Command, frozen=True, tag="remove_keyframe"):
    """Remove the mark of a frame: a region or an absence."""

    object: Number
    frame: Number


class SetAbsent(_Command, frozen=True, tag="set_absent"):
    """Mark the object as absent from one frame to another, the last one included."""

    object: Number
    first: Number
    last: Number


class Split(_Command, frozen=True, tag="split"):
    """Make the frames of an object from `frame` on a new object; the reply has its number."""

    object: Number
    frame: Number


class Join(_Command, frozen=True, tag="join"):
    """Add the frames and keyframes of `other` to an object, and remove `other`."""

    object: Number
    other: Number


class TrackCommand(_Command, frozen=True, tag="track"):
    """Track objects between their keyframes; without objects, all. The reply has the job."""

    objects: Few = []


class Stop(_Command, frozen=True, tag="stop"):
    """End a job; the rows so far are kept."""

    job: Number


class Undo(_Command, frozen=True, tag="undo"):
    """Take back the last change."""


class Redo(_Command, frozen=True, tag="redo"):
    """Make the change again that was taken back last."""


class Watch(_Command, frozen=True, tag="watch"):
    """Track all that moves, as `motes watch`. The reply has the job."""

    detector: Literal["background", "people", "faces"] = "background"
    preset: Name = "nummiaro:adaptive"
    config: Toml | None = None
    seed: Number = 0


class DrawnLine(msgspec.Struct, frozen=True):
    """A line whose crossings count: its ends, and its name."""

    points: tuple[Coordinate, Coordinate, Coordinate, Coordinate]
    name: Name = ""
    label: tuple[Name, Name] = ("in", "out")


class DrawnZone(msgspec.Struct, frozen=True):
    """A polygon whose entries and exits count: x and y of its corners, and its name."""

    points: Annotated[tuple[Coordinate, ...], Meta(min_length=6, max_length=100)]
    name: Name = ""
    dwell: Annotated[float, Meta(gt=0)] | None = None


GroundPoints = Annotated[
    tuple[tuple[Coordinate, Coordinate, Coordinate, Coordinate], ...],
    Meta(min_length=4, max_length=100),
]
"""Points of the picture and their places on the ground: x, y in pixels, X, Y in metres."""


class Places(msgspec.Struct, frozen=True):
    """What is drawn on the picture for counting."""

    lines: Annotated[tuple[DrawnLine, ...], Meta(max_length=50)] = ()
    zones: Annotated[tuple[DrawnZone, ...], Meta(max_length=50)] = ()
    ground: GroundPoints | None = None


class SetPlaces(_Command, frozen=True, tag="set_places"):
    """Replace the lines, zones and the ground; they count from the next `Watch` on."""

    places: Places


class Acknowledge(_Command, frozen=True, tag="acknowledge"):
    """An overlay has been drawn: its number. There is no reply.

    A page that does not acknowledge gets no further overlays, but all rows.
    """

    number: Number


Command = (
    AddObject
    | ChangeObject
    | RemoveObject
    | SetKeyframe
    | RemoveKeyframe
    | SetAbsent
    | Split
    | Join
    | TrackCommand
    | Stop
    | Undo
    | Redo
    | Watch
    | SetPlaces
    | Acknowledge
)
"""From the page to the server."""
