"""Perturbed views of a sequence for the protocol `robust`.

A view is a `Sequence` with the truth for its own frames, which `perturbed_frames` makes one by one
from the original's frames. Nothing is random: the same sequence gives the same views.

| view | |
|---|---|
| `original` | from the first frame with the target |
| `mirrored` | left and right exchanged |
| `backward` | from the last frame with the target back to the first |
| `every-second` | without every other frame |
| `from-quarter`, `from-half`, `from-three-quarters` | starts at this part of the sequence |
| `perturbed` | the 12 start boxes of `sre`, each a separate start |
| `gray`, `half-size`, `blurred` | without color; pixels averaged 2 by 2; see `blurred` |
| `hue` | colors rotated about the gray axis by `HUE_ROTATION`, plus `BRIGHTNESS_SHIFT` |
| `occluded` | a piece of the frame passes over the target; see `Occluder` |
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d

from motes.core.errors import SourceError
from motes.core.frame import Frame
from motes.core.types import Floats
from motes.video.sources import open_source
from motes_lab.datasets.sot import Sequence
from motes_lab.dials.appearance import as_bytes, hue_rotation
from motes_lab.protocols.sot import MIN_FRAMES, Start, starts

Pixels = NDArray[np.uint8]

MAX_FRAMES = 200
"""Largest number of frames of a view, by default."""
HUE_ROTATION = math.radians(30)
"""Angle by which `hue` rotates colors, in radians."""
BRIGHTNESS_SHIFT = 30
"""Gray levels that `hue` adds to each channel."""
BLUR = np.array([1, 4, 6, 4, 1]) / 16
"""The binomial filter of `blurred`, used `BLUR_PASSES` times each way; its variance is 1."""
BLUR_PASSES = 4
OCCLUSION_FRAMES = 20
"""Frames during which the occluder moves, if the view is long enough."""


@dataclass(frozen=True, slots=True, eq=False)
class PerturbedSequence(Sequence):
    """A view of a sequence.

    Attributes
    ----------
    original
        The sequence that it is made from.
    view
        The name of the view.
    chosen
        (frames,), the index in the original of each of its frames. The indices have a constant
        step, which is negative in `backward`.
    """

    original: Sequence
    view: str
    chosen: NDArray[np.intp]

    @property
    def digest(self) -> str:
        """The digest of the original."""
        return self.original.digest


def perturbations(
    sequence: Sequence, width: int, height: int, max_frames: int = MAX_FRAMES
) -> list[tuple[PerturbedSequence, list[Start]]]:
    """Return the views of a sequence whose frames have a width and height, each with its starts.

    A view starts with the target and has at most `max_frames` frames. A view with fewer than 5
    frames is left out, except the original.
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
        chosen = path[:max_frames]
        if view != "original" and chosen.size < MIN_FRAMES:
            continue
        boxes, ellipses = sequence.boxes[chosen], sequence.ellipses[chosen]
        if view == "mirrored":
            boxes, ellipses = mirrored(boxes, ellipses, width)
        elif view == "half-size":
            boxes = boxes / 2
            # A pixel's center is at a whole number: 0 and 1 become 0.
            ellipses = ellipses / (2, 2, 2, 2, 1) - (0.25, 0.25, 0, 0, 0)
        seen = PerturbedSequence(
            sequence.name, sequence.source, boxes, ellipses, sequence, view, chosen
        )
        protocol = "sre" if view == "perturbed" else "ope"
        shrink = 2 if view == "half-size" else 1
        view_starts = starts(protocol, seen, width // shrink, height // shrink)
        made.append(
            (seen, [s._replace(protocol="robust", label=s.label or view) for s in view_starts])
        )
    return made


def mirrored(boxes: Floats, ellipses: Floats, width: int) -> tuple[Floats, Floats]:
    """Mirror boxes (n, 4) and ellipses (n, 5) left to right in a frame; twice restores them."""
    boxes, ellipses = boxes.copy(), ellipses.copy()
    boxes[:, 0] = width - boxes[:, 0] - boxes[:, 2]
    ellipses[:, 0] = width - 1 - ellipses[:, 0]
    ellipses[:, 4] *= -1
    return boxes, ellipses


def perturbed_frames(sequence: PerturbedSequence) -> Iterator[Frame]:
    """Yield the frames of a view, numbered from 0; `backward` keeps all of them in memory.

    Raises
    ------
    SourceError
        If the source has too few frames.
    """
    low, high = int(sequence.chosen.min()), int(sequence.chosen.max())
    step = int(sequence.chosen[1] - sequence.chosen[0]) if sequence.frames > 1 else 1
    with open_source(sequence.source, start=low, end=high + 1, stride=abs(step)) as source:
        pictures = reversed(list(source)) if step < 0 else iter(source)
        change = _frame_change(sequence)
        count, first_time = 0, math.nan
        for frame in pictures:
            first_time = frame.time if count == 0 else first_time
            yield Frame(count, abs(frame.time - first_time), change(frame.pixels, count))
            count += 1
        if count < sequence.frames:
            raise SourceError(f"{source.name} ends too early for the view {sequence.view}.")


def _frame_change(sequence: PerturbedSequence) -> Callable[[Pixels, int], Pixels]:
    """Return the function that changes a frame's pixels, given its number in the view."""
    if sequence.view == "occluded":
        return Occluder(sequence.boxes)
    change = {"mirrored": _mirror, "half-size": half_size, **CHANGES}.get(sequence.view)
    return lambda pixels, _: pixels if change is None else change(pixels)


def _mirror(pixels: Pixels) -> Pixels:
    return np.ascontiguousarray(pixels[:, ::-1])


def half_size(pixels: Pixels) -> Pixels:
    """Return means of 2 by 2 pixels; an odd last row or column is left out."""
    height, width = pixels.shape[0] // 2, pixels.shape[1] // 2
    blocks = pixels[: 2 * height, : 2 * width].reshape(height, 2, width, 2, 3)
    return as_bytes(blocks.mean(axis=(1, 3)))


def gray(pixels: Pixels) -> Pixels:
    """Return the luma of Rec. 601 in each channel."""
    luma = as_bytes(pixels @ np.array([0.299, 0.587, 0.114]))
    return np.repeat(luma[:, :, None], 3, axis=2)


def hue_rotated(pixels: Pixels) -> Pixels:
    """Return brighter pixels with colors rotated about the gray axis."""
    return as_bytes(pixels @ hue_rotation(HUE_ROTATION).T + BRIGHTNESS_SHIFT)


def blurred(pixels: Pixels) -> Pixels:
    """Return pixels blurred with a standard deviation of 2 pixels; border pixels are repeated."""
    image = pixels.astype(np.float32)
    for axis in (0, 1) * BLUR_PASSES:
        image = correlate1d(image, BLUR, axis, mode="nearest")
    return as_bytes(image)


CHANGES = {"gray": gray, "hue": hue_rotated, "blurred": blurred}
"""The changes of all pixels that leave the truth as it is."""


class Occluder:
    """Moves a piece of the first frame, as large as the target, over the target.

    The piece is taken from the corner farthest from the target. In the `OCCLUSION_FRAMES` frames in
    the middle of the view (at most a third of it), the piece moves from one target width left of
    the target to one target width right of it; halfway, it covers the target. The truth does not
    change.
    """

    def __init__(self, boxes: Floats) -> None:
        self._boxes = boxes
        self._frames = min(OCCLUSION_FRAMES, len(boxes) // 3)
        self._first = (len(boxes) - self._frames) // 2
        self._piece: Pixels | None = None

    def __call__(self, pixels: Pixels, number: int) -> Pixels:
        """Return the changed pixels of a frame, given its number; frame 0 must come first."""
        if self._piece is None:
            self._piece = _corner(pixels, self._boxes[0])
        box, way = self._boxes[number], number - self._first
        if not 0 <= way < self._frames or not np.isfinite(box).all():
            return pixels
        offset = (way - self._frames // 2) / max(self._frames // 2, 1)
        x, y, width, height = box
        left, top = math.floor(x + offset * width), math.floor(y)
        right, bottom = math.ceil(x + (1 + offset) * width), math.ceil(y + height)
        rows = np.arange(max(top, 0), min(bottom, pixels.shape[0]))
        columns = np.arange(max(left, 0), min(right, pixels.shape[1]))
        image = pixels.copy()
        # The piece is repeated if the target has grown.
        piece = self._piece
        image[np.ix_(rows, columns)] = piece[
            np.ix_((rows - top) % piece.shape[0], (columns - left) % piece.shape[1])
        ]
        return image


def _corner(pixels: Pixels, box: Floats) -> Pixels:
    """Return a piece as large as a box, from the corner of the frame that is farthest from it."""
    x, y, width, height = box
    rows, columns = min(math.ceil(height), len(pixels)), min(math.ceil(width), pixels.shape[1])
    top = 0 if y + height / 2 > pixels.shape[0] / 2 else pixels.shape[0] - rows
    left = 0 if x + width / 2 > pixels.shape[1] / 2 else pixels.shape[1] - columns
    return pixels[top : top + rows, left : left + columns].copy()
