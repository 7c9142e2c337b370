"""The protocol of the studio: all that the page and the server send each other, as types.

A WebSocket carries `Command`s from the page and `Message`s to it, each a JSON object whose `type`
names it. Every command has an `id`, and is answered by one `Reply` with that id, after the state
and the rows that have changed with it. HTTP carries films, pictures and files, and the JSON of
`Film`, `SessionCard`, `Session` and `Failure`. Both sides are tested against `schema`.

Places are in pixels of the film from 0, angles in radians, times in seconds. Frames count from 0. A
region has four numbers, a box x, y, width, height; or five, an ellipse x, y, a, b, theta: its
center, its half-axes, and the angle of the first one.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import UNSET, Meta, UnsetType

LARGEST_MESSAGE = 1 << 18
"""Bytes that a message from the page may have."""

Region = Annotated[tuple[float, ...], Meta(min_length=4, max_length=5)]
Name = Annotated[str, Meta(max_length=100)]
Color = Annotated[str, Meta(pattern=r"^#[0-9a-fA-F]{6}$")]
Toml = Annotated[str, Meta(max_length=1 << 16)]
"""The text of a configuration file; it takes the place of a preset."""
Number = Annotated[int, Meta(ge=0, le=2**53 - 1)]
"""A frame, an object, a job or a seed."""
Few = Annotated[list[Number], Meta(max_length=100)]
Layer = Literal["rho", "likelihoods", "particles", "histograms", "orientation"]
"""`rho` is the surface around the target, figure 3 of Nummiaro et al.; `likelihoods` is the same
for each cue; `orientation` has the histograms of figure 1 of Maggio et al."""


class _Command(msgspec.Struct, frozen=True, tag=str.lower, forbid_unknown_fields=True):
    """What the page asks for; `id` is repeated in the reply."""

    id: Number


class AddObject(_Command, frozen=True, tag="add_object"):
    """Add an object that a person has drawn; the drawing is its first keyframe.

    The reply has the number of the object.
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
    """Remove an object and what is compared with it."""

    object: Number


class SetKeyframe(_Command, frozen=True, tag="set_keyframe"):
    """Mark the object in a frame; None marks it as absent.

    If the object has been tracked, the stretch between the neighboring keyframes is tracked again.
    """

    object: Number
    frame: Number
    region: Region | None


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


class Track(_Command, frozen=True, tag="track"):
    """Track objects between their keyframes; without objects, all. The reply has the job."""

    objects: Few = []


class Pause(_Command, frozen=True, tag="pause"):
    """Let a job wait."""

    job: Number


class Resume(_Command, frozen=True, tag="resume"):
    """Let a job that waits go on."""

    job: Number


class Stop(_Command, frozen=True, tag="stop"):
    """End a job; the rows so far are kept."""

    job: Number


class Undo(_Command, frozen=True, tag="undo"):
    """Take back the last change."""


class Redo(_Command, frozen=True, tag="redo"):
    """Make the change again that was taken back last."""


class Doubts(_Command, frozen=True, tag="doubts"):
    """Ask for the doubtful frames of an object, in the order of `motes check`."""

    object: Number
    count: Annotated[int, Meta(ge=1, le=100)] = 20


class Look(_Command, frozen=True, tag="look"):
    """Ask for layers of a frame; a `Layers` comes when they are made.

    A tracker starts at the nearest keyframe before the frame, or else after it, and goes there.
    """

    object: Number
    frame: Number
    layers: Annotated[list[Layer], Meta(max_length=5)]


class Watch(_Command, frozen=True, tag="watch"):
    """Track all that moves, as `motes watch`. The reply has the job."""

    detector: Literal["mog2", "knn", "gaussian", "people", "faces"] = "mog2"
    preset: Name = "nummiaro:adaptive"
    config: Toml | None = None
    seed: Number = 0


class Line(msgspec.Struct, frozen=True):
    """A line whose crossings count: its ends, and its name."""

    points: tuple[float, float, float, float]
    name: Name = ""
    label: tuple[Name, Name] = ("left", "right")


class Zone(msgspec.Struct, frozen=True):
    """A polygon whose entries and exits count: x and y of its corners, and its name."""

    points: Annotated[tuple[float, ...], Meta(min_length=6, max_length=400)]
    name: Name = ""
    dwell: Annotated[float, Meta(gt=0)] | None = None


GroundPoints = Annotated[
    tuple[tuple[float, float, float, float], ...], Meta(min_length=4, max_length=100)
]
"""Points of the picture and their places on the ground: x, y in pixels, X, Y in metres."""


class Places(msgspec.Struct, frozen=True):
    """What is drawn on the picture for counting."""

    lines: Annotated[tuple[Line, ...], Meta(max_length=50)] = ()
    zones: Annotated[tuple[Zone, ...], Meta(max_length=50)] = ()
    ground: GroundPoints | None = None


class SetPlaces(_Command, frozen=True, tag="set_places"):
    """Replace the lines, zones and the ground; they count from the next `Watch` on."""

    places: Places


class Compare(_Command, frozen=True, tag="compare"):
    """Add an object with the keyframes of another one and a tracker of its own.

    It follows all changes of these keyframes. The reply has its number.
    """

    object: Number
    preset: Name = "default"
    config: Toml | None = None
    seed: Number = 0


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
    | Track
    | Pause
    | Resume
    | Stop
    | Undo
    | Redo
    | Doubts
    | Look
    | Watch
    | SetPlaces
    | Compare
    | Acknowledge
)
"""From the page to the server."""


class Film(msgspec.Struct, frozen=True):
    """A film that can be opened: its name for `POST /api/sessions`, and its size in bytes."""

    name: str
    bytes: int
    uploaded: bool = False


class FilmFacts(msgspec.Struct, frozen=True):
    """A film that is open: its name, its size in pixels, its number of frames and its rate."""

    name: str
    width: int
    height: int
    frames: int
    fps: float


class Preset(msgspec.Struct, frozen=True):
    """A tracker that can be chosen, in one line."""

    name: str
    summary: str


class Presets(msgspec.Struct, frozen=True):
    """The trackers of one object, and those of the many-object mode."""

    track: list[Preset]
    watch: list[Preset]


class Open(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The body of `POST /api/sessions`: a film's name, and whether it is an upload."""

    film: Annotated[str, Meta(max_length=1000)]
    uploaded: bool = False


class SessionCard(msgspec.Struct, frozen=True):
    """A session in the list: its film, its number of objects, and when it changed last (UTC)."""

    id: str
    film: str
    objects: int
    changed: str


class Keyframe(msgspec.Struct, frozen=True):
    """A frame in which a person has drawn the object."""

    frame: int
    region: Region


class Item(msgspec.Struct, frozen=True):
    """An object.

    Attributes
    ----------
    object
        Its number.
    name, color, preset, config, seed
        As in `AddObject`.
    first, last
        Its frames, both included.
    keyframes, absent
        The drawn frames; and the first and last frames of absences.
    corrections
        Number of corrections so far: marks after the first one.
    compared
        The object whose keyframes it has; None for an object with its own.
    cues
        Names of the tracker's cues, in the order of the weights in its rows.
    tracked
        Whether it has been tracked; corrections are then followed by themselves.
    """

    object: int
    name: str
    color: str
    preset: str
    config: str | None
    seed: int
    first: int
    last: int
    keyframes: list[Keyframe]
    absent: list[tuple[int, int]]
    corrections: int
    compared: int | None
    cues: list[str]
    tracked: bool


JobStatus = Literal["waiting", "running", "paused", "done", "stopped", "failed"]


class Progress(msgspec.Struct, frozen=True, tag="progress"):
    """The state of a job.

    Attributes
    ----------
    job, kind
        Its number, and what it does.
    objects
        The objects that it tracks.
    done, total
        Frames; a frame that is passed forward and backward counts twice.
    rate
        Frames a second; None if unknown.
    left
        Seconds; None if unknown.
    status
        Its state.
    error
        Why it failed.
    """

    job: int
    kind: Literal["track", "watch"]
    objects: list[int]
    done: int
    total: int
    rate: float | None
    left: float | None
    status: JobStatus
    error: str | None = None


class Session(msgspec.Struct, frozen=True):
    """A whole session, without rows.

    Attributes
    ----------
    id, film
        Its name in addresses, and its film.
    revision
        Grows with every change.
    objects, places
        What a person has drawn.
    jobs
        The jobs of the server since it has started.
    effort
        Corrections for each 100 frames of objects.
    undo, redo
        Whether there is something to take back, or to make again.
    """

    id: str
    film: FilmFacts
    revision: int
    objects: list[Item]
    places: Places
    jobs: list[Progress]
    effort: float
    undo: bool
    redo: bool


class State(msgspec.Struct, frozen=True, tag="state"):
    """The session, first of all and after every change."""

    session: Session


class Row(msgspec.Struct, frozen=True, array_like=True):
    """An object in a frame; a value that is not known is None.

    Attributes
    ----------
    frame, time, x, y, a, b, theta, confidence, status, distance, effective_sample_size
        As in the rows of `motes track`.
    deviations
        Standard deviations of x, y, a, b, theta.
    cue_weights
        The weight of each cue.
    final
        Whether it is the result, smoothed from both sides; else that of the pass so far.
    """

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
    deviations: tuple[float, ...] | None
    cue_weights: tuple[float, ...]
    final: bool


class Rows(msgspec.Struct, frozen=True, tag="rows"):
    """Rows of an object, in any order; each replaces an earlier one of its frame.

    With `reset`, all earlier rows of the object are void.
    """

    object: int
    rows: list[Row]
    reset: bool = False


class Overlay(msgspec.Struct, frozen=True, tag="overlay"):
    """What a tracker sees in a frame while it runs; a slow page does not get all.

    Attributes
    ----------
    number
        To acknowledge.
    ellipse
        x, y, a, b, theta.
    covariance
        Of x and y: xx, xy, yy.
    particles, weights
        At most 200 of the particles x, y, a, b, theta, and their weights; the heaviest is 1.
    milliseconds
        The time that the tracker took, figure 7 of Nummiaro et al.
    supporting
        The number of particles that fulfill the appearance rule, their figure 12; None without one.
    """

    number: int
    object: int
    frame: int
    ellipse: tuple[float, float, float, float, float]
    covariance: tuple[float, float, float]
    particles: list[tuple[float, float, float, float, float]]
    weights: list[float]
    cue_weights: dict[str, float]
    milliseconds: float
    supporting: int | None


class Doubt(msgspec.Struct, frozen=True):
    """A doubtful frame: see `motes.correction.suspects.Doubt`."""

    frame: int
    gain: float
    reasons: list[str]


class DoubtList(msgspec.Struct, frozen=True, tag="doubts"):
    """The doubtful frames of an object, the first to correct first."""

    object: int
    items: list[Doubt]


class Surface(msgspec.Struct, frozen=True):
    """Heights over a grid: `values[i][j]` belongs to `y[i]` and `x[j]`."""

    x: list[float]
    y: list[float]
    values: list[list[float]]


class Histograms(msgspec.Struct, frozen=True):
    """Shares of the bins of a cue: of the target model, and of the estimate's region."""

    model: list[float]
    estimate: list[float]


class Layers(msgspec.Struct, frozen=True, tag="layers"):
    """Layers of a frame; one that the tracker does not have is empty.

    Attributes
    ----------
    likelihoods
        A surface for each cue.
    particles, weights
        As in `Overlay`.
    histograms
        For each cue that has histograms.
    orientation
        The histograms of edge orientations: `rotated`, `fourier` and `model`.
    """

    object: int
    frame: int
    ellipse: tuple[float, float, float, float, float]
    rho: Surface | None = None
    likelihoods: dict[str, Surface] = {}
    particles: list[tuple[float, float, float, float, float]] = []
    weights: list[float] = []
    histograms: dict[str, Histograms] = {}
    orientation: dict[str, list[float]] = {}


class SceneObject(msgspec.Struct, frozen=True, array_like=True):
    """An object of the many-object mode in a frame: its box and its state."""

    identity: int
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


class SceneRows(msgspec.Struct, frozen=True, tag="scene_rows"):
    """Frames of the many-object mode; with `reset`, earlier ones are void."""

    frames: list[SceneFrame]
    reset: bool = False


class SceneEvents(msgspec.Struct, frozen=True, tag="scene_events"):
    """Events as in `motes watch --events`; with `reset`, earlier ones are void."""

    events: list[dict[str, Any]]
    reset: bool = False


class Counts(msgspec.Struct, frozen=True, tag="counts"):
    """How often each event has happened, by its name, as `line 1 left`; and objects now."""

    objects: int
    totals: dict[str, int]


class Reply(msgspec.Struct, frozen=True, tag="reply"):
    """The answer to a command: an error in one line, or None; and a new object's or job's number.

    A message that is no command is answered with id -1.
    """

    id: int
    error: str | None = None
    object: int | None = None
    job: int | None = None


class Failure(msgspec.Struct, frozen=True, tag="failure"):
    """Something has failed: the film has ended its worker, or a file is refused; one line."""

    error: str


Message = (
    State
    | Rows
    | Overlay
    | Progress
    | DoubtList
    | Layers
    | SceneRows
    | SceneEvents
    | Counts
    | Reply
    | Failure
)
"""From the server to the page."""

_decoder = msgspec.json.Decoder(Command)
_encoder = msgspec.json.Encoder()


def decode(text: str | bytes) -> Command:
    """Return the command in a message; raise a `msgspec.MsgspecError` if it is none."""
    command: Command = _decoder.decode(text)
    return command


def encode(message: Message) -> str:
    """Return the text of a message."""
    return _encoder.encode(message).decode()


def schema() -> dict[str, Any]:
    """Return the JSON schema of commands and messages, by the names of their types."""
    kinds = (Command, Message, Session, SessionCard, Film, Presets, Open)
    _, definitions = msgspec.json.schema_components(kinds, ref_template="#/$defs/{name}")
    return {"$defs": definitions}
