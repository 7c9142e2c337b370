"""Protocols for single-object trackers: where a tracker starts, and when it is restarted.

| protocol | starts | source |
|---|---|---|
| `ope` | one pass from the first frame with the target | Wu, Lim and Yang, CVPR 2013 |
| `pixel` | the same frame, with the box as it is and moved by a pixel each way | |
| `sre` | the same frame, with 12 perturbed boxes | the same |
| `tre` | up to 20 frames | the same |
| `reset` | as `ope`, with a restart after each failure | Kristan et al., VOT |
| `mot` | all objects from the first frame: see `protocols.mot` | |
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import Frame
from motes.core.geometry import Box, iou
from motes.core.types import Floats
from motes_lab.adapters.sot import UNKNOWN, TrackerAdapter
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.sot import Sequence
from motes_lab.protocols.trace import NOWHERE, Row, TrackerOutput, save_trace, trace_of

SRE_SHIFT = 0.1
"""Distance by which `sre` moves a box, as a fraction of its width and height."""
SRE_DIRECTIONS = {
    "left": (-1, 0),
    "right": (1, 0),
    "up": (0, -1),
    "down": (0, 1),
    "up-left": (-1, -1),
    "up-right": (1, -1),
    "down-left": (-1, 1),
    "down-right": (1, 1),
}
PIXEL_SHIFTS = (0, -1, 1)
"""Pixels by which `pixel` moves a box, in x and in y: annotators differ by as much."""
SRE_SCALES = (0.8, 0.9, 1.1, 1.2)
"""Scale factors of a box in `sre`."""

MAX_TRE_STARTS = 20
"""Number of starts of `tre`, if the sequence is long enough."""
MIN_FRAMES = 5
"""Smallest number of frames after a start of `tre`, including its own."""

RESTART_DELAY = 5
"""In `reset`, a tracker is restarted this many frames after a failure."""

TRACKED, STARTED, FAILED, SKIPPED = range(4)
"""Events of a frame. In `reset`, FAILED means an overlap of 0, SKIPPED the wait for a restart."""


class Start(NamedTuple):
    """Where a tracker is started.

    Attributes
    ----------
    protocol
        `ope`, `pixel`, `sre`, `tre`, `reset` or `mot`.
    label
        The name of the start in its protocol, such as `shift-left`, `scale-0.8` or `from-035`;
        empty if there is only one.
    frame, box
        The first frame, and the box given to the tracker there; None in `mot`, which gives no box.
    """

    protocol: str
    label: str
    frame: int
    box: Box | None


def starts(protocol: str, sequence: Sequence | MotSequence, width: int, height: int) -> list[Start]:
    """Return the starts of a protocol on a sequence whose frames have a width and height."""
    if isinstance(sequence, MotSequence):
        return [Start(protocol, "", 0, None)]
    return PROTOCOLS[protocol](protocol, sequence, (width, height))


def _once(protocol: str, sequence: Sequence, size: tuple[int, int]) -> list[Start]:
    frame = int(_present(sequence)[0])
    return [Start(protocol, "", frame, _box(sequence, frame))]


def _moved_by_a_pixel(protocol: str, sequence: Sequence, size: tuple[int, int]) -> list[Start]:
    frame = int(_present(sequence)[0])
    x, y, width, height = _box(sequence, frame)
    return [
        Start(
            protocol,
            f"{shift:+d}" if shift else "0",
            frame,
            _inside(Box(x + shift, y + shift, width, height), size),
        )
        for shift in PIXEL_SHIFTS
    ]


def _perturbed(protocol: str, sequence: Sequence, size: tuple[int, int]) -> list[Start]:
    frame = int(_present(sequence)[0])
    x, y, width, height = box = _box(sequence, frame)
    boxes = {
        f"shift-{name}": Box(
            x + SRE_SHIFT * right * width, y + SRE_SHIFT * down * height, width, height
        )
        for name, (right, down) in SRE_DIRECTIONS.items()
    }
    boxes |= {f"scale-{scale}": _scaled(box, scale) for scale in SRE_SCALES}
    return [Start(protocol, label, frame, _inside(box, size)) for label, box in boxes.items()]


def _times(protocol: str, sequence: Sequence, size: tuple[int, int]) -> list[Start]:
    present, length = _present(sequence), len(sequence.boxes)
    # If the target is absent, the start is the next frame with the target.
    found_at = np.searchsorted(present, np.arange(MAX_TRE_STARTS) * length // MAX_TRE_STARTS)
    frames = np.unique(present[found_at[found_at < present.size]])
    chosen = [frame for frame in frames.tolist() if length - frame >= MIN_FRAMES]
    return [
        Start(protocol, f"from-{frame:03d}", frame, _box(sequence, frame))
        for frame in chosen or present[:1].tolist()
    ]


PROTOCOLS: dict[str, Callable[[str, Sequence, tuple[int, int]], list[Start]]] = {
    "ope": _once,
    "pixel": _moved_by_a_pixel,
    "sre": _perturbed,
    "tre": _times,
    "reset": _once,
}


def _present(sequence: Sequence) -> NDArray[np.intp]:
    """Return the frames with the target."""
    return np.flatnonzero(np.isfinite(sequence.boxes).all(axis=1))


def _box(sequence: Sequence, frame: int) -> Box:
    return Box(*sequence.boxes[frame].tolist())


def _scaled(box: Box, scale: float) -> Box:
    x, y, width, height = box
    off = (1 - scale) / 2
    return Box(x + off * width, y + off * height, scale * width, scale * height)


def _inside(box: Box, size: tuple[int, int]) -> Box:
    """Return a box no larger than the frame, moved so that it lies inside the frame."""
    width, height = min(box.width, size[0]), min(box.height, size[1])
    x, y = max(min(box.x, size[0] - width), 0.0), max(min(box.y, size[1] - height), 0.0)
    return Box(x, y, width, height)


class TrackerPass:
    """A pass in progress: feed it every frame of the sequence in order, then read its trace.

    Parameters
    ----------
    make_adapter
        Makes the tracker under test.
    start
        Where it starts; earlier frames are skipped.
    boxes
        (frames, 4), the truth, for the protocol `reset`.
    """

    def __init__(
        self, make_adapter: Callable[[], TrackerAdapter], start: Start, boxes: Floats
    ) -> None:
        self._make_adapter, self._start, self._boxes = make_adapter, start, boxes
        self._adapter: TrackerAdapter | None = None
        self._rows: list[Row] = []
        self._last = NOWHERE
        self._next: int | None = start.frame
        """The earliest frame for the next start; None while the tracker runs."""

    def feed(self, frame: Frame) -> None:
        """Process the next frame."""
        if frame.index < self._start.frame:
            return
        truth = self._boxes[frame.index]
        there = bool(np.isfinite(truth).all())
        self._adapter = adapter = self._adapter or self._make_adapter()
        if self._next is None:
            answer, event = adapter.update(frame), TRACKED
        elif there and frame.index >= self._next:
            given_box = self._start.box if frame.index == self._start.frame else None
            box = given_box or Box(*truth.tolist())
            answer, event = adapter.init(frame, box), STARTED
            self._next = None
        else:
            self._rows.append(Row(frame.index, NOWHERE, np.nan, False, np.nan, SKIPPED, UNKNOWN))
            return
        self._last = answer.ellipse or self._last
        if self._start.protocol == "reset" and there and not iou(self._last.box, truth):
            event, self._next = FAILED, frame.index + RESTART_DELAY
        _, confidence, lost, seconds, covariance = answer
        self._rows.append(
            Row(frame.index, self._last, confidence, lost, seconds, event, covariance)
        )

    @property
    def trace(self) -> TrackerOutput:
        """The output so far."""
        return trace_of(self._rows)

    def save(self, path: Path) -> None:
        """Write the trace with `save_trace`."""
        save_trace(path, self.trace)
