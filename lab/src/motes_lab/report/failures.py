"""Images of the frames in which trackers failed, with the truth and the estimate."""

from __future__ import annotations

import io
import math
from base64 import b64encode
from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from motes.core.errors import MotesError
from motes.core.types import Floats
from motes.video.sources import open_source
from motes_lab.aggregate import Evaluation
from motes_lab.datasets.sot import Sequence
from motes_lab.metrics import sot as metrics
from motes_lab.scores import MISS_IOU, Outcome

MAX_PICTURES = 24
"""Largest number of images in a report, spread over trackers and sequences."""

MIN_FAILURE_FRAMES = 5
"""Smallest number of frames of a failure."""

WIDTH = 480
"""Largest width of an image, in pixels."""

TRUTH, ESTIMATE, HALO = (60, 230, 90), (255, 60, 40), (0, 0, 0)
_QUALITY = 80


class Failure(NamedTuple):
    """The frame in which a tracker began to fail.

    Attributes
    ----------
    tracker, sequence, frame
        The tracker's name, the sequence, and the index of the frame.
    truth, estimate
        (4,), boxes x, y, w, h; the estimate is NaN if the tracker gave none.
    confidence
        NaN if the tracker gives none.
    lost
        Whether the tracker reported the loss.
    """

    tracker: str
    sequence: Sequence
    frame: int
    truth: Floats
    estimate: Floats
    confidence: float
    lost: bool


class Picture(NamedTuple):
    """An image of a failure as a JPEG file, and its size in pixels."""

    failure: Failure
    jpeg: bytes
    width: int
    height: int

    @property
    def base64(self) -> str:
        """The file as text."""
        return b64encode(self.jpeg).decode()

    @property
    def caption(self) -> str:
        """What it shows."""
        failed = self.failure
        confidence = "none" if math.isnan(failed.confidence) else f"{failed.confidence:.2f}"
        lost = "yes" if failed.lost else "no"
        return (
            f"{failed.sequence.name}, {failed.tracker}, frame {failed.frame}: "
            f"confidence {confidence}, reported lost: {lost}"
            + ("" if np.isfinite(failed.estimate).all() else ", no estimate")
        )


def failures(evaluation: Evaluation) -> list[Failure]:
    """Return the first failure of each tracker on each sequence, in a pass with the lowest seed.

    It is the frame from which the IoU stays below 0.1 for at least `MIN_FAILURE_FRAMES` frames with
    a target.
    """
    if "ope" not in evaluation.protocols:
        return []
    found = []
    for tracker in evaluation.trackers:
        seen: set[str] = set()
        for outcome in evaluation.passes(tracker, "ope").outcome:  # in the order of seeds
            if outcome.item.sequence not in seen:
                seen.add(outcome.item.sequence)
                found += _failure(outcome)
    return found


def _failure(outcome: Outcome) -> list[Failure]:
    trace, fit = outcome.trace, outcome.fit
    assert trace is not None
    assert fit is not None
    missed = np.concatenate([fit.overlaps < MISS_IOU, np.zeros(MIN_FAILURE_FRAMES, bool)])
    runs = np.lib.stride_tricks.sliding_window_view(missed, MIN_FAILURE_FRAMES).all(axis=1)
    if not runs.any():
        return []
    row = fit.rows[runs.argmax()]
    frame = int(trace.frames[row])
    return [
        Failure(
            outcome.item.tracker,
            outcome.sequence,
            frame,
            outcome.sequence.boxes[frame],
            metrics.enclosing_boxes(trace.ellipses[row : row + 1])[0],
            float(trace.confidence[row]),
            bool(trace.lost[row]),
        )
    ]


def choose(found: list[Failure], count: int = MAX_PICTURES) -> list[Failure]:
    """Return at most `count` failures, spread evenly over trackers and sequences."""
    left, chosen = list(range(len(found))), list[int]()
    trackers, sequences = Counter[str](), Counter[str]()
    while left and len(chosen) < count:
        best = min(
            left, key=lambda i: (trackers[found[i].tracker], sequences[found[i].sequence.name], i)
        )
        left.remove(best)
        chosen.append(best)
        trackers[found[best].tracker] += 1
        sequences[found[best].sequence.name] += 1
    return [found[i] for i in sorted(chosen)]


def draw(chosen: list[Failure]) -> tuple[list[Picture], list[str]]:
    """Return the images of failures, in their order, and the reasons why some are missing.

    Each video is decoded once.
    """
    pictures: dict[int, Picture] = {}
    reasons = []
    for sequence in {id(failure.sequence): failure.sequence for failure in chosen}.values():
        own = [i for i, failure in enumerate(chosen) if failure.sequence is sequence]
        frames = [chosen[i].frame for i in own]
        try:
            with open_source(sequence.source, start=min(frames), end=max(frames) + 1) as source:
                for frame in source:
                    for i in own:
                        if chosen[i].frame == frame.index:
                            pictures[i] = _draw(chosen[i], frame.pixels)
        except (MotesError, OSError) as error:
            reasons.append(f"No pictures of {sequence.name}: {error}")
    return [pictures[i] for i in sorted(pictures)], reasons


def _draw(failure: Failure, pixels: NDArray[np.uint8]) -> Picture:
    image = Image.fromarray(pixels)
    scale = min(1.0, WIDTH / image.width)
    size = round(image.width * scale), max(1, round(image.height * scale))
    image = image.resize(size, Image.Resampling.LANCZOS)
    canvas = ImageDraw.Draw(image)
    for box, color in ((failure.estimate, ESTIMATE), (failure.truth, TRUTH)):
        if np.isfinite(box).all():
            x, y, width, height = box
            low = (np.array([x, y]) + 0.5) * scale - 0.5
            high = low + np.maximum(np.array([width, height]) * scale, 1)
            # Limited to the image, so that no coordinate is too large to draw.
            corners = np.clip([*low, *high], -4, max(size) + 4)
            for out, shade, thickness in ((2, HALO, 4), (1, color, 2)):
                outline = (corners + np.array([-out, -out, out, out])).tolist()
                canvas.rectangle(outline, outline=shade, width=thickness)
    file = io.BytesIO()
    image.save(file, "JPEG", quality=_QUALITY)
    return Picture(failure, file.getvalue(), *image.size)
