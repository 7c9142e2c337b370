"""Which pixels differ from a background by their light alone, or by a tremble of the camera.

A shadow, a reflection or a cloud scales a pixel's colors by about the same factor and leaves the
edges of the background where they were. An object brings edges and colors of its own.
"""

from __future__ import annotations

import numpy as np

from motes.mot.detection.images import (
    Mask,
    Singles,
    closed,
    components,
    largest,
    mean,
    smallest,
)

WINDOW = 3
"""Colors are means over a window of this width and height; noise changes single pixels."""
EDGES = 5
"""Edges are compared over a window of this width and height."""


class Background:
    """A picture of the background, with what `changed` compares.

    Parameters
    ----------
    pixels
        (H, W, 3), the picture.
    noise
        A pixel with a color between the smallest and the largest of its neighborhood is background,
        with this margin in gray levels: a camera that trembles moves colors by a pixel.
    """

    def __init__(self, pixels: Mask, noise: float) -> None:
        margin, window = np.int16(np.ceil(noise)), (WINDOW, WINDOW)
        self.low = smallest(pixels, window) - np.minimum(smallest(pixels, window), margin)
        self.high = largest(pixels, window) + np.minimum(255 - largest(pixels, window), margin)
        self.colors = mean(pixels.astype(np.float32), WINDOW)
        self.across, self.down = _gradients(pixels)


def without_light(
    mask: Mask,
    pixels: Mask,
    background: Background,
    *,
    shadow: float,
    highlight: float,
    tint: float,
    texture: float,
) -> Mask:
    """Return a mask without the pixels that differ from the background by their light alone.

    Parameters
    ----------
    mask
        (H, W) of 0 and 1, the pixels that differ from the background.
    pixels
        (H, W, 3), the frame.
    background
        The background.
    shadow, highlight
        Least and largest share of its brightness that a pixel has in another light; none has
        another light if both are 1.
    tint
        Largest change of a color by light, beside the factor, in gray levels.
    texture
        Largest mean difference of the gradients from those of the background, beside the factor, in
        gray levels per pixel.
    """
    y, x = np.nonzero(mask)
    if shadow == highlight == 1 or not len(y):
        return mask
    seen, usual = mean(pixels.astype(np.float32), WINDOW)[y, x], background.colors[y, x]
    factor = (seen.sum(axis=1) + 1) / (usual.sum(axis=1) + 1)
    tinted = np.abs(seen - factor[:, None] * usual).max(axis=1)
    across, down = _gradients(pixels)
    edges = np.zeros(mask.shape, np.float32)
    edges[y, x] = np.abs(across[y, x] - factor * background.across[y, x])
    edges[y, x] += np.abs(down[y, x] - factor * background.down[y, x])
    share = np.maximum(mean(mask.astype(np.float32), EDGES)[y, x], 1 / EDGES**2)
    own_edges = mean(edges, EDGES)[y, x] / share
    lit = (factor > shadow) & (factor < highlight) & (tinted < tint) & (own_edges < texture)
    out = mask.copy()
    out[y[lit], x[lit]] = 0
    return out


def with_enclosed(mask: Mask, before: Mask) -> Mask:
    """Return a mask with the pixels of the one before that it encloses.

    A shadow lies beside an object. What looks like one inside of an outline is the object, such as
    a gray shirt before a white wall.

    Parameters
    ----------
    mask, before
        (H, W) of 0 and 1, without and with the pixels that light may explain.
    """
    labels, parts = components(1 - closed(mask, (EDGES, EDGES)), corners=False)
    x, y, width, height, _ = parts.T
    inside = (x > 0) & (y > 0) & (x + width < mask.shape[1]) & (y + height < mask.shape[0])
    enclosed = np.concatenate([[False], inside])[labels]
    out: Mask = mask | (before & enclosed)
    return out


def without_tremble(mask: Mask, pixels: Mask, background: Background) -> Mask:
    """Return a mask without the pixels whose color the background has in their neighborhood."""
    y, x = np.nonzero(mask)
    own, out = pixels[y, x], np.zeros_like(mask)
    apart = ((own < background.low[y, x]) | (own > background.high[y, x])).any(axis=1)
    out[y[apart], x[apart]] = 1
    return out


def _gradients(pixels: Mask) -> tuple[Singles, Singles]:
    """Return the gradients of a picture's green in x and in y, in gray levels per pixel."""
    green = mean(pixels[:, :, 1].astype(np.float32), WINDOW)
    across, down = np.zeros_like(green), np.zeros_like(green)
    across[:, 1:-1] = (green[:, 2:] - green[:, :-2]) / 2
    down[1:-1] = (green[2:] - green[:-2]) / 2
    return across, down
