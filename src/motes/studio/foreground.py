"""The foreground of a frame: the pixels that the many-object mode takes as moving."""

from __future__ import annotations

import io
from collections.abc import Callable

import numpy as np
from PIL import Image

from motes.mot.detection.background import BackgroundDetector
from motes.mot.detection.background_models import Method
from motes.video.film import Film

BEFORE = 75
"""Frames from which the background is learned: three seconds of most films."""


def foreground(film: Film, method: Method, index: int, check: Callable[[], None]) -> bytes:
    """Return a PNG of the moving pixels of a frame: white, the others transparent.

    Parameters
    ----------
    film
        The film.
    method
        The background model.
    index
        The frame.
    check
        Called after each frame; it may raise to end the work.
    """
    detector = BackgroundDetector(method)
    detector.prepare(film.forward(0, len(film.times) - 1))
    for frame in film.forward(max(0, index - BEFORE), index):
        detector(frame)
        check()
    moving = np.zeros((film.height, film.width), bool)
    if detector.mask is not None:
        moving |= detector.mask > 0
    pixels = np.where(moving[:, :, None], np.uint8(255), np.uint8(0)).repeat(4, axis=2)
    out = io.BytesIO()
    Image.fromarray(pixels, "RGBA").save(out, "PNG")
    return out.getvalue()
