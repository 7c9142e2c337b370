"""What is written of several objects: rows or annotations of all, events, an annotated video."""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, Literal, Protocol, Self

import msgspec

from motes.annotations import coco, cvat
from motes.counting import Event, Places
from motes.errors import ConfigError, FormatError
from motes.formats import check_not_deleted, check_writable
from motes.frame import FRAME_INTERVAL, Frame
from motes.objects import SceneTrack
from motes.scene_overlay import Point, draw_scene
from motes.track import Status
from motes.writer import VideoWriter

if TYPE_CHECKING:
    from motes.video import Source

Form = Literal["mot", "csv", "jsonl"]
FORMS: dict[str, Form] = {".txt": "mot", ".csv": "csv", ".jsonl": "jsonl"}
DOCUMENTS = {".json": coco, ".xml": cvat}
"""By ending: what a user names as an output is rows or a document."""
COLUMNS = (
    "frame", "time", "identity", "x", "y", "width", "height", "confidence", "status", "behind",
)  # fmt: skip
TRAIL = 50
"""The overlay shows the way of so many frames."""


@dataclass(frozen=True, slots=True)
class Moment:
    """What became of a frame."""

    frame: Frame
    tracks: Sequence[SceneTrack]
    events: Sequence[Event]


class Output(Protocol):
    """Takes moments; ends as a context manager."""

    name: str

    def write(self, moment: Moment) -> None:
        """Add a frame."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(self, *exception: object) -> None: ...


class Lines:
    """Lines that are in a file, or on standard output, as soon as they are written.

    The file is made with the first line, or at the end of a run that had none.
    """

    def __init__(self, name: str, overwrite: bool) -> None:
        self.name = name
        self._file: BinaryIO | None = None
        if name != "-":
            check_writable(name, overwrite)

    def put(self, lines: Sequence[str]) -> None:
        """Write lines; raise a FormatError if that fails."""
        file = self._file or self._open()
        if self.name != "-":
            check_not_deleted(file, self.name)
        rest = memoryview("".join(line + "\n" for line in lines).encode())
        try:
            while rest:
                rest = rest[file.write(rest) :]
        except BrokenPipeError:  # whoever reads has seen enough
            raise
        except OSError as error:
            raise self._failure(error) from error

    def _failure(self, error: OSError) -> FormatError:
        return FormatError(
            f"{self.name} cannot be written: {error.strerror}; make room, or choose another place. "
            f"What is written is kept."
        )

    def _open(self) -> BinaryIO:
        screen = self.name == "-"
        try:
            file: BinaryIO = open(  # noqa: SIM115  (closed by __exit__)
                sys.stdout.fileno() if screen else self.name, "wb", buffering=0, closefd=not screen
            )
        except OSError as error:
            raise self._failure(error) from error
        self._file = file
        return file

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        if self._file is None and exception[0] is None:
            self._open()
        if self._file is not None:
            self._file.close()


def objects_output(name: str, overwrite: bool, form: Form | None = None) -> Output:
    """Return what writes all objects of each frame, in the form that a name's ending asks for.

    Raises
    ------
    ConfigError
        If the ending says nothing and no form of rows is given.
    FormatError
        If a file is there and must not be overwritten, or cannot be made.
    """
    if form is not None:
        return Rows(name, form, overwrite)
    ending = ".csv" if name == "-" else Path(name).suffix.lower()
    if ending in DOCUMENTS:
        return Annotations(name, overwrite)
    if ending in FORMS:
        return Rows(name, FORMS[ending], overwrite)
    raise ConfigError(f"{name} ends in none of {', '.join([*FORMS, *DOCUMENTS])}; rename it.")


class Rows(Lines):
    """A row for each object in each frame.

    As CSV and JSON Lines with `COLUMNS`, of all objects. As the MOTChallenge has it, frames and
    pixels counted from 1, of those that are seen: frame, identity, x, y, width, height, confidence,
    -1, -1, -1.
    """

    def __init__(self, name: str, form: Form, overwrite: bool) -> None:
        super().__init__(name, overwrite)
        self._form = form
        self._begun = False

    def write(self, moment: Moment) -> None:
        """Add a frame's rows."""
        if self._form == "csv" and not self._begun:
            self.put([",".join(COLUMNS)])
        self._begun = True
        if self._form == "mot":
            seen = [each for each in moment.tracks if each.track.status is Status.TRACKING]
            self.put([_mot(each) for each in seen])
        else:
            self.put([_row(each, self._form) for each in moment.tracks])


def _mot(each: SceneTrack) -> str:
    (x, y, width, height), track = each.track.box, each.track
    box = f"{x + 1:.2f},{y + 1:.2f},{width:.2f},{height:.2f}"
    return f"{track.frame + 1},{each.identity},{box},{track.confidence:.4f},-1,-1,-1"


def _row(each: SceneTrack, form: Form) -> str:
    track = each.track
    values = [
        track.frame, round(track.time, 6), each.identity,
        *(round(value, 3) for value in track.box), round(track.confidence, 5), track.status,
        each.behind,
    ]  # fmt: skip
    if form == "csv":
        return ",".join("" if value is None else str(value) for value in values)
    return msgspec.json.encode(dict(zip(COLUMNS, values, strict=True))).decode()


class Annotations:
    """A document for annotation tools, written at the end, also if the run is cut short."""

    def __init__(self, name: str, overwrite: bool) -> None:
        check_writable(name, overwrite)
        self.name = name
        self._frames: dict[int, Sequence[SceneTrack]] = {}
        self._size = (0, 0)

    def write(self, moment: Moment) -> None:
        """Keep a frame's objects for the end."""
        self._size = moment.frame.width, moment.frame.height
        self._frames[moment.frame.index] = moment.tracks

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        from motes.evaluate.results import write_text

        if self._frames:
            document = DOCUMENTS[Path(self.name).suffix.lower()]
            write_text(Path(self.name), document(self._frames, self._size))


class Events(Lines):
    """A line of JSON for each event."""

    def write(self, moment: Moment) -> None:
        """Add a frame's events."""
        self.put([event.json() for event in moment.events])


class Overlay:
    """An annotated video."""

    def __init__(
        self, path: Path, source: Source, stride: int, places: Places, *, overwrite: bool
    ) -> None:
        check_writable(path, overwrite)
        self.name = str(path)
        self._writer = VideoWriter(path, (source.fps or 1 / FRAME_INTERVAL) / stride, overwrite)
        self._places = places
        self._trails: dict[int, deque[Point]] = {}
        self._start: float | None = None

    def write(self, moment: Moment) -> None:
        """Add a picture."""
        here = {each.identity for each in moment.tracks}
        self._trails = {who: trail for who, trail in self._trails.items() if who in here}
        for each in moment.tracks:
            trail = self._trails.setdefault(each.identity, deque(maxlen=TRAIL))
            trail.append(each.track.ellipse[:2])
        pixels = draw_scene(moment.frame.pixels, moment.tracks, self._trails, self._places)
        if self._start is None:
            self._start = moment.frame.time
        self._writer.write(pixels, moment.frame.time - self._start)

    def __enter__(self) -> Self:
        self._writer.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        kind, error, trace = exception
        # A video that Ctrl-C ended is as good as any that is shorter.
        self._writer.__exit__(kind, error, trace)  # type: ignore[arg-type]
