"""The reader of a source: the interface of all kinds, and counts of what is read and of errors."""

from __future__ import annotations

from abc import abstractmethod
from collections import Counter
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import DEPTHS, depth_note, exceeds

DEPTH_SAMPLES = 9
"""Pictures, evenly spread, by which the depth of a film of 16 bits is found."""
MAX_ASPECT = 1.25
"""Pixels wider or higher than this are reported: round objects then no longer look round."""


@dataclass(slots=True)
class Report:
    """What was read so far, and the errors."""

    decoded: int = 0
    """Decoded pictures, including those that `start` and `stride` pass over."""
    skipped: int = 0
    """Packets that could not be decoded."""
    breaks: int = 0
    """Packets that their container marks as damaged, or as not next to the one before."""
    damaged: int = 0
    """Pictures decoded with missing parts, which the decoder filled in."""
    retimed: int = 0
    """Pictures whose time stamp was missing, did not increase, or was contradicted by those around.
    They get the time of the picture before plus the nominal interval, or less where the next stamps
    leave less room."""
    steps: Counter[int] = field(default_factory=Counter)
    """How often each time between two pictures with right stamps occurred, in units of `UNIT`."""
    UNIT: ClassVar[float] = 1e-4
    """In seconds."""
    ended: float | None = None
    expected: float | None = None
    """For a source that was cut off: its real end and the end given in its header, in seconds."""
    left_out: int = 0
    """Pictures after the first one in animated files of a folder of images."""
    late: int = 0
    """Frames of a live source that were left out, as a newer one had come before they were used."""
    drops: int = 0
    """Number of times that a live source ended or failed and had to be opened again."""
    assumed: bool = False
    """Whether the source is images without a frame rate, so that one was assumed."""
    leap: str | None = None
    """One line about names of images that do not follow each other; None if all do."""
    depth: int | None = None
    """How many of their 16 bits the pictures of the source use; None for pictures of 8."""
    coarse: bool = False
    """Whether of colors of 16 bits only the high 8 are read."""
    brighter: int = 0
    """Pictures with more than a few pixels that are too bright for this depth; these are white."""
    aspect: float = 1.0
    """Width of a pixel divided by its height, 1 if unknown. Frames are not rescaled."""

    def count_depth(self, values: NDArray[np.uint16], depth: int) -> None:
        """Note the depth of a source of 16 bits, and whether a picture is brighter."""
        self.depth = depth
        self.brighter += exceeds(values, depth)

    @property
    def truncated(self) -> bool:
        """Whether the source ended before the end given in its header."""
        return self.ended is not None

    @property
    def lost(self) -> int:
        """Pictures that are missing in the gaps of a damaged source with one step in most places.

        A gap in an undamaged one is no loss: its camera sent no picture.
        """
        if not (self.damaged or self.skipped or self.breaks) or not self.steps:
            return 0
        usual, count = self.steps.most_common(1)[0]
        if not usual or 2 * count < self.steps.total():
            return 0
        return sum(
            each * (round(step / usual) - 1) for step, each in self.steps.items() if step > usual
        )

    @property
    def assumption(self) -> str | None:
        """One line about what is assumed of the source, such as its rate; None if nothing."""
        parts = [self.leap] if self.leap else []
        if self.depth is not None and self.depth < DEPTHS[-1]:
            parts.append(depth_note(self.depth))
        if self.coarse:
            parts.append("of its colors of 16 bits the high 8 are read; scale darker ones first.")
        if self.assumed:
            parts.append(
                "the images have no frame rate, 25 a second are assumed; give --fps if it is "
                "another."
            )
        return " ".join(parts) or None

    @property
    def problems(self) -> str | None:
        """One line about the errors, or None if there were none."""
        odd = not 1 / MAX_ASPECT < self.aspect < MAX_ASPECT
        told = (
            (self.skipped, f"{self.skipped} unreadable packet(s) skipped"),
            (self.damaged, f"{self.damaged} picture(s) damaged"),
            (self.lost, f"{self.lost} picture(s) lost"),
            (self.truncated, f"cut off at {self.ended or 0:.2f} s of {self.expected or 0:.2f} s"),
            (self.retimed, f"{self.retimed} missing or wrong time stamp(s) replaced"),
            (
                self.left_out,
                f"{self.left_out} picture(s) left out, those after the first in an animated file",
            ),
            (self.brighter, f"{self.brighter} picture(s) too bright for {self.depth} bits"),
            (self.late, f"{self.late} frame(s) left out, as newer ones had come"),
            (self.drops, f"dropped {self.drops} time(s)"),
            (odd, f"pixels are {self.aspect:.2f} times as wide as high, and left so"),
        )
        return "; ".join(text for has, text in told if has) or None


Load = Callable[[], NDArray[np.uint8]]
Stamped = tuple[float | None, Load]
"""Time stamp in seconds, or None, and a function that returns the pixels."""


class Reader:
    """The pictures of one kind of source; all other steps are the same for all kinds."""

    fps: float | None = None
    """Nominal frames per second; None if unknown."""
    duration: float | None = None
    """Length in seconds; None if unknown."""
    count: int | None = None
    """Estimated number of pictures; None if unknown."""
    live = False
    """Whether pictures may arrive in real time, without an end: the source gives no duration."""

    @property
    def realtime(self) -> bool:
        """Whether pictures certainly arrive in real time, so that old ones may be left out."""
        return False

    @property
    def files(self) -> Sequence[str]:
        """The paths of the pictures in the folder of all of them; none of a video."""
        return ()

    @abstractmethod
    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures in order; the pixels are converted only where they are used."""

    def stop(self) -> None:
        """Stop waiting for pictures: no more come; any thread may call this."""

    def close(self) -> None:
        """Close the file, camera or connection."""
