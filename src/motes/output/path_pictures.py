"""Where the objects of a scene have been, as pictures: a heatmap of their feet, and their paths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from motes.core.frame import as_rgb
from motes.core.types import Bytes
from motes.output.scene_overlay import Point, color_of, stretches

SPREAD = 0.01
"""Standard deviation of the spot that a foot leaves, as a share of the frame's diagonal."""
DIM = 0.6
"""Share of its brightness that the frame keeps below the paths."""


def heatmap(pixels: Bytes, seconds: NDArray[np.float64]) -> Bytes:
    """Return a frame with colors for how long feet have been at each place.

    `seconds` (H, W) is the time for which a foot was at each pixel, over all objects.
    """
    from scipy.ndimage import gaussian_filter

    spread = SPREAD * float(np.hypot(*seconds.shape))
    heat = gaussian_filter(seconds.astype(np.float64), spread)
    share = np.sqrt(heat / heat.max()) if heat.max() > 0 else heat
    # From transparent over yellow to red.
    color = np.stack([np.full_like(share, 255), 255 * (1 - share), np.zeros_like(share)], axis=2)
    opacity = 0.8 * share[:, :, None]
    mixed = (1 - opacity) * as_rgb(pixels) + opacity * color
    heated: Bytes = np.rint(mixed).clip(0, 255).astype(np.uint8)
    return heated


def paths(pixels: Bytes, feet: Mapping[int, Sequence[Point]]) -> Bytes:
    """Return a darkened frame with the path of each identity's foot in its color; a dot ends it.

    A place that is NaN interrupts a path.
    """
    from PIL import Image, ImageDraw

    image = Image.fromarray(np.rint(DIM * as_rgb(pixels)).astype(np.uint8))
    pen = ImageDraw.Draw(image)
    width = max(1, round(min(image.size) / 240))
    for identity, points in feet.items():
        for part in (parts := stretches(points)):
            if len(part) > 1:
                pen.line(part.ravel().tolist(), color_of(identity), width)
        x, y = parts[-1][-1].tolist()
        reach = 2 * width
        pen.ellipse((x - reach, y - reach, x + reach, y + reach), fill=color_of(identity))
    return np.array(image)
