"""What the server asks its workers, and what they answer: bytes between processes, typed."""

from __future__ import annotations

from typing import Any, Literal

import msgspec

from motes.studio.commands import Layer, Places
from motes.studio.messages import OpenFilm, Overlay


class _Task(msgspec.Struct, frozen=True, tag=True):
    """Something that a worker does with its film."""


class Picture(_Task, frozen=True):
    """Make a JPEG of a frame; `Done` has it."""

    index: int
    width: int


class Strip(_Task, frozen=True):
    """Make a JPEG of thumbnails side by side; `Done` has it."""

    count: int
    height: int


class RunPass(msgspec.Struct, frozen=True):
    """A target is followed from its region in frame `start` to frame `stop`, both included.

    `stop` before `start` is a pass backward. The models also learn from `other`, the frame and the
    region of the keyframe at the other end.
    """

    config: dict[str, Any]
    seed: int
    start: int
    region: tuple[float, ...]
    stop: int
    other: tuple[int, tuple[float, ...]] | None = None


class RunPasses(_Task, frozen=True):
    """Run passes over the same frames, which are decoded once for all. `Part`s have the rows."""

    passes: list[RunPass]


class JoinStretch(_Task, frozen=True):
    """Make the smoothed rows of a stretch from its passes; `Done` has them.

    The passes are tables over the frames of the stretch, in order; one may be missing.
    """

    first: int
    last: int
    begin: tuple[float, ...] | None
    end: tuple[float, ...] | None
    absent: list[tuple[int, int]]
    forward: bytes | None
    backward: bytes | None
    cues: int


class FindDoubts(_Task, frozen=True):
    """Find the doubtful frames of rows; `Done` has the JSON of a list of `Doubt`s."""

    table: bytes
    cues: int
    keyframes: list[tuple[int, tuple[float, ...] | None]]
    count: int


class LookAt(_Task, frozen=True):
    """Make layers in the last frame of a pass; `Done` has the JSON of `Layers`."""

    object: int
    run: RunPass
    layers: list[Layer]


class WatchFilm(_Task, frozen=True):
    """Track all that moves; `Part`s have the JSON of `Scene`."""

    config: dict[str, Any]
    places: Places
    seed: int


class Annotate(_Task, frozen=True):
    """Make an annotated film in the file `path`; an object is its number, table and cues."""

    objects: list[tuple[int, bytes, int]]
    path: str


class DrawFigures(_Task, frozen=True):
    """Draw the papers' figures of a run into the folder `path`, as `motes track --figures`."""

    config: dict[str, Any]
    seed: int
    start: int
    region: tuple[float, ...]
    stop: int
    path: str


class DrawSlit(_Task, frozen=True):
    """Make the slit scan of a line, with its crossings and the names of its directions.

    `Done` has a PNG.

    A crossing has its frame, the place of the foot, the identity, and whether it goes to the second
    side of the line.
    """

    line: tuple[float, float, float, float]
    label: tuple[str, str]
    crossings: list[tuple[int, float, float, int, bool]]


class DrawForeground(_Task, frozen=True):
    """Make a PNG of what moves in a frame, white on transparent; `Done` has it."""

    method: Literal["mog2", "gaussian"]
    index: int


Task = (
    Picture
    | Strip
    | RunPasses
    | JoinStretch
    | FindDoubts
    | LookAt
    | WatchFilm
    | Annotate
    | DrawFigures
    | DrawSlit
    | DrawForeground
)


class Ready(msgspec.Struct, frozen=True, tag=True):
    """The film is open."""

    facts: OpenFilm
    times: list[float]


class Part(msgspec.Struct, frozen=True, tag=True):
    """Some rows, in order of the run, and what the tracker saw in the last of them.

    `run` is the place of their pass among the `RunPasses`.
    """

    data: bytes
    run: int = 0
    overlay: Overlay | None = None


class Alive(msgspec.Struct, frozen=True, tag=True):
    """The worker goes on; it has `done` of its frames."""

    done: int = 0


class Done(msgspec.Struct, frozen=True, tag=True):
    """The task is done; or stopped, if `stopped`."""

    data: bytes = b""
    stopped: bool = False


class Failed(msgspec.Struct, frozen=True, tag=True):
    """The task has failed, with one line for a person.

    If `damaged`, the film is, and has to be read as a whole by a new worker.
    """

    error: str
    damaged: bool = False


Answer = Ready | Part | Alive | Done | Failed
RUN, PAUSE, STOP = 0, 1, 2
"""What the server wants of a worker, in memory that they share."""
