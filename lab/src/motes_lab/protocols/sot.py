"""Protocols for single-object trackers: where a tracker starts.

| protocol | starts | source |
|---|---|---|
| `ope` | one pass from the first frame with the target | Wu, Lim and Yang, CVPR 2013 |
| `pixel` | the same frame, with the box as it is and moved by a pixel each way | |
| `mot` | all objects from the first frame: see `protocols.mot` | |
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from motes import Box, Frame
from motes_lab.adapters.sot import TrackerAdapter
from motes_lab.datasets.mot import MotSequence
from motes_lab.datasets.sot import Sequence
from motes_lab.protocols.trace import NOWHERE, Row, TrackerOutput, save_trace, trace_of

PIXEL_SHIFTS = (0, -1, 1)
"""Pixels by which `pixel` moves a box, in x and in y: annotators differ by as much."""


class Start(NamedTuple):
    """Where a tracker is started."""

    protocol: str
    """`ope`, `pixel` or `mot`."""
    label: str
    """The name of the start in its protocol, such as `+1`; empty if there is only one."""
    frame: int
    box: Box | None
    """The first frame, and the box given to the tracker there; None in `mot`, which gives no
    box."""


def starts(protocol: str, sequence: Sequence | MotSequence, width: int, height: int) -> list[Start]:
    """Return the starts of a protocol on a sequence whose frames have a width and height."""
    if isinstance(sequence, MotSequence):
        return [Start(protocol, "", 0, None)]
    frame = int(np.flatnonzero(np.isfinite(sequence.boxes).all(axis=1))[0])
    x, y, *size = sequence.boxes[frame].tolist()
    if protocol == "ope":
        return [Start(protocol, "", frame, Box(x, y, *size))]
    boxes = {by: _inside(Box(x + by, y + by, *size), width, height) for by in PIXEL_SHIFTS}
    return [Start(protocol, f"{by:+d}" if by else "0", frame, box) for by, box in boxes.items()]


def _inside(box: Box, frame_width: int, frame_height: int) -> Box:
    """Return a box no larger than the frame, moved so that it lies inside the frame."""
    width, height = min(box.width, frame_width), min(box.height, frame_height)
    x, y = max(min(box.x, frame_width - width), 0.0), max(min(box.y, frame_height - height), 0.0)
    return Box(x, y, width, height)


class TrackerPass:
    """A pass in progress: feed it every frame of the sequence in order, then read its trace.

    Parameters
    ----------
    make_adapter
        Makes the tracker under test.
    start
        Where it starts; earlier frames are skipped.
    """

    def __init__(self, make_adapter: Callable[[], TrackerAdapter], start: Start) -> None:
        self._make_adapter, self._start = make_adapter, start
        self._adapter: TrackerAdapter | None = None
        self._rows: list[Row] = []
        self._last = NOWHERE

    def feed(self, frame: Frame) -> None:
        """Process the next frame."""
        if frame.index < self._start.frame:
            return
        if self._adapter is None:
            self._adapter = self._make_adapter()
            assert self._start.box is not None
            answer = self._adapter.init(frame, self._start.box)
        else:
            answer = self._adapter.update(frame)
        self._last = answer.ellipse or self._last
        self._rows.append(Row(frame.index, self._last, *answer[1:]))

    @property
    def trace(self) -> TrackerOutput:
        """The output so far."""
        return trace_of(self._rows)

    def save(self, path: Path) -> None:
        """Write the trace with `save_trace`."""
        save_trace(path, self.trace)
