"""NanoTrack: a backbone that makes features of pictures, and a head that compares two of them.

The template shows the target with half of its mean side around it on each side, in 127x127 pixels;
the region of search is twice as wide, in 255x255. Each of 16x16 cells, 16 pixels apart, has two
scores, of the background and of the target, and the distances to the four sides of its box.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from motes.core.config import Config
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.onnx_session import Session, Tensor
from motes.core.types import Floats, Singles
from motes.sot.network.network import NetworkFamily
from motes.sot.network.view import (
    BLACK,
    Choice,
    NetworkView,
    Square,
    extent,
    hann,
    mean_color,
    reaches_outside,
    read,
    view_of,
)

TEMPLATE, SEARCH = 127, 255
STRIDE, CELLS, TEMPLATE_CELLS = 16, 16, 8


class Siamese(NetworkFamily, Config, frozen=True, tag="siamese"):
    """A backbone and a head, such as NanoTrack's."""

    known_as = (
        "NanoTrack's two (a backbone of pictures, and a head of features 8x8 and 16x16, which "
        "gives 2x16x16 scores and 4x16x16 distances)"
    )
    open_sizes = True

    def arranged(self, files: Sequence[Session]) -> tuple[Session, ...] | None:
        """Return backbone and head; see `NetworkFamily`."""
        backbones = [each for each in files if _is_backbone(each)]
        heads = [each for each in files if _is_head(each)]
        if len(files) != 2 or len(backbones) != 1 or len(heads) != 1:
            return None
        return backbones[0], heads[0]

    def learn(self, sessions: Sequence[Session], frame: Frame, ellipse: Ellipse) -> Singles:
        """Return the features of the template (1, C, 8, 8)."""
        region = Square.around(ellipse.x, ellipse.y, float(extent(*ellipse.box[2:])))
        return features(sessions[0], frame, region, TEMPLATE)

    def look(
        self, sessions: Sequence[Session], template: Singles, frame: Frame, place: Ellipse
    ) -> NetworkView:
        """Return what the network sees around a place; see `NetworkFamily`."""
        backbone, head = sessions
        size = place.box[2:]
        region = Square.around(place.x, place.y, float(extent(*size)) * SEARCH / TEMPLATE)
        (first, *_), (*_, last) = (_with_sides(head.inputs, n) for n in (TEMPLATE_CELLS, CELLS))
        seen = features(backbone, frame, region, SEARCH)
        outputs = head.run({first: template, last: seen})
        by_channels = {
            each.shape[1]: each[0].reshape(each.shape[1], -1) for each in outputs.values()
        }
        background, target = by_channels[2].astype(np.float64)
        with np.errstate(over="ignore", invalid="ignore"):  # the score is 0 then, or no number
            scores: Floats = 1 / (1 + np.exp(background - target))
        corner = np.array([region.left, region.top] * 2)
        sides = corner + region.side / SEARCH * (_points() + _SIGNS * by_channels[4].T)
        return view_of(sides, scores, hann(CELLS, zero_at_border=True), size, Choice())


def _is_backbone(file: Session) -> bool:
    return (
        len(file.inputs) == len(file.outputs) == 1
        and file.inputs[0].holds(1, 3, SEARCH, SEARCH)
        and len(file.outputs[0].shape) == 4
    )


def _is_head(file: Session) -> bool:
    if len(file.inputs) != 2 or len(file.outputs) != 2:
        return False
    return all(_with_sides(file.inputs, side) for side in (TEMPLATE_CELLS, CELLS)) and all(
        any(out.holds(1, channels, CELLS, CELLS) for out in file.outputs) for channels in (2, 4)
    )


def _with_sides(inputs: Sequence[Tensor], side: int) -> list[str]:
    """Return the names of features with `side` rows and columns."""
    return [
        each.name
        for each in inputs
        if len(each.shape) == 4 and each.holds(1, each.shape[1] or 1, side, side)
    ]


def features(backbone: Session, frame: Frame, region: Square, size: int) -> Singles:
    """Return the backbone's features (1, C, h, w) of a region, read in `size` rows and columns."""
    fill = mean_color(frame) if reaches_outside(frame, region) else BLACK
    pixels = read(frame, region, size, fill)
    (out,) = backbone.run({backbone.inputs[0].name: pixels}).values()
    return out


_SIGNS = np.array([-1.0, -1.0, 1.0, 1.0])


@cache
def _points() -> Floats:
    """Return the points (256, 4) from which boxes are measured, x, y, x, y, in a `Box`'s pixels.

    Cell 8 is the middle: pixel 127 of 0 to 254, whose center is 127.5 from the left side.
    """
    line = (np.arange(CELLS) - CELLS // 2) * STRIDE + SEARCH / 2
    x, y = np.meshgrid(line, line)
    return np.stack([x, y, x, y], axis=-1).reshape(-1, 4)
