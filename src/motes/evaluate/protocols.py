"""How a tracker is put to the test: where it starts, what is noted, when it is started anew.

| protocol | starts | by |
|---|---|---|
| `ope` | one pass from the first frame with the target | Wu, Lim and Yang, CVPR 2013 |
| `sre` | the same frame, with 12 boxes that are off | the same |
| `tre` | up to 20 frames | the same |
| `reset` | as `ope`, and anew after each failure | Kristan et al., VOT |
| `mot` | all objects, from the first frame on: see `mot_protocol` | |
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.errors import FormatError
from motes.evaluate.contestants import LARGEST, UNKNOWN, Contestant, Position
from motes.evaluate.mot_sequences import Crowd
from motes.evaluate.sequences import Sequence
from motes.files import write_whole
from motes.frame import Frame
from motes.geometry import Box, Ellipse, iou

Floats = NDArray[np.float64]

SHIFT = 0.1
"""How far a box is moved in `sre`, in its own width and height."""
SHIFTS = {
    "left": (-1, 0),
    "right": (1, 0),
    "up": (0, -1),
    "down": (0, 1),
    "up-left": (-1, -1),
    "up-right": (1, -1),
    "down-left": (-1, 1),
    "down-right": (1, 1),
}
SCALES = (0.8, 0.9, 1.1, 1.2)
"""Sizes of a box in `sre`."""

TIMES = 20
"""Starts of `tre`, where the film is long enough."""
SHORTEST = 5
"""A start of `tre` leaves at least so many frames, its own included."""

PAUSE = 5
"""In `reset`, a tracker starts anew so many frames after a failure."""

EVENTS = ("tracked", "started", "failed", "skipped")
TRACKED, STARTED, FAILED, SKIPPED = range(4)
"""What a row of a trace is; in `reset`, FAILED is an overlap of 0, SKIPPED waits for a restart."""


class Start(NamedTuple):
    """Where a tracker is started.

    Attributes
    ----------
    protocol
        `ope`, `sre`, `tre`, `reset` or `mot`.
    label
        Which of the protocol's starts, such as `shift-left`, `scale-0.8` or `from-035`; empty
        where there is only one.
    frame, box
        The first frame, and what the tracker is told there; None in `mot`, for nothing.
    """

    protocol: str
    label: str
    frame: int
    box: Box | None


def starts(protocol: str, sequence: Sequence | Crowd, width: int, height: int) -> list[Start]:
    """Return the starts of a protocol on a sequence with frames of a width and height."""
    if isinstance(sequence, Crowd):
        return [Start(protocol, "", 0, None)]
    return PROTOCOLS[protocol](protocol, sequence, (width, height))


def _once(protocol: str, sequence: Sequence, size: tuple[int, int]) -> list[Start]:
    frame = int(_present(sequence)[0])
    return [Start(protocol, "", frame, _box(sequence, frame))]


def _perturbed(protocol: str, sequence: Sequence, size: tuple[int, int]) -> list[Start]:
    frame = int(_present(sequence)[0])
    x, y, width, height = box = _box(sequence, frame)
    boxes = {
        f"shift-{name}": Box(x + SHIFT * right * width, y + SHIFT * down * height, width, height)
        for name, (right, down) in SHIFTS.items()
    }
    boxes |= {f"scale-{scale}": _scaled(box, scale) for scale in SCALES}
    return [Start(protocol, label, frame, _inside(box, size)) for label, box in boxes.items()]


def _times(protocol: str, sequence: Sequence, size: tuple[int, int]) -> list[Start]:
    present, length = _present(sequence), len(sequence.boxes)
    # Where the target is absent, the next frame that has it.
    wanted = np.searchsorted(present, np.arange(TIMES) * length // TIMES)
    frames = np.unique(present[wanted[wanted < present.size]])
    chosen = [frame for frame in frames.tolist() if length - frame >= SHORTEST]
    return [
        Start(protocol, f"from-{frame:03d}", frame, _box(sequence, frame))
        for frame in chosen or present[:1].tolist()
    ]


PROTOCOLS: dict[str, Callable[[str, Sequence, tuple[int, int]], list[Start]]] = {
    "ope": _once,
    "sre": _perturbed,
    "tre": _times,
    "reset": _once,
}


def _present(sequence: Sequence) -> NDArray[np.intp]:
    """Return the frames that have the target."""
    return np.flatnonzero(np.isfinite(sequence.boxes).all(axis=1))


def _box(sequence: Sequence, frame: int) -> Box:
    return Box(*sequence.boxes[frame].tolist())


def _scaled(box: Box, scale: float) -> Box:
    x, y, width, height = box
    off = (1 - scale) / 2
    return Box(x + off * width, y + off * height, scale * width, scale * height)


def _inside(box: Box, size: tuple[int, int]) -> Box:
    """Return a box that is no larger than the frame, moved until it lies in it."""
    width, height = min(box.width, size[0]), min(box.height, size[1])
    x, y = max(min(box.x, size[0] - width), 0.0), max(min(box.y, size[1] - height), 0.0)
    return Box(x, y, width, height)


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """What a tracker said in one pass, from its start to the end of the film.

    Attributes
    ----------
    frames
        (n,), index of each frame.
    ellipses
        (n, 5); upright ones where the tracker gives boxes. Where it gives nothing it is the last
        one that it gave, and NaN where it was not asked.
    confidence
        (n,), NaN where the tracker has none.
    lost
        (n,), whether the tracker says that it does not have the target.
    seconds
        (n,), of time inside the tracker; NaN where it was not asked.
    events
        (n,), TRACKED, STARTED, FAILED or SKIPPED.
    covariances
        (n, 3), of the ellipses' centers: xx, xy, yy; NaN where the tracker has none.
    """

    frames: NDArray[np.int64]
    ellipses: Floats
    confidence: Floats
    lost: NDArray[np.bool_]
    seconds: Floats
    events: NDArray[np.int8]
    covariances: Floats


class Row(NamedTuple):
    """One frame of a trace."""

    frame: int
    ellipse: Ellipse
    confidence: float
    lost: bool
    seconds: float
    event: int
    covariance: Position


NOWHERE = Ellipse(*[float("nan")] * 5)


class Running:
    """A pass in progress: hand it every frame of the film in order, then take its trace.

    Parameters
    ----------
    begin
        Makes who is tested.
    start
        Where; earlier frames are passed over.
    boxes
        (frames, 4), the truth, for the protocol `reset`.
    """

    def __init__(self, begin: Callable[[], Contestant], start: Start, boxes: Floats) -> None:
        self._begin, self._start, self._boxes = begin, start, boxes
        self._contestant: Contestant | None = None
        self._rows: list[Row] = []
        self._last = NOWHERE
        self._next: int | None = start.frame
        """The earliest frame for the next start; None while the tracker runs."""

    def feed(self, frame: Frame) -> None:
        """Take the next frame."""
        if frame.index < self._start.frame:
            return
        truth = self._boxes[frame.index]
        there = bool(np.isfinite(truth).all())
        self._contestant = contestant = self._contestant or self._begin()
        if self._next is None:
            answer, event = contestant.update(frame), TRACKED
        elif there and frame.index >= self._next:
            begun = self._start.box if frame.index == self._start.frame else None
            box = begun or Box(*truth.tolist())
            answer, event = contestant.init(frame, box), STARTED
            self._next = None
        else:
            self._rows.append(Row(frame.index, NOWHERE, np.nan, False, np.nan, SKIPPED, UNKNOWN))
            return
        self._last = answer.ellipse or self._last
        if self._start.protocol == "reset" and there and not iou(self._last.box, truth):
            event, self._next = FAILED, frame.index + PAUSE
        _, confidence, lost, seconds, covariance = answer
        self._rows.append(
            Row(frame.index, self._last, confidence, lost, seconds, event, covariance)
        )

    def close(self) -> None:
        """Let go of the contestant."""
        if self._contestant is not None:
            self._contestant.close()

    @property
    def trace(self) -> Trace:
        """What was said so far."""
        return _trace(self._rows)

    def save(self, path: Path) -> None:
        """Write the trace, as `save_trace` does."""
        save_trace(path, self.trace)


def _trace(rows: list[Row]) -> Trace:
    frames, ellipses, confidence, lost, seconds, events, covariances = zip(*rows, strict=True)
    return Trace(
        np.array(frames, np.int64),
        np.array(ellipses, np.float64),
        np.array(confidence, np.float64),
        np.array(lost, np.bool_),
        np.array(seconds, np.float64),
        np.array(events, np.int8),
        np.array(covariances, np.float64),
    )


SPREAD = ("xx", "xy", "yy")
COLUMNS = ("frame", *Ellipse._fields, "confidence", "lost", "seconds", "event", *SPREAD)
"""Of a trace's file; `lost` is 0 or 1, `event` one of `EVENTS`, NaN an empty field.

Files made before there were the last three, the covariance, are read as without one.
"""


def save_trace(path: str | Path, trace: Trace) -> None:
    """Write a trace as CSV with the `COLUMNS`, whole or not at all; it is read back identically.

    Raises
    ------
    FormatError
        If it cannot be written.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for frame, ellipse, confidence, lost, seconds, event, covariance in zip(
        trace.frames.tolist(),
        trace.ellipses.tolist(),
        trace.confidence.tolist(),
        trace.lost.tolist(),
        trace.seconds.tolist(),
        trace.events.tolist(),
        trace.covariances.tolist(),
        strict=True,
    ):
        numbers, (time,), spread = map(_fields, ((*ellipse, confidence), (seconds,), covariance))
        writer.writerow([frame, *numbers, int(lost), time, EVENTS[event], *spread])
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text.getvalue().encode())
    except OSError as error:
        raise FormatError(
            f"{path} cannot be written: {error.strerror}; make room, or choose another place."
        ) from None


def _fields(values: Iterable[float]) -> list[str]:
    return ["" if value != value else repr(value) for value in values]


def load_trace(path: str | Path) -> Trace:
    """Read a trace that `save_trace` wrote.

    Raises
    ------
    FormatError
        If the file cannot be read or is no trace.
    """
    try:
        head, *lines = csv.reader(io.StringIO(Path(path).read_text(encoding="utf-8")))
        if tuple(head) not in (COLUMNS, COLUMNS[: -len(SPREAD)]):
            raise ValueError("its columns are others")
        rows: list[Row] = []
        for place, line in enumerate(lines, 2):
            rows.append(_row(line, len(head), place))
            if rows[-1].frame != rows[0].frame + len(rows) - 1:
                raise ValueError(f"line {place}: its frames do not follow each other")
        if not rows or not 0 <= rows[0].frame <= LARGEST:
            raise ValueError("its first frame is missing")
        return _trace(rows)
    except OSError as error:
        raise FormatError(f"{path} cannot be read: {error.strerror}.") from None
    except (ValueError, csv.Error) as error:
        raise FormatError(f"{path} is not a track of an evaluation ({error}).") from None


def _row(fields: list[str], columns: int, line: int) -> Row:
    """Return a row of a trace; raise a ValueError, with the number of its line, if it is none."""
    try:
        if len(fields) != columns:
            raise ValueError("it has more or fewer columns than the first one")
        return _of_fields(*fields)
    except ValueError as error:
        raise ValueError(f"line {line}: {error}") from None


def _of_fields(
    frame: str, x: str, y: str, a: str, b: str, theta: str,
    confidence: str, lost: str, seconds: str, event: str, *spread: str,
) -> Row:  # fmt: skip
    ellipse = Ellipse(*map(number, (x, y, a, b, theta)))
    xx, xy, yy = map(number, spread) if spread else UNKNOWN
    sure, time = number(confidence), duration(seconds)
    if min(ellipse.a, ellipse.b) < 1 / LARGEST:
        raise ValueError(f"the ellipse of frame {frame} has no area")
    if not (math.isnan(sure) or 0 <= round(sure, 9) <= 1):
        raise ValueError(f"the confidence of frame {frame} is {sure:g}")
    return Row(
        int(frame), ellipse, sure, lost == "1", time, EVENTS.index(event), (xx, xy, yy),
    )  # fmt: skip


def number(field: str) -> float:
    """Return the number in a field of a track, NaN for an empty one; raise a ValueError if none."""
    value = float(field) if field else math.nan
    if abs(value) > LARGEST**2:  # which a covariance may be
        raise ValueError(f"{field} is out of bounds")
    return value


def duration(field: str) -> float:
    """Return the seconds in a field of a track, NaN for an empty one, as `number` does."""
    seconds = number(field)
    if seconds < 0 or 0 < seconds < 1 / LARGEST:
        raise ValueError(f"a frame takes no {field} s")
    return seconds
