"""What moves before a camera that stands still: a background for each pixel, and blobs before it.

Zhao and Pei, section 3.1: a mixture of Gaussians tells foreground from background, and the
foreground's connected parts are the objects.
"""

from __future__ import annotations

import math
from typing import Any, Literal, Protocol, get_args

import numpy as np
from numpy.typing import NDArray

from motes.detection import Detection, Detector, PeopleDetector, RecordedDetections
from motes.errors import ConfigError, LimitError
from motes.frame import Frame
from motes.geometry import Box

Method = Literal["mog2", "knn", "gaussian"]
Mask = NDArray[np.uint8]

HISTORY = 500
"""Frames over which a background is learned; the value of OpenCV's own."""
DEVIATIONS = 4.0
"""A pixel this many standard deviations off is foreground; so do OpenCV's mixtures decide."""
SHADOW = (0.5, 0.95)
"""A shadow leaves a pixel between these shares of its brightness, and its color nearly as it is."""
TINT = 12.0
"""How far off, in gray levels, a shadow's color may be."""
NOISE = 4.0
"""Least standard deviation of a pixel in gray levels: what cameras and compression leave."""
STILL = 10
"""After so many frames in a row of nearly nothing but foreground it is the camera that moves."""
EXPOSURE = 0.2
"""A camera changes its exposure by less than this share from what is usual."""
RECENT = 50
"""Frames over which it is learned how bright pixels usually are, of those looked at, ..."""
SPARSE = 8
"""... which are every so many in x and y."""
GAP = (0.06, 0.008)
"""Patches closer than these shares of the frame's height and width, in y and x, are one object."""


class _Model(Protocol):
    """A background."""

    def begin(self, pixels: Mask) -> None:
        """Take a frame for the background, and forget what was before."""
        ...

    def apply(self, pixels: Mask) -> Mask:
        """Return where the foreground is, (H, W) of 0 and 1, shadows left out; and learn."""
        ...


class BackgroundDetector:
    """Finds what moves before a camera that stands still. A `Detector`; frames come in order.

    Until it has seen some thirty frames, whatever leaves its place leaves a ghost there. A frame
    that is mostly foreground, as when the light is switched on, has no detections, and the
    background begins anew with it.

    Parameters
    ----------
    method
        `mog2` (a mixture of Gaussians for each pixel: Zivkovic, ICPR 2004) and `knn` (its nearest
        samples: Zivkovic and van der Heijden, 2006) need OpenCV; `gaussian` is one Gaussian for
        each pixel, in numpy (Wren et al., Pfinder, 1997). By default `mog2`, or `gaussian` where
        OpenCV is missing.
    least, most
        How large an object is, as shares of the frame.
    limit
        No more objects than these, the largest, are taken of one frame.

    Attributes
    ----------
    remarks
        What there is to tell about the picture, each once: a moving camera, a change of light, too
        many objects.

    Raises
    ------
    LimitError
        If OpenCV is needed and not installed.
    ConfigError
        If the method is unknown, or a number makes no sense.
    """

    def __init__(
        self,
        method: Method | None = None,
        least: float = 0.002,
        most: float = 0.5,
        limit: int = 100,
    ) -> None:
        if method is not None and method not in get_args(Method):
            raise ConfigError(f"No background {method!r}; known are {', '.join(get_args(Method))}.")
        if not 0 < least < most <= 1:
            raise ConfigError(
                f"An object is 0 < least < most <= 1 of a frame; got {least}, {most}."
            )
        if limit < 1:
            raise ConfigError(f"A frame may have 1 or more objects; got {limit}.")
        if method is None:
            method = "gaussian" if _opencv() is None else "mog2"
        self._model: _Model = _Gaussian() if method == "gaussian" else _Mixture(method)
        self._least, self._most, self._limit = least, most, limit
        self._shape: tuple[int, ...] | None = None
        self._flooded = 0
        self.remarks: dict[str, str] = {}

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return what moves in the next frame, the largest first, all with the score 1."""
        if frame.pixels.shape != self._shape:
            self._shape = frame.pixels.shape
            self._begin(frame.pixels)
            return []
        mask = self._model.apply(self._exposed(frame.pixels))
        if mask.mean() > self._most:
            self._begin(frame.pixels)
            self._flooded += 1
            if self._flooded == STILL:
                self._remark(frame, "camera", "the camera moves; what moves before it is not seen")
            elif self._flooded == 1:
                said = "the picture changes all over; its background is learned anew"
                self._remark(frame, "light", said)
            return []
        self._flooded = 0
        boxes = blobs(mask, round(self._least * mask.size))
        if len(boxes) > self._limit:
            said = (
                f"there are {len(boxes)} moving patches; only the {self._limit} largest are taken"
            )
            self._remark(frame, "flood", said)
        return [Detection(box) for box in boxes[: self._limit]]

    def _begin(self, pixels: Mask) -> None:
        self._usual = 1 + pixels[::SPARSE, ::SPARSE].astype(np.float32)
        self._model.begin(pixels)

    def _exposed(self, pixels: Mask) -> Mask:
        """Return a frame as bright as usual: cameras change their exposure when somebody comes in.

        A channel's gain is the median over pixels, so that what moves does not change it. Where the
        gain is far from 1 it is the light that changes, not the camera.
        """
        sparse = 1 + pixels[::SPARSE, ::SPARSE].astype(np.float32)
        gains = np.median(self._usual / sparse, axis=(0, 1))
        if (np.abs(gains - 1) > EXPOSURE).any():
            return pixels
        self._usual += (gains * sparse - self._usual) / RECENT
        tables = np.rint(gains * np.arange(256)[:, None]).clip(0, 255).astype(np.uint8)
        cv2 = _opencv()
        if cv2 is not None:  # the same, ten times faster
            out: Mask = cv2.LUT(pixels, tables[None])
            return out
        return np.stack([np.take(tables[:, c], pixels[:, :, c]) for c in range(3)], axis=2)

    def _remark(self, frame: Frame, kind: str, text: str) -> None:
        self.remarks.setdefault(kind, f"Frame {frame.index}: {text}.")


class _Mixture:
    """OpenCV's backgrounds, with its own values; it marks shadows by less than 255."""

    def __init__(self, method: str) -> None:
        cv2 = _opencv()
        if cv2 is None:
            raise LimitError(
                f"The background {method} needs OpenCV; install it with: pip install "
                f"'motes[opencv]', or take gaussian."
            )
        self._make = {
            "mog2": cv2.createBackgroundSubtractorMOG2,
            "knn": cv2.createBackgroundSubtractorKNN,
        }[method]

    def begin(self, pixels: Mask) -> None:
        """Show a new model the frame a few times: nearest samples need some to be near to."""
        self._model = self._make(history=HISTORY, detectShadows=True)
        for _ in range(5):
            self._model.apply(pixels)

    def apply(self, pixels: Mask) -> Mask:
        """Return where OpenCV sees foreground."""
        mask: Mask = (self._model.apply(pixels) == 255).astype(np.uint8)
        return mask


class _Gaussian:
    """A running mean and variance for each pixel and channel.

    Foreground is learned ten times more slowly than background, so that what stops for a while is
    not swallowed.
    """

    def begin(self, pixels: Mask) -> None:
        """Start with the frame for a mean."""
        self._frames, self._mean = 1, pixels.astype(np.float32)
        self._variance = np.full_like(self._mean, (2 * NOISE) ** 2)

    def apply(self, pixels: Mask) -> Mask:
        """Return where a channel is more than `DEVIATIONS` off and it is no shadow."""
        seen = pixels.astype(np.float32)
        self._frames += 1
        off = seen - self._mean
        squared = off * off
        apart = (squared > DEVIATIONS**2 * self._variance).any(axis=2)
        darker = seen.sum(axis=2) / np.maximum(self._mean.sum(axis=2), 1)
        tint = np.abs(seen - darker[:, :, None] * self._mean).max(axis=2)
        shadow = (darker > SHADOW[0]) & (darker < SHADOW[1]) & (tint < TINT)
        foreground = apart & ~shadow
        rate = max(1 / self._frames, 1 / HISTORY)
        share = np.where(foreground, rate / 10, rate).astype(np.float32)[:, :, None]
        self._mean += share * off
        self._variance += share * (squared - self._variance)
        np.maximum(self._variance, NOISE**2, out=self._variance)
        mask: Mask = foreground.astype(np.uint8)
        return mask


def blobs(mask: Mask, least: int) -> list[Box]:
    """Return the boxes of the connected parts of a mask (H, W) of 0 and 1, the largest first.

    Specks of less than 3x3 pixels are removed, patches within `GAP` of each other connected, and
    what covers fewer than `least` pixels after that is left out.
    """
    gap = [max(1, math.ceil(share * side)) | 1 for share, side in zip(GAP, mask.shape, strict=True)]
    cv2 = _opencv()
    if cv2 is not None:
        clean = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8))
        closed = cv2.morphologyEx(clean, cv2.MORPH_CLOSE, np.ones(gap, np.uint8))
        found = cv2.connectedComponentsWithStats(closed)[2][1:]  # the first is the background
    else:
        from scipy import ndimage

        clean = ndimage.maximum_filter(ndimage.minimum_filter(mask, 3), 3)
        closed = ndimage.minimum_filter(ndimage.maximum_filter(clean, gap), gap)
        labels, count = ndimage.label(closed, np.ones((3, 3)))
        areas = np.bincount(labels.ravel(), minlength=count + 1)[1:]
        corners = [(x.start, y.start, x.stop, y.stop) for y, x in ndimage.find_objects(labels)]
        found = np.array(
            [
                (left, top, right - left, bottom - top, area)
                for (left, top, right, bottom), area in zip(corners, areas, strict=True)
            ],
            np.int64,
        ).reshape(-1, 5)
    found = found[found[:, 4] >= least]
    return [Box(*row[:4]) for row in found[np.argsort(-found[:, 4], kind="stable")].tolist()]


def named_detector(name: str | None) -> Detector:
    """Return what users call a detector: people, a .txt file, or a background; None for mog2.

    Raises
    ------
    ConfigError
        If there is none of that name.
    """
    if name == "people":
        return PeopleDetector()
    if name is not None and name.endswith(".txt"):
        return RecordedDetections(name)
    if name not in (None, *get_args(Method)):
        known = ", ".join(get_args(Method))
        raise ConfigError(f"A detector is {known}, people or a .txt file; got {name!r}.")
    return BackgroundDetector(name)  # type: ignore[arg-type]


def _opencv() -> Any:
    """Return OpenCV, or None where it is not installed."""
    try:
        import cv2
    except ImportError:
        return None
    return cv2
