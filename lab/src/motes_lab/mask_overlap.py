"""Masks of tracked targets against the truth, beside those of GrabCut on the same boxes."""

from __future__ import annotations

import time
from collections.abc import Callable
from collections.abc import Sequence as Many
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray
from PIL import Image

from motes import Box, Ellipse, Frame, SourceError, Status, Tracker, open_source
from motes.cli import check_counts
from motes.core import Bytes, Flags, iou
from motes.sot import Segmenter
from motes_lab.datasets.sot import Sequence
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import RUN, FirstPixel, Only, films_of
from motes_lab.metrics.statistics import over
from motes_lab.report.tables import Cell, Row, Table, number

WAYS = ("tracked ellipse", "motes", "GrabCut")
"""What is measured: the whole ellipse, the mask of `motes draw --masks`, and GrabCut's."""
MARGIN = 0.5
"""What GrabCut sees around the box, as a share of its sides."""
CORE = 0.45
"""Radius of the part around a box's center that is the object's, in half of its sides."""
ITERATIONS = 6
"""Iterations of GrabCut."""


def masks(
    dataset: Path,
    /,
    *,
    first_pixel: FirstPixel = None,
    sequences: Only = None,
    every: Annotated[
        int, Parameter(group=RUN, help="Compare every n-th frame; GrabCut takes long.")
    ] = 5,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Masks of motes track, and of GrabCut on the same ellipses.

    Parameters
    ----------
    dataset
        A folder of sequences, as for motes-lab evaluate. Where a sequence has no folder masks, the
        box around each mask is compared with the box of the truth.
    """
    check_counts(every=every)
    films, problems = films_of(dataset, first_pixel, sequences)
    return results.show("masks", compared_masks(films, every), problems)


class Overlaps(NamedTuple):
    """Overlaps of a sequence, one list for each of `WAYS`, and seconds a frame of the masks."""

    masks: Many[list[float]]
    boxes: Many[list[float]]
    seconds: Many[list[float]]


def overlaps(sequence: Sequence, every: int) -> Overlaps:
    """Track the target of a sequence from its first box; compare masks in every n-th frame.

    Frames in which the target is absent, or not tracked, are left out. Masks are compared if the
    sequence has a folder `masks`; else only the boxes around masks are.
    """
    found = Overlaps(*([[] for _ in WAYS] for _ in range(3)))
    tracker, segmenter = Tracker(), Segmenter()
    truths = _truth_masks(sequence)
    started = False
    with open_source(sequence.source) as film:
        for frame, truth in zip(film, sequence.boxes, strict=False):
            if not started:
                if np.isfinite(truth).all():
                    tracker.init(frame, truth.tolist())
                    started = True
                    segmenter.learn(frame.pixels, tracker.info.track.ellipse)
                continue
            track = tracker.update(frame)
            if track.status is not Status.TRACKING or not np.isfinite(truth).all():
                continue
            if frame.index % every:
                segmenter.learn(frame.pixels, track.ellipse)
                continue
            makers: list[Callable[[], Flags]] = [
                lambda e=track.ellipse, p=frame.pixels: inside(p, e),  # type: ignore[misc]
                lambda e=track.ellipse, p=frame.pixels: segmenter.update(p, e),  # type: ignore[misc]
                lambda b=track.box, p=frame.pixels: grabbed(p, b),  # type: ignore[misc]
            ]
            for i, make in enumerate(makers):
                clock = time.perf_counter()
                mask = make()
                found.seconds[i].append(time.perf_counter() - clock)
                found.boxes[i].append(float(iou(box_of(mask), truth)))
                if truths is not None:
                    true = _read(truths[frame.index], frame)
                    union = (mask | true).sum()
                    found.masks[i].append(float((mask & true).sum() / union) if union else 1.0)
    return found


def _truth_masks(sequence: Sequence) -> list[Path] | None:
    folder = Path(str(sequence.source)).parent / "masks"
    files = sorted(folder.glob("*.png")) if folder.is_dir() else []
    if files and len(files) != sequence.frames:
        raise SourceError(
            f"{folder} has {len(files)} masks for {sequence.frames} frames; give one for each."
        )
    return files or None


def _read(path: Path, frame: Frame) -> NDArray[np.bool_]:
    """Return the true mask of a frame.

    Raises
    ------
    SourceError
        If it cannot be read, or has another size than the frame.
    """
    try:
        with Image.open(path) as image:
            values: NDArray[Any] = np.asarray(image)
    except (OSError, SyntaxError, ValueError) as error:
        raise SourceError(f"The mask {path} cannot be read ({error}); replace it.") from None
    if values.shape[:2] != (frame.height, frame.width):
        raise SourceError(
            f"The mask {path} has {values.shape[1]}x{values.shape[0]} pixels, its frame "
            f"{frame.width}x{frame.height}; give the masks of this sequence."
        )
    return np.asarray(values.any(axis=2) if values.ndim == 3 else values != 0)


def inside(pixels: Bytes, ellipse: Ellipse) -> Flags:
    """Return the mask (H, W) of an ellipse."""
    y, x = np.ogrid[: pixels.shape[0], : pixels.shape[1]]
    cos, sin = np.cos(ellipse.theta), np.sin(ellipse.theta)
    u, v = x - ellipse.x, y - ellipse.y
    mask: Flags = np.hypot((u * cos + v * sin) / ellipse.a, (v * cos - u * sin) / ellipse.b) <= 1
    return mask


def grabbed(pixels: Bytes, box: Box) -> Flags:
    """Return the mask (H, W) that GrabCut finds in a box, from the box and its surroundings."""
    height, width = pixels.shape[:2]
    left = int(np.clip(box.x - MARGIN * box.width, 0, width))
    right = int(np.clip(box.x + (1 + MARGIN) * box.width, 0, width))
    top = int(np.clip(box.y - MARGIN * box.height, 0, height))
    bottom = int(np.clip(box.y + (1 + MARGIN) * box.height, 0, height))
    mask = np.zeros((height, width), np.bool_)
    part = pixels[top:bottom, left:right]
    if part.size:
        moved = np.array([box.x - left, box.y - top, box.width, box.height])
        mask[top:bottom, left:right] = grab_cut(part, moved)
    return mask


def box_of(mask: Flags) -> Box:
    """Return the box around a mask; one without size if it is empty."""
    y, x = np.nonzero(mask)
    if not x.size:
        return Box(0, 0, 0, 0)
    return Box(x.min(), y.min(), x.max() - x.min() + 1, y.max() - y.min() + 1)


def compared_masks(sequences: Many[Sequence], every: int) -> Experiment:
    """Yield the tables of IoU with the truth's masks and boxes, after each sequence."""
    rows: dict[str, list[Row]] = {"masks": [], "boxes": []}
    means: dict[str, list[list[float]]] = {name: [[] for _ in WAYS] for name in rows}
    seconds: list[list[float]] = [[] for _ in WAYS]
    for done, sequence in enumerate(sequences, start=1):
        found = overlaps(sequence, every)
        for i, values in enumerate(found.seconds):
            seconds[i] += values
        for name, values_of in (("masks", found.masks), ("boxes", found.boxes)):
            if values_of[0]:
                each = [float(np.mean(values)) for values in values_of]
                cells = [number(value) for value in each]
                rows[name].append((Cell(sequence.name), *cells, number(len(values_of[0]), 0)))
                for mean, value in zip(means[name], each, strict=True):
                    mean.append(value)
        tables = {
            name: _table(name, rows[name], means[name], seconds) for name in rows if rows[name]
        }
        yield Result(tables, None, (), sequence.name, done / len(sequences))


def _table(
    name: str, rows: list[Row], means: list[list[float]], seconds: list[list[float]]
) -> Table:
    what = {"masks": "the truth's mask", "boxes": "the truth's box, of the box around each mask"}
    foot: Row = (Cell("mean"), *(number(over(each)) for each in means), number(float("nan")))
    spent: Row = (
        Cell("milliseconds a frame"),
        *(number(1000 * float(np.mean(each)), 1) for each in seconds),
        number(float("nan")),
    )
    return Table(
        f"Intersection over union with {what[name]}",
        ("sequence", *WAYS, "frames"),
        rows,
        (foot, spent),
        "All three start from the same tracked ellipse in each frame. The mean is over sequences.",
    )


def grab_cut(part: Bytes, box: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return the mask (H, W) of the object in a box that GrabCut finds.

    What lies outside of the box is not the object; what lies around its center is. Rother,
    Kolmogorov and Blake, GrabCut, SIGGRAPH 2004.
    """
    import cv2  # takes a quarter of a second to import

    x, y, width, height = box
    rows, columns = np.ogrid[: part.shape[0], : part.shape[1]]
    u = (columns - x - (width - 1) / 2) / (width / 2)
    v = (rows - y - (height - 1) / 2) / (height / 2)
    mask = np.where(np.maximum(abs(u), abs(v)) <= 1, cv2.GC_PR_FGD, cv2.GC_BGD).astype(np.uint8)
    mask[np.hypot(u, v) <= CORE] = cv2.GC_FGD
    if not {cv2.GC_BGD, cv2.GC_FGD} <= set(np.unique(mask).tolist()):  # it needs both
        return np.zeros(mask.shape, np.bool_)
    cv2.setRNGSeed(0)
    models = np.zeros((1, 65)), np.zeros((1, 65))
    bgr = np.ascontiguousarray(part[:, :, ::-1])
    cv2.grabCut(bgr, mask, (0, 0, 0, 0), *models, ITERATIONS, cv2.GC_INIT_WITH_MASK)
    found: NDArray[np.bool_] = (mask == cv2.GC_FGD) | (mask == cv2.GC_PR_FGD)
    return found
