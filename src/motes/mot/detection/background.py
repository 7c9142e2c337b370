"""What moves before a camera that stands still: a background for each pixel, and blobs before it.

Zhao and Pei, section 3.1: a mixture of Gaussians tells foreground from background, and the
foreground's connected parts are the objects.
"""

from __future__ import annotations

import math
from functools import partial
from typing import Annotated, Any, Literal, Protocol

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from motes.core.config import Config, Count, NonNegative, Positive, Share
from motes.core.detection import Detection, DetectorConfig
from motes.core.errors import ConfigError, MissingDependencyError
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.mot.detection.camera_motion import ReferenceImage
from motes.mot.detection.ghosts import Steps, gradients, without_ghosts

Method = Literal["mog2", "knn", "gaussian"]
Mask = NDArray[np.uint8]

SPARSE = 8
"""How bright pixels usually are is learned of every so many in x and y."""
RENEWED = 5
"""The picture of the background that ghosts are looked for in is so many frames old at most."""
MOVES = "the camera moves; what moves before it is not seen"
SHADE = 0.95
"""What keeps more than this share of its brightness is no shadow."""


class BackgroundConfig(DetectorConfig, Config, frozen=True, tag="background"):
    """How a `BackgroundDetector` tells what moves, and what of it is an object.

    Attributes
    ----------
    method
        `mog2` (a mixture of Gaussians for each pixel: Zivkovic, ICPR 2004) and `knn` (its nearest
        samples: Zivkovic and van der Heijden, 2006) need OpenCV; `gaussian` is one Gaussian for
        each pixel, in numpy (Wren et al., Pfinder, 1997). By default `mog2`, or `gaussian` where
        OpenCV is missing.
    history
        Frames over which a background is learned.
    rate
        Share of the background that each frame makes up; by default 1 / `history`, and more at the
        start.
    deviations
        A pixel this many standard deviations off is foreground; of `mog2` and `gaussian`.
    distance
        A pixel this many gray levels from its samples is foreground; of `knn`.
    noise
        Least standard deviation of a pixel in gray levels, what cameras and compression leave; of
        `gaussian`.
    shadow
        A shadow leaves a pixel at least this share of its brightness; with 1 there are none.
    tint
        How far off, in gray levels, a shadow's color may be; of `gaussian`.
    exposure
        A camera changes its exposure by less than this share from what is usual.
    recent
        Frames over which it is learned how bright pixels usually are.
    speck
        Patches less wide or high than so many pixels are noise.
    gap
        Patches closer than these shares of the frame's height and width, in y and x, are one
        object.
    least, most
        How large an object is, as shares of the frame.
    ghost
        Where somebody was who has become background, there is a ghost: a patch whose outline has
        less than this share of the gradients that the background has there. With 0 these are
        taken for objects.
    limit
        No more objects than these, the largest, are taken of one frame.
    still
        After so many frames in a row of nearly nothing but foreground it is the camera that moves;
        and after it has, it must stand still for as many.
    """

    method: Method | None = None
    history: Count = 500
    rate: Annotated[float, Meta(gt=0, le=1)] | None = None
    deviations: Positive = 4.0
    distance: Positive = 20.0
    noise: Positive = 4.0
    shadow: Annotated[float, Meta(gt=0, le=1)] = 0.5
    tint: NonNegative = 12.0
    exposure: Share = 0.2
    recent: Count = 50
    speck: Literal[1, 3, 5, 7, 9] = 3
    gap: tuple[Share, Share] = (0.06, 0.008)
    least: Share = 0.002
    most: Share = 0.5
    ghost: Share = 0.9
    limit: Count = 100
    still: Count = 10

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0 < self.least < self.most:
            raise ConfigError(
                f"An object is 0 < least < most <= 1 of a frame; got {self.least}, {self.most}."
            )

    def detector(self) -> BackgroundDetector:
        """Return a detector that is set so; raise a MissingDependencyError without OpenCV."""
        return BackgroundDetector(self)


class _Model(Protocol):
    """A background."""

    def begin(self, pixels: Mask) -> None:
        """Take a frame for the background, and forget what was before."""
        ...

    def apply(self, pixels: Mask) -> Mask:
        """Return where the foreground is, (H, W) of 0 and 1, shadows left out; and learn."""
        ...

    def picture(self) -> Mask:
        """Return the background as it is learned, (H, W, 3)."""
        ...


class BackgroundDetector:
    """Finds what moves before a camera that stands still. A `Detector`; frames come in order.

    What leaves its place has become background there, and a patch without edges of its own is not
    taken for an object (`ghosts`). A frame that is mostly foreground, as when the light is switched
    on, has no detections, and the background begins anew with it.

    Parameters
    ----------
    config
        A method, or a configuration.

    Attributes
    ----------
    warnings
        What there is to tell about the picture, each once: a moving camera, a change of light, too
        many objects.

    Raises
    ------
    MissingDependencyError
        If OpenCV is needed and not installed.
    ConfigError
        If the method is unknown, or a number makes no sense.
    """

    def __init__(self, config: Method | BackgroundConfig | None = None) -> None:
        if not isinstance(config, BackgroundConfig):
            config = BackgroundConfig(method=config)
        self.config = config
        method = config.method or ("gaussian" if _opencv() is None else "mog2")
        self._model: _Model = (
            _Gaussian(config) if method == "gaussian" else _Mixture(method, config)
        )
        self._shape: tuple[int, ...] | None = None
        self._flooded = self._rest = self._when = 0
        self._learned: Steps | None = None
        self.warnings: dict[str, str] = {}

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return what moves in the next frame, the largest first, all with the score 1."""
        if frame.pixels.shape != self._shape:
            self._shape = frame.pixels.shape
            self._begin(frame.pixels)
            return []
        if self._anchor.has_moved(frame.pixels):
            self._begin(frame.pixels)
            self._rest = self.config.still
            self._remark(frame, "camera", MOVES)
            return []
        mask = self._model.apply(self._exposed(frame.pixels))
        if mask.mean() > self.config.most:
            self._begin(frame.pixels)
            self._flooded += 1
            if self._flooded == self.config.still:
                self._remark(frame, "camera", MOVES)
            elif self._flooded == 1:
                said = "the picture changes all over; its background is learned anew"
                self._remark(frame, "light", said)
            return []
        self._flooded = 0
        if self._rest:
            self._rest -= 1
            return []
        boxes = blobs(mask, self.config)
        if boxes and self.config.ghost:
            if self._learned is None or frame.index - self._when >= RENEWED:
                self._learned, self._when = gradients(self._model.picture()), frame.index
            now = gradients(frame.pixels)
            boxes = without_ghosts(boxes, mask, now, self._learned, self.config.ghost)
        limit = self.config.limit
        if len(boxes) > limit:
            said = f"there are {len(boxes)} moving patches; only the {limit} largest are taken"
            self._remark(frame, "flood", said)
        return [Detection(box) for box in boxes[:limit]]

    def _begin(self, pixels: Mask) -> None:
        self._usual = 1 + pixels[::SPARSE, ::SPARSE].astype(np.float32)
        self._anchor = ReferenceImage(pixels)
        self._learned = None
        self._model.begin(pixels)

    def _exposed(self, pixels: Mask) -> Mask:
        """Return a frame as bright as usual: cameras change their exposure when somebody comes in.

        A channel's gain is the median over pixels, so that what moves does not change it. Where the
        gain is far from 1 it is the light that changes, not the camera.
        """
        sparse = 1 + pixels[::SPARSE, ::SPARSE].astype(np.float32)
        gains = np.median(self._usual / sparse, axis=(0, 1))
        if (np.abs(gains - 1) > self.config.exposure).any():
            return pixels
        self._usual += (gains * sparse - self._usual) / self.config.recent
        tables = np.rint(gains * np.arange(256)[:, None]).clip(0, 255).astype(np.uint8)
        cv2 = _opencv()
        if cv2 is not None:  # the same, ten times faster
            out: Mask = cv2.LUT(pixels, tables[None])
            return out
        return np.stack([np.take(tables[:, c], pixels[:, :, c]) for c in range(3)], axis=2)

    def _remark(self, frame: Frame, kind: str, text: str) -> None:
        self.warnings.setdefault(kind, f"Frame {frame.index}: {text}.")


class _Mixture:
    """OpenCV's backgrounds; it marks shadows by less than 255."""

    def __init__(self, method: str, config: BackgroundConfig) -> None:
        cv2 = _opencv()
        if cv2 is None:
            raise MissingDependencyError(
                f"The background {method} needs OpenCV; install it with: pip install "
                f"'motes[opencv]', or take gaussian."
            )
        self._rate = -1.0 if config.rate is None else config.rate  # OpenCV chooses
        self._shadow = config.shadow
        make, squared = {
            "mog2": (cv2.createBackgroundSubtractorMOG2, config.deviations**2),
            "knn": (cv2.createBackgroundSubtractorKNN, config.distance**2),
        }[method]
        self._make = partial(make, config.history, squared, config.shadow < 1)

    def begin(self, pixels: Mask) -> None:
        """Show a new model the frame a few times: nearest samples need some to be near to."""
        self._model = self._make()
        self._model.setShadowThreshold(self._shadow)
        for _ in range(5):
            self._model.apply(pixels)

    def apply(self, pixels: Mask) -> Mask:
        """Return where OpenCV sees foreground."""
        mask: Mask = (self._model.apply(pixels, learningRate=self._rate) == 255).astype(np.uint8)
        return mask

    def picture(self) -> Mask:
        """Return OpenCV's mean of what is background."""
        learned: Mask = self._model.getBackgroundImage()
        return learned


class _Gaussian:
    """A running mean and variance for each pixel and channel.

    Foreground is learned ten times more slowly than background, so that what stops for a while is
    not swallowed.
    """

    def __init__(self, config: BackgroundConfig) -> None:
        self._config = config

    def begin(self, pixels: Mask) -> None:
        """Start with the frame for a mean."""
        self._frames, self._mean = 1, pixels.astype(np.float32)
        self._variance = np.full_like(self._mean, (2 * self._config.noise) ** 2)

    def apply(self, pixels: Mask) -> Mask:
        """Return where a channel is too many deviations off and it is no shadow."""
        config, seen = self._config, pixels.astype(np.float32)
        self._frames += 1
        off = seen - self._mean
        squared = off * off
        apart = (squared > config.deviations**2 * self._variance).any(axis=2)
        darker = seen.sum(axis=2) / np.maximum(self._mean.sum(axis=2), 1)
        tint = np.abs(seen - darker[:, :, None] * self._mean).max(axis=2)
        shadow = (darker > config.shadow) & (darker < SHADE) & (tint < config.tint)
        foreground = apart & ~shadow
        rate = config.rate or max(1 / self._frames, 1 / config.history)
        share = np.where(foreground, rate / 10, rate).astype(np.float32)[:, :, None]
        self._mean += share * off
        self._variance += share * (squared - self._variance)
        np.maximum(self._variance, config.noise**2, out=self._variance)
        mask: Mask = foreground.astype(np.uint8)
        return mask

    def picture(self) -> Mask:
        """Return the means."""
        return self._mean.astype(np.uint8)


def blobs(mask: Mask, config: BackgroundConfig) -> list[Box]:
    """Return the boxes of the connected parts of a mask (H, W) of 0 and 1, the largest first.

    Specks are removed, patches that are near to each other connected, and what covers too little of
    the mask after that is left out.
    """
    sides, speck = zip(config.gap, mask.shape, strict=True), config.speck
    gap = [max(1, math.ceil(share * side)) | 1 for share, side in sides]
    cv2 = _opencv()
    if cv2 is not None:
        clean = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((speck, speck), np.uint8))
        closed = cv2.morphologyEx(clean, cv2.MORPH_CLOSE, np.ones(gap, np.uint8))
        found = cv2.connectedComponentsWithStats(closed)[2][1:]  # the first is the background
    else:
        from scipy import ndimage

        clean = ndimage.maximum_filter(ndimage.minimum_filter(mask, speck), speck)
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
    found = found[found[:, 4] >= round(config.least * mask.size)]
    return [Box(*row[:4]) for row in found[np.argsort(-found[:, 4], kind="stable")].tolist()]


def _opencv() -> Any:
    """Return OpenCV, or None where it is not installed."""
    try:
        import cv2
    except ImportError:
        return None
    return cv2
