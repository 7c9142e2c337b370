"""Dense features over the part of a frame that ellipses cover, computed once for each frame."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import TypeVar

from motes import kernels
from motes.core.frame import Frame
from motes.core.types import Bytes, Floats


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """The orientation of edges over a part of a frame, one for each block of pixels."""

    column: int
    row: int
    """Column and row of the first block."""
    step: int
    """Side of a block in pixels."""
    bins: Bytes
    """(H, W), number of each block's bin of orientation."""

    def in_blocks(self, ellipses: Floats) -> Floats:
        """Return ellipses (N, 5) in units of blocks."""
        out = ellipses.copy()
        out[:, :2] = (out[:, :2] + 0.5) / self.step - 0.5
        out[:, 2:4] /= self.step
        return out

    def covers(self, part: tuple[int, int, int, int]) -> bool:
        """Return whether it has the blocks `part`, as `blocks` returns them."""
        left, top, right, bottom = part
        height, width = self.bins.shape
        return (
            self.column <= left
            and self.row <= top
            and right <= self.column + width
            and bottom <= self.row + height
        )


P = TypeVar("P", bound=Plane)


def plane_over(
    frame: Frame,
    part: tuple[int, int, int, int],
    key: Hashable,
    compute: Callable[[int, int, tuple[int, int]], P],
) -> P:
    """Return a plane that covers a part (see `blocks`); the frame keeps the plane under `key`.

    `compute` makes a plane from the first column and row of its blocks, and its shape.
    """
    plane: P | None = frame.cache.get(key)
    if plane is None or not plane.covers(part):
        left, top, right, bottom = part
        plane = frame.cache[key] = compute(left, top, (bottom - top, right - left))
    return plane


def blocks(frame: Frame, ellipses: Floats, step: int) -> tuple[int, int, int, int]:
    """Return the blocks that ellipses cover: first column and row, and those after the last.

    Ellipses with NaN or infinity cover none; there is always one block.
    """
    columns, rows = -(-frame.width // step), -(-frame.height // step)
    ends = kernels.sampling.bounds(ellipses)
    if ends[0] > ends[2]:
        return 0, 0, 1, 1
    # A pixel reaches from half a pixel before its center to half a pixel behind it.
    left, top, right, bottom = (int((end + 0.5) // step) for end in ends)
    first, above = min(max(left, 0), columns - 1), min(max(top, 0), rows - 1)
    last, below = min(max(right, first), columns - 1), min(max(bottom, above), rows - 1)
    return first, above, last + 1, below + 1
