"""Moving objects before a fixed camera: a background model for each pixel, and foreground blobs.

Zhao and Pei, section 3.1: a mixture of Gaussians separates foreground from background, and the
connected parts of the foreground are the objects.
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
"""The usual brightness is learned from every eighth pixel in x and y."""
RENEWED = 5
"""Largest age, in frames, of the picture of the background in which ghosts are searched."""
MOVES = "the camera moves; what moves before it is not seen"
SHADE = 0.95
"""A pixel that keeps more than this share of its brightness is no shadow."""


class BackgroundConfig(DetectorConfig, Config, frozen=True, tag="background"):
    """How a `BackgroundDetector` separates foreground from background, and finds objects in it.

    Attributes
    ----------
    method
        Model of the background. `mog2` is a mixture of Gaussians for each pixel (Zivkovic, ICPR
        2004), `knn` keeps the nearest samples of each pixel (Zivkovic and van der Heijden, 2006);
        both need OpenCV. `gaussian` is one Gaussian for each pixel (Wren et al., Pfinder, 1997). By
        default `mog2`, or `gaussian` if OpenCV is missing.
    history
        Number of frames over which the background is learned. With a larger value it changes more
        slowly.
    rate
        Share of each frame that enters the background. With a larger value it changes faster. By
        default 1 / `history`, and more at the start.
    deviations
        Number of standard deviations from the background, from which on a pixel is foreground
        (`mog2` and `gaussian`). With a larger value fewer pixels are.
    distance
        Distance from the background's samples in gray levels, from which on a pixel is foreground
        (`knn`). With a larger value fewer pixels are.
    noise
        Least standard deviation of a background pixel in gray levels (`gaussian`), as from camera
        noise and compression. With a larger value fewer pixels are foreground.
    shadow
        Least share of its brightness that a pixel keeps in a shadow; shadows are no foreground. A
        smaller value removes darker shadows; with 1 none are removed.
    tint
        Largest change of a pixel's color by a shadow, in gray levels (`gaussian`). A larger value
        removes more shadows.
    exposure
        Largest change of the camera's exposure that is corrected, as a share of the brightness.
    recent
        Number of frames over which the usual brightness is learned. With a larger value it changes
        more slowly.
    speck
        Least width and height of a patch of foreground, in pixels. Smaller patches are noise.
    gap
        Largest gap between two patches of one object, in y and in x, as shares of the frame's
        height and width. Larger values join more patches.
    least
        Smallest area of an object, as a share of the frame.
    most
        Largest area of an object, as a share of the frame.
    ghost
        Limit for ghosts, patches that an object of the background leaves behind. A ghost's outline
        has less than this share of the background's gradients there. With a larger value more
        patches are ghosts; with 0 none are.
    limit
        Largest number of objects of a frame that are used: the largest ones.
    still
        The camera counts as moving if almost all is foreground in this many frames in a row. Then
        it must stand still for as many.
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
        """Return the detector; raise a MissingDependencyError if OpenCV is needed and missing."""
        return BackgroundDetector(self)


class _Model(Protocol):
    """A background."""

    def begin(self, pixels: Mask) -> None:
        """Start with a frame as background, and forget the frames before."""
        ...

    def apply(self, pixels: Mask) -> Mask:
        """Return the foreground without shadows, (H, W) of 0 and 1; and learn from the frame."""
        ...

    def picture(self) -> Mask:
        """Return the learned background, (H, W, 3)."""
        ...


class BackgroundDetector:
    """Finds moving objects before a fixed camera. A `Detector`; frames come in order.

    A patch without edges of its own is no object: an object that has become background there has
    left the place (`ghosts`). A frame that is mostly foreground, as when a light is switched on,
    has no detections, and the background is learned anew from it.

    Parameters
    ----------
    config
        A method, or a configuration.

    Attributes
    ----------
    warnings
        Warnings about the picture by kind, each once: a moving camera, a change of light, too many
        objects.

    Raises
    ------
    MissingDependencyError
        If OpenCV is needed and not installed.
    ConfigError
        If the method is unknown, or a number is out of its range.
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
        """Return the moving objects in the next frame, the largest first, all with the score 1."""
        pixels = np.ascontiguousarray(frame.pixels)  # which OpenCV would do again and again
        if pixels.shape != self._shape:
            self._shape = pixels.shape
            self._begin(pixels)
            return []
        if self._reference.has_moved(pixels):
            self._begin(pixels)
            self._rest = self.config.still
            self._warn(frame, "camera", MOVES)
            return []
        mask = self._model.apply(self._exposed(pixels))
        if mask.mean() > self.config.most:
            self._begin(pixels)
            self._flooded += 1
            if self._flooded == self.config.still:
                self._warn(frame, "camera", MOVES)
            elif self._flooded == 1:
                text = "the picture changes all over; its background is learned anew"
                self._warn(frame, "light", text)
            return []
        self._flooded = 0
        if self._rest:
            self._rest -= 1
            return []
        boxes = blobs(mask, self.config)
        if boxes and self.config.ghost:
            if self._learned is None or frame.index - self._when >= RENEWED:
                self._learned, self._when = gradients(self._model.picture()), frame.index
            now = gradients(pixels)
            boxes = without_ghosts(boxes, mask, now, self._learned, self.config.ghost)
        limit = self.config.limit
        if len(boxes) > limit:
            text = f"there are {len(boxes)} moving patches; only the {limit} largest are taken"
            self._warn(frame, "flood", text)
        return [Detection(box) for box in boxes[:limit]]

    def _begin(self, pixels: Mask) -> None:
        self._usual = 1 + pixels[::SPARSE, ::SPARSE].astype(np.float32)
        self._reference = ReferenceImage(pixels)
        self._learned = None
        self._model.begin(pixels)

    def _exposed(self, pixels: Mask) -> Mask:
        """Return a frame with its usual brightness: cameras change their exposure.

        A channel's gain is the median over pixels, so that moving objects do not change it. If the
        gain is far from 1, the light has changed, not the exposure.
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

    def _warn(self, frame: Frame, kind: str, text: str) -> None:
        self.warnings.setdefault(kind, f"Frame {frame.index}: {text}.")


class _Mixture:
    """OpenCV's background models, which mark shadows by values below 255."""

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
        """Start a new model with the frame several times: the nearest neighbors need samples."""
        self._model = self._make()
        self._model.setShadowThreshold(self._shadow)
        for _ in range(5):
            self._model.apply(pixels)

    def apply(self, pixels: Mask) -> Mask:
        """Return OpenCV's foreground."""
        mask: Mask = (self._model.apply(pixels, learningRate=self._rate) == 255).astype(np.uint8)
        return mask

    def picture(self) -> Mask:
        """Return OpenCV's mean of the background."""
        learned: Mask = self._model.getBackgroundImage()
        return learned


class _Gaussian:
    """A running mean and variance for each pixel and channel.

    Foreground is learned ten times more slowly than background, so that an object that stops for a
    while does not become background.
    """

    def __init__(self, config: BackgroundConfig) -> None:
        self._config = config

    def begin(self, pixels: Mask) -> None:
        """Start with the frame as mean."""
        self._frames, self._mean = 1, pixels.astype(np.float32)
        self._variance = np.full_like(self._mean, (2 * self._config.noise) ** 2)

    def apply(self, pixels: Mask) -> Mask:
        """Return the pixels with a channel too many deviations from its mean, without shadows."""
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

    First specks are removed, then patches that are near to each other are connected, then patches
    that are too small are left out.
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
