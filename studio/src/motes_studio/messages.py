"""The messages of the protocol: what the server sends; see `motes_studio.protocol`."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from motes_studio.commands import Places, Region


class FilmCard(msgspec.Struct, frozen=True):
    """A film that can be opened: its name for `POST /api/sessions`, and its size in bytes."""

    name: str
    bytes: int
    uploaded: bool = False


class OpenFilm(msgspec.Struct, frozen=True):
    """A film that is open: its name, its size in pixels, its number of frames and its rate.

    `problems` is one line about what could not be read; None if nothing is known to be wrong.
    """

    name: str
    width: int
    height: int
    frames: int
    fps: float
    problems: str | None = None


class Preset(msgspec.Struct, frozen=True):
    """A tracker that can be chosen, in one line."""

    name: str
    summary: str


class Presets(msgspec.Struct, frozen=True):
    """The trackers of one object, and those of the many-object mode."""

    track: list[Preset]
    watch: list[Preset]


class Open(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The body of `POST /api/sessions`: a film's name, and whether it is an upload.

    The session of the film that changed last is opened; with `anew`, another one is made.
    """

    film: Annotated[str, Meta(max_length=1000)]
    uploaded: bool = False
    anew: bool = False


class SessionCard(msgspec.Struct, frozen=True):
    """A session in the list: its film, and when it changed last (UTC).

    `objects` is the number of those that were drawn; `counted` tells whether all that moves was
    tracked.
    """

    id: str
    film: str
    objects: int
    counted: bool
    changed: str


class Keyframe(msgspec.Struct, frozen=True):
    """A frame in which a person has drawn the object."""

    frame: int
    region: Region


class Subject(msgspec.Struct, frozen=True):
    """What is given of an object."""

    object: int
    """Its number."""
    name: str
    color: str
    preset: str
    config: str | None
    seed: int
    """These five are as in `AddObject`."""
    first: int
    last: int
    """Its frames, both included."""
    absent: tuple[tuple[int, int], ...] = ()
    """First and last frames of absences, in order, apart from each other."""
    corrections: int = 0
    """Number of corrections so far: marks after the first one."""


class Item(Subject, frozen=True, kw_only=True):
    """An object."""

    keyframes: list[Keyframe]
    """The drawn frames."""
    cues: list[str]
    """Names of the tracker's cues, in the order of the weights in its rows."""
    tracked: bool
    """Whether it has been tracked; corrections are then followed by themselves."""
    imported: bool
    """Whether it has rows from a file, which only a keyframe or another tracker replaces."""


JobStatus = Literal["waiting", "running", "done", "stopped", "failed"]


class Progress(msgspec.Struct, frozen=True, tag="progress"):
    """The state of a job."""

    job: int
    kind: Literal["track", "watch"]
    """Its number, and what it does."""
    objects: list[int]
    """The objects that it tracks."""
    done: int
    total: int
    """Frames; a frame that is passed forward and backward counts twice."""
    rate: float | None
    """Frames a second; None if unknown."""
    left: float | None
    """Seconds; None if unknown."""
    status: JobStatus
    """Its state."""
    error: str | None = None
    """Why it failed."""
    note: str | None = None
    """What a tracker says of a drawn region that holds nothing to follow."""


class WholeSession(msgspec.Struct, frozen=True):
    """A whole session, without rows."""

    id: str
    film: OpenFilm
    """Its name in addresses, and its film."""
    revision: int
    """Grows with every change."""
    objects: list[Item]
    places: Places
    """What a person has drawn."""
    jobs: list[Progress]
    """The jobs of the server since it has started."""
    effort: float
    """Corrections for each 100 frames of objects."""
    undo: bool
    redo: bool
    """Whether there is something to take back, or to make again."""


class State(msgspec.Struct, frozen=True, tag="state"):
    """The session, first of all and after every change."""

    session: WholeSession


class Row(msgspec.Struct, frozen=True, array_like=True):
    """An object in a frame; a value that is not known is None."""

    frame: int
    time: float
    x: float | None
    y: float | None
    a: float | None
    b: float | None
    theta: float | None
    confidence: float | None
    status: str
    distance: float | None
    effective_sample_size: float | None
    belief: float | None
    """All of these are as in the rows of `motes track`."""
    deviations: tuple[float, ...] | None
    """Standard deviations of x, y, a, b, theta."""
    cue_weights: tuple[float, ...]
    """The weight of each cue."""
    final: bool
    """Whether it is the result, smoothed from both sides; else that of the pass so far."""
    milliseconds: float | None
    """The time that the tracker took, figure 7 of Nummiaro et al."""
    supporting: float | None
    """The number of particles that fulfill the appearance rule, their figure 12."""


class Rows(msgspec.Struct, frozen=True, tag="rows"):
    """Rows of an object, in any order; each replaces an earlier one of its frame.

    With `reset`, all earlier rows of the object are void.
    """

    object: int
    rows: list[Row]
    reset: bool = False


class Overlay(msgspec.Struct, frozen=True, tag="overlay"):
    """What a tracker sees in a frame while it runs; a slow page does not get all."""

    number: int
    """To acknowledge."""
    object: int
    frame: int
    ellipse: tuple[float, float, float, float, float]
    """x, y, a, b, theta."""
    covariance: tuple[float, float, float]
    """Of x and y: xx, xy, yy."""
    particles: list[tuple[float, float, float, float, float]]
    weights: list[float]
    """At most 200 of the particles x, y, a, b, theta, and their weights; the heaviest is 1."""


class DoubtfulFrame(msgspec.Struct, frozen=True):
    """A doubtful frame, in the answer about those of an object: see `motes.Doubt`."""

    frame: int
    gain: float
    reasons: list[str]


class SceneObject(msgspec.Struct, frozen=True, array_like=True):
    """An object of the many-object mode in a frame: its box and its state."""

    id: int
    x: float
    y: float
    width: float
    height: float
    confidence: float
    status: str
    occluded_by: int | None
    label: str | None


class SceneFrame(msgspec.Struct, frozen=True, array_like=True):
    """The objects of the many-object mode in a frame."""

    frame: int
    time: float
    objects: list[SceneObject]


class FoundScene(msgspec.Struct, frozen=True, tag="scene"):
    """Frames of the many-object mode; with `reset`, earlier ones are void."""

    frames: list[SceneFrame]
    events: list[dict[str, Any]]
    """What is new; events as in `motes watch --events`."""
    objects: int
    """Number of objects in the last frame."""
    totals: dict[str, int]
    """How often each event has happened, by its name, as `line 1 left`."""
    reset: bool = False


class Reply(msgspec.Struct, frozen=True, tag="reply"):
    """The answer to a command: an error in one line, or None; and a new object's or job's number.

    A message that is no command is answered with its id, or -1 if it has none.
    """

    id: int
    error: str | None = None
    object: int | None = None
    job: int | None = None


class Failure(msgspec.Struct, frozen=True, tag="failure"):
    """Something has failed: the film has ended its worker, or a file is refused; one line."""

    error: str


Message = State | Rows | Overlay | Progress | FoundScene | Reply | Failure
"""From the server to the page."""
