"""Models of the background of each pixel: mixtures of Gaussians, nearest samples, one Gaussian."""

from __future__ import annotations

from typing import Any, Literal, Protocol

import numpy as np

from motes.core.errors import MissingDependencyError
from motes.mot.detection.images import Mask, opencv

Method = Literal["mog2", "knn", "gaussian"]

FIRST = 5
"""A background begins as if its first picture had come this many times."""


class BackgroundModel(Protocol):
    """A background."""

    def begin(self, pixels: Mask) -> None:
        """Start with a picture as background, and forget the frames before."""
        ...

    def foreground(self, pixels: Mask) -> Mask:
        """Return the pixels that differ from the background, (H, W) of 0 and 1."""
        ...

    def learn(self, pixels: Mask, rate: float) -> None:
        """Learn from a picture of the background, which has a share of `rate` from then on."""
        ...

    def picture(self) -> Mask:
        """Return the learned background, (H, W, 3)."""
        ...


class Mixture:
    """OpenCV's mixture of Gaussians for each pixel: Zivkovic, ICPR 2004.

    Parameters
    ----------
    history, deviations
        As in `BackgroundConfig`.
    """

    def __init__(self, history: int, deviations: float) -> None:
        self._cv2, self._history, self._squared = _required("mog2"), history, deviations**2

    def begin(self, pixels: Mask) -> None:
        """Start a new model."""
        self._model = self._cv2.createBackgroundSubtractorMOG2(self._history, self._squared, False)
        for _ in range(FIRST):
            self._model.apply(pixels)

    def foreground(self, pixels: Mask) -> Mask:
        """Return OpenCV's foreground; nothing is learned."""
        mask: Mask = self._model.apply(pixels, learningRate=0) >> 7
        return mask

    def learn(self, pixels: Mask, rate: float) -> None:
        """Learn."""
        self._model.apply(pixels, learningRate=rate)

    def picture(self) -> Mask:
        """Return OpenCV's mean of the background."""
        learned: Mask = self._model.getBackgroundImage()
        return learned


class Nearest:
    """OpenCV's nearest samples of each pixel: Zivkovic and van der Heijden, 2006.

    It learns from every pixel that it compares, the foreground too: OpenCV has no other way.

    Parameters
    ----------
    history, distance
        As in `BackgroundConfig`.
    rate
        Share of each frame; None for OpenCV's choice.
    """

    def __init__(self, history: int, distance: float, rate: float | None) -> None:
        self._cv2, self._history, self._squared = _required("knn"), history, distance**2
        self._rate = -1.0 if rate is None else rate

    def begin(self, pixels: Mask) -> None:
        """Start a new model."""
        self._model = self._cv2.createBackgroundSubtractorKNN(self._history, self._squared, False)
        for _ in range(FIRST):
            self._model.apply(pixels)

    def foreground(self, pixels: Mask) -> Mask:
        """Return OpenCV's foreground, and learn."""
        mask: Mask = self._model.apply(pixels, learningRate=self._rate) >> 7
        return mask

    def learn(self, pixels: Mask, rate: float) -> None:
        """Do nothing: `foreground` has learned."""

    def picture(self) -> Mask:
        """Return OpenCV's mean of the background."""
        learned: Mask = self._model.getBackgroundImage()
        return learned


class Gaussian:
    """A running mean and variance for each pixel and channel: Wren et al., Pfinder, 1997.

    Parameters
    ----------
    deviations, noise
        As in `BackgroundConfig`.
    """

    def __init__(self, deviations: float, noise: float) -> None:
        self._deviations, self._noise = deviations, noise

    def begin(self, pixels: Mask) -> None:
        """Start with the picture as mean."""
        self._mean = pixels.astype(np.float32)
        self._variance = np.full_like(self._mean, (2 * self._noise) ** 2)

    def foreground(self, pixels: Mask) -> Mask:
        """Return the pixels with a channel too many deviations from its mean."""
        off = pixels - self._mean
        beyond = off * off > self._deviations**2 * self._variance
        mask: Mask = np.any(beyond, axis=2).astype(np.uint8)
        return mask

    def learn(self, pixels: Mask, rate: float) -> None:
        """Learn."""
        off = pixels - self._mean
        self._mean += np.float32(rate) * off
        self._variance += np.float32(rate) * (off * off - self._variance)
        np.maximum(self._variance, self._noise**2, out=self._variance)

    def picture(self) -> Mask:
        """Return the means."""
        return np.rint(self._mean).astype(np.uint8)


def _required(method: Method) -> Any:
    """Return OpenCV; raise a MissingDependencyError where it is not installed."""
    cv2 = opencv()
    if cv2 is None:
        raise MissingDependencyError(
            f"The background {method} needs OpenCV; install it with: pip install "
            f"'motes[opencv]', or take gaussian."
        )
    return cv2
