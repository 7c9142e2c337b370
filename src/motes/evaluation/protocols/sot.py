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

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Box, iou
from motes.evaluation.adapters.sot import UNKNOWN, TrackerAdapter
from motes.evaluation.datasets.mot import MotSequence
from motes.evaluation.datasets.sot import Sequence
from motes.evaluation.protocols.trace import NOWHERE, Row, TrackerOutput, save_trace, trace_of

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


def starts(protocol: str, sequence: Sequence | MotSequence, width: int, height: int) -> list[Start]:
    """Return the starts of a protocol on a sequence with frames of a width and height."""
    if isinstance(sequence, MotSequence):
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


class TrackerPass:
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

    def __init__(self, begin: Callable[[], TrackerAdapter], start: Start, boxes: Floats) -> None:
        self._begin, self._start, self._boxes = begin, start, boxes
        self._contestant: TrackerAdapter | None = None
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
    def trace(self) -> TrackerOutput:
        """What was said so far."""
        return trace_of(self._rows)

    def save(self, path: Path) -> None:
        """Write the trace, as `save_trace` does."""
        save_trace(path, self.trace)
