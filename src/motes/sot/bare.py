"""Notes on a region that a user marks: it holds nothing to follow, or the border may cut it.

What can be followed changes the picture when it moves. So the region is compared with itself a
quarter of its size farther, in eight directions: on a wall all of them show the same, and on a
border of two walls those along it. A faint object changes little too, but more than the places
beside it.
"""

from __future__ import annotations

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.search_window import cut

SIDE, SHIFT = 8, 2
"""Samples along a side of the region, and how far it is moved; more samples show more noise."""
FLAT = 7.0
"""Smallest change of a region with something in it, in levels of 256: among 97 real targets the
least has 11.6, and of plain places of their films (standard deviation below 6) 98 % are below."""
ALIKE = 1.5
"""A region whose change is this many times that of the places around it is none of them."""


def bare_note(frame: Frame, region: Ellipse) -> str | None:
    """Return one line about a region that holds nothing to follow; None for all others."""
    changes = _changes(frame, region)
    own = changes[1, 1]
    if own >= FLAT or own > ALIKE * np.nanmedian(changes):
        return None
    box = region.box
    return (
        f"The region at x={box.x:.0f}, y={box.y:.0f}, {box.width:.0f}x{box.height:.0f} in frame "
        f"{frame.index} looks like what is around it: there is nothing to follow, and the track "
        f"may slide anywhere. Draw it around something that stands out."
    )


def cut_note(frame: Frame, region: Ellipse) -> str | None:
    """Return one line about a region that the picture's border cuts; None for all others."""
    if region.box.room(frame.width, frame.height) > 0:
        return None
    return (
        f"The region in frame {frame.index} reaches the border of the picture. If that cuts the "
        f"target, its size is wrong in all frames that follow; mark it where all of it is seen."
    )


def _changes(frame: Frame, region: Ellipse) -> Floats:
    """Return how much a region (1, 1), and the eight around it, change at least when moved.

    They are (3, 3), standard deviations of differences; NaN for what is outside of the frame.
    """
    width = 3 * SIDE + 2 * SHIFT
    samples = cut(frame, region, (2 * region.a / SIDE, 2 * region.b / SIDE), (width, width))
    ends = (0, SHIFT, 2 * SHIFT)
    moved = np.stack(
        [samples[:, y : y + 3 * SIDE, x : x + 3 * SIDE] for y in ends for x in ends]
    ).reshape(9, 3, 3, SIDE, 3, SIDE)
    moved = np.delete(moved - moved[4], 4, axis=0)
    out: Floats = np.sqrt(moved.var(axis=(3, 5)).mean(axis=1).min(axis=0)).astype(np.float64)
    across, down = np.meshgrid((-2, 0, 2), (-2, 0, 2))
    cosine, sine = np.cos(region.theta), np.sin(region.theta)
    x = region.x + across * region.a * cosine - down * region.b * sine
    y = region.y + across * region.a * sine + down * region.b * cosine
    right, low = frame.width - 0.5, frame.height - 0.5
    out[(x < -0.5) | (y < -0.5) | (x > right) | (y > low)] = np.nan
    return out
