"""Views of a sequence for the protocol `robust`: the same target seen otherwise.

A view is a `Sequence` of its own, with the truth of its pictures, which `show` makes one
by one from the original's. Nothing is random: the same sequence gives the same views.

| view | |
|---|---|
| `original` | from the first frame with the target |
| `mirrored` | left is right |
| `backward` | from the last frame with the target to the first |
| `every-second` | without every other frame |
| `from-quarter`, `from-half`, `from-three-quarters` | begins so far into the film |
| `perturbed` | the 12 first boxes of `sre`, each a start of its own |
| `gray`, `half-size`, `blurred` | without color; pixels averaged 2 by 2; see `blurred` |
| `hue` | colors turned about the gray axis by `TURN`, and `BRIGHTER` |
| `occluded` | a piece of the picture passes over the target; see `Occluder` |
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motes.core.errors import SourceError
from motes.core.frame import Frame
from motes.evaluation.datasets.sot import Sequence
from motes.evaluation.protocols.sot import SHORTEST, Start, starts
from motes.video.sources import open_source

Floats = NDArray[np.float64]
Pixels = NDArray[np.uint8]

LONGEST = 200
"""Frames of a view, unless somebody says otherwise."""
TURN = math.radians(30)
"""How far colors are turned in `hue`."""
BRIGHTER = 30
"""What is added to each channel in `hue`."""
BLUR = np.array([1, 4, 6, 4, 1]) / 16
"""The binomial filter that `blurred` applies `BLURS` times each way; its variance is 1."""
BLURS = 4
OCCLUSION = 20
"""Frames in which the occluder is on its way, where the view is long enough."""


@dataclass(frozen=True, slots=True, eq=False)
class Viewed(Sequence):
    """A view of a sequence.

    Attributes
    ----------
    original
        The sequence that it is a view of.
    view
        Which one.
    chosen
        (frames,), the original's frame that each of its frames is made from: in steps of one size,
        which is negative in `backward`.
    """

    original: Sequence
    view: str
    chosen: NDArray[np.intp]

    @property
    def digest(self) -> str:
        """The original's."""
        return self.original.digest


def perturbations(
    sequence: Sequence, width: int, height: int, longest: int = LONGEST
) -> list[tuple[Viewed, list[Start]]]:
    """Return the views of a sequence with frames of a width and height, and where each starts.

    A view has at most `longest` frames, and begins with the target; one that would have fewer than
    5 frames is left out, but for the original.
    """
    there = np.flatnonzero(np.isfinite(sequence.boxes).all(axis=1))
    first, last, length = int(there[0]), int(there[-1]), sequence.frames
    whole = np.arange(first, length)
    paths = {"original": whole, "mirrored": whole, "backward": np.arange(last, -1, -1)}
    paths["every-second"] = whole[::2]
    for quarter, name in enumerate(("from-quarter", "from-half", "from-three-quarters"), 1):
        later = there[there >= quarter * length // 4]
        paths[name] = np.arange(later[0] if later.size else length, length)
    paths |= dict.fromkeys(("perturbed", *CHANGES, "half-size", "occluded"), whole)
    made = []
    for view, path in paths.items():
        chosen = path[:longest]
        if view != "original" and chosen.size < SHORTEST:
            continue
        boxes, ellipses = sequence.boxes[chosen], sequence.ellipses[chosen]
        if view == "mirrored":
            boxes, ellipses = mirrored(boxes, ellipses, width)
        elif view == "half-size":
            boxes = boxes / 2
            # A pixel's center is at a whole number: 0 and 1 become 0.
            ellipses = ellipses / (2, 2, 2, 2, 1) - (0.25, 0.25, 0, 0, 0)
        seen = Viewed(sequence.name, sequence.source, boxes, ellipses, sequence, view, chosen)
        protocol = "sre" if view == "perturbed" else "ope"
        shrink = 2 if view == "half-size" else 1
        begins = starts(protocol, seen, width // shrink, height // shrink)
        made.append((seen, [s._replace(protocol="robust", label=s.label or view) for s in begins]))
    return made


def mirrored(boxes: Floats, ellipses: Floats, width: int) -> tuple[Floats, Floats]:
    """Return boxes (n, 4) and ellipses (n, 5) where left is right; twice gives them back."""
    boxes, ellipses = boxes.copy(), ellipses.copy()
    boxes[:, 0] = width - boxes[:, 0] - boxes[:, 2]
    ellipses[:, 0] = width - 1 - ellipses[:, 0]
    ellipses[:, 4] *= -1
    return boxes, ellipses


def show(sequence: Viewed) -> Iterator[Frame]:
    """Yield the frames of a view, numbered from 0; `backward` holds all of its pictures at once.

    Raises
    ------
    SourceError
        If the source has too few frames.
    """
    low, high = int(sequence.chosen.min()), int(sequence.chosen.max())
    step = int(sequence.chosen[1] - sequence.chosen[0]) if sequence.frames > 1 else 1
    with open_source(sequence.source, start=low, end=high + 1, stride=abs(step)) as source:
        pictures = reversed(list(source)) if step < 0 else iter(source)
        change = _change(sequence)
        count, begin = 0, math.nan
        for frame in pictures:
            begin = frame.time if count == 0 else begin
            yield Frame(count, abs(frame.time - begin), change(frame.pixels, count))
            count += 1
        if count < sequence.frames:
            raise SourceError(f"{source.name} ends too early for the view {sequence.view}.")


def _change(sequence: Viewed) -> Callable[[Pixels, int], Pixels]:
    """Return what makes a view's picture of the original's and its number in the view."""
    if sequence.view == "occluded":
        return Occluder(sequence.boxes)
    change = {"mirrored": _mirror, "half-size": halved, **CHANGES}.get(sequence.view)
    return lambda pixels, _: pixels if change is None else change(pixels)


def _mirror(pixels: Pixels) -> Pixels:
    return np.ascontiguousarray(pixels[:, ::-1])


def halved(pixels: Pixels) -> Pixels:
    """Return means of 2 by 2 pixels; an odd last row or column is left out."""
    height, width = pixels.shape[0] // 2, pixels.shape[1] // 2
    blocks = pixels[: 2 * height, : 2 * width].reshape(height, 2, width, 2, 3)
    return _bytes(blocks.mean(axis=(1, 3)))


def gray(pixels: Pixels) -> Pixels:
    """Return the luma of Rec. 601 in each channel."""
    luma = _bytes(pixels @ np.array([0.299, 0.587, 0.114]))
    return np.repeat(luma[:, :, None], 3, axis=2)


def turned(pixels: Pixels) -> Pixels:
    """Return colors turned about the gray axis (Rodrigues' formula), and brighter."""
    axis = np.full(3, 1 / math.sqrt(3))
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(3) + math.sin(TURN) * cross + (1 - math.cos(TURN)) * cross @ cross
    return _bytes(pixels @ turn.T + BRIGHTER)


def blurred(pixels: Pixels) -> Pixels:
    """Return pixels blurred with a standard deviation of 2 pixels; borders are repeated."""
    image, edge = pixels.astype(np.float32), BLUR.size // 2
    for axis in (0, 1) * BLURS:
        padding = [(edge, edge) if i == axis else (0, 0) for i in range(3)]
        windows = np.lib.stride_tricks.sliding_window_view(
            np.pad(image, padding, mode="edge"), BLUR.size, axis=axis
        )
        image = windows @ BLUR.astype(np.float32)
    return _bytes(image)


CHANGES = {"gray": gray, "hue": turned, "blurred": blurred}
"""What changes every pixel and no truth."""


class Occluder:
    """Pastes a piece of the first picture, as large as the target, on its way over the target.

    The piece is what lies in the corner farthest from the target. In the `OCCLUSION` frames in the
    middle of the view (a third of it, if that is fewer) it goes from a target's width left of the
    target to as far right of it; halfway, it covers the target. The truth stays.
    """

    def __init__(self, boxes: Floats) -> None:
        self._boxes = boxes
        self._frames = min(OCCLUSION, len(boxes) // 3)
        self._begin = (len(boxes) - self._frames) // 2
        self._piece: Pixels | None = None

    def __call__(self, pixels: Pixels, number: int) -> Pixels:
        """Return the picture of a number in the view; the first must come first."""
        if self._piece is None:
            self._piece = _corner(pixels, self._boxes[0])
        box, way = self._boxes[number], number - self._begin
        if not 0 <= way < self._frames or not np.isfinite(box).all():
            return pixels
        offset = (way - self._frames // 2) / max(self._frames // 2, 1)
        x, y, width, height = box
        left, top = math.floor(x + offset * width), math.floor(y)
        right, bottom = math.ceil(x + (1 + offset) * width), math.ceil(y + height)
        rows = np.arange(max(top, 0), min(bottom, pixels.shape[0]))
        columns = np.arange(max(left, 0), min(right, pixels.shape[1]))
        image = pixels.copy()
        # Where the target has grown, the piece is repeated.
        piece = self._piece
        image[np.ix_(rows, columns)] = piece[
            np.ix_((rows - top) % piece.shape[0], (columns - left) % piece.shape[1])
        ]
        return image


def _corner(pixels: Pixels, box: Floats) -> Pixels:
    """Return a piece as large as a box, from the corner of a picture that is farthest from it."""
    x, y, width, height = box
    rows, columns = min(math.ceil(height), len(pixels)), min(math.ceil(width), pixels.shape[1])
    top = 0 if y + height / 2 > pixels.shape[0] / 2 else pixels.shape[0] - rows
    left = 0 if x + width / 2 > pixels.shape[1] / 2 else pixels.shape[1] - columns
    return pixels[top : top + rows, left : left + columns].copy()


def _bytes(values: NDArray[np.floating]) -> Pixels:
    result: Pixels = np.clip(np.rint(values), 0, 255).astype(np.uint8)
    return result
