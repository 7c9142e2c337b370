"""Moving objects before a fixed camera: a background model for each pixel, and foreground blobs.

Zhao and Pei, section 3.1: a mixture of Gaussians separates foreground from background, and the
connected parts of the foreground are the objects.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Sequence
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes.core.config import Config, Count, NonNegative, Positive, Share
from motes.core.detection import Detection, DetectorConfig
from motes.core.errors import ConfigError, SourceError
from motes.core.frame import Frame
from motes.core.geometry import Box
from motes.core.types import Bytes
from motes.kernels.structures import LightLimits
from motes.mot.detection.background_model import (
    FIRST,
    Mixture,
    Preview,
    SelectiveUpdate,
    usual_colors,
)
from motes.mot.detection.blobs import SMALL, blobs, small_patches
from motes.mot.detection.exposure import Exposure, tables_of
from motes.mot.detection.foreground import ForegroundMemory, without_ghosts
from motes.mot.detection.illumination import (
    Background,
    with_enclosed,
    without_light,
    without_tremble,
)
from motes.mot.detection.morphology import opencv_warnings
from motes.mot.detection.planes import Planes, planes_of
from motes.mot.detection.reference_image import ReferenceImage
from motes.mot.detection.sway import FARTHEST, LASTS, STEP, Sway, moved, unseen

BRIGHTEST = 250
"""A camera shows what is brighter than it can show with this value or more."""
DARKEST = 5
"""And what is darker with this value or less."""
LEARNED = 3
"""The background learns from every third frame, at three times the rate.

To learn takes as much time as to compare.
"""
RENEWED = 5
"""Largest age, in frames, of the picture of the background that frames are compared with."""
HIGHLIGHT = 1.25
"""Largest share of its brightness that a pixel has in more light: a reflection is fainter than most
shadows are dark."""
TINT = 12.0
"""Largest change of a pixel's color by another light, in gray levels: a few times the noise."""
TEXTURE = 6.0
"""Largest change of the gradients by another light, in gray levels per pixel."""
LIMIT = 100
"""Objects of a frame that are used, the largest ones: more would be a flood of specks."""
SMALL_EVERY = 10
"""Patches that are too small for objects are counted in every tenth frame."""
SMALL_RATIO, SMALL_EXCESS = 3, 20
"""A warning says that most are too small, once their number exceeds this ratio to the objects by
this excess, over all counted frames."""
STILL = 10
"""Frames in a row in which almost all is foreground if the camera moves; a light that is switched
on takes fewer. After a move, the camera must stand still for this number of frames."""
MOVES = (
    "the camera moves; what moves before it is not seen: give a trained detector, or, if it sees "
    "a plane or only turns, --camera moving"
)


class BackgroundConfig(DetectorConfig, Config, frozen=True, tag="background"):
    """How a `BackgroundDetector` separates foreground from background, and finds objects in it.

    The background is a mixture of Gaussians for each pixel (Zivkovic, ICPR 2004).
    """

    history: Count = 500
    """Number of frames over which the background is learned. With a larger value it changes more
    slowly."""
    deviations: Positive = 4.0
    """Number of standard deviations from the background, from which on a pixel is foreground. With
    a larger value fewer pixels are."""
    noise: Positive = 4.0
    """Noise of the camera and of compression, in gray levels: so far a color may be off those of
    the background around. With a larger value fewer pixels are foreground."""
    shadow: Annotated[float, Meta(gt=0, le=1)] = 0.5
    """Least share of its brightness that a pixel has in a shadow, which is not foreground. A
    smaller value removes darker shadows; with 1 no light is removed."""
    preview: NonNegative = 30.0
    """Seconds at the begin of a film whose usual colors are the first background, so that an object
    of the first frame leaves no ghost. Before a live camera, and where a light is switched on, they
    become the background while they come. With 0 it is the first frame."""
    trial: NonNegative = 10.0
    """Seconds for which foreground is not learned as background where no object is that has moved.
    With a larger value a mistake stays longer."""
    patience: NonNegative = 60.0
    """Seconds for which an object that has moved is not learned as background, though it stands
    still. With a larger value it is found for longer."""
    least: Share = 0.002
    """Smallest area of an object, as a share of the frame."""
    most: Share = 0.5
    """Largest area of an object, as a share of the frame."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if not 0 < self.least < self.most:
            raise ConfigError(
                f"The shares of a frame must be 0 < least < most <= 1; got {self.least}, "
                f"{self.most}."
            )

    def detector(self) -> BackgroundDetector:
        """Return the detector."""
        return BackgroundDetector(self)


class BackgroundDetector:
    """Finds moving objects before a fixed camera. A `Detector`; frames come in order.

    A camera that sways by a few pixels counts as fixed (`sway`).

    A pixel is foreground if it differs from the background in more than its light (`illumination`),
    or was a known object's in the frame before (`foreground`). Foreground is not learned for
    a time (`SelectiveUpdate`). A patch without edges of its own is no object: an object that has
    become background there has left the place (`foreground`). A frame that is mostly foreground, as
    when a light is switched on, has no detections, and the background is learned anew from it on.

    Attributes
    ----------
    warnings
        Warnings by kind, each once: a moving camera, a change of light, too many objects, or most
        of them too small; an OpenCV that is broken.
    """

    def __init__(self, config: BackgroundConfig = BackgroundConfig()) -> None:  # noqa: B008
        self.config = config
        self._model = Mixture(config.deviations)
        self._first: Bytes | None = None
        self._preview: Preview | None = None
        self._shape: tuple[int, ...] | None = None
        self._flooded = self._rest = self._frames = self._small = 0
        self._moved: Sequence[Box] = ()
        self.warnings = opencv_warnings()

    def prepare(self, frames: Iterable[Frame]) -> None:
        """Take the usual colors of a film's first `preview` seconds as the background.

        A frame that cannot be read, or of another size, ends it; the run itself reports that, at
        that frame.
        """
        preview, first = Preview(), None
        with contextlib.suppress(SourceError):
            for frame in frames:
                first = first or frame
                if frame.time - first.time > self.config.preview:
                    break
                if frame.pixels.shape != first.pixels.shape:
                    break
                preview.add(frame.pixels)
        pictures = preview.pictures
        if len(pictures) and self.config.preview:
            middle = sorted(pictures, key=np.mean)[len(pictures) // 2].copy()
            usual, sway = Exposure(middle), Sway()
            sway.refer(middle[:, :, 1])
            for picture in pictures:  # meanwhile the exposure may change, and the camera sway
                sway.find(picture, FARTHEST)
                picture[:] = moved(picture, sway.shift, middle)
                if (curves := usual.curves(picture)) is not None:
                    picture[:] = planes_of(picture, tables_of(curves)).transpose(1, 2, 0)
            self._first = usual_colors(pictures)

    def observe(self, moved: Sequence[Box]) -> None:
        """Take the boxes where the objects that have moved should be in the next frame."""
        self._moved = moved

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return the moving objects in the next frame, the largest first, all with the score 1."""
        pixels = frame.pixels
        if begins := pixels.shape != self._shape:  # there is no frame before, only the preview
            self._shape = pixels.shape
            first, self._first = self._first, None
            if first is None or first.shape != pixels.shape:
                self._begin(pixels, frame)
                return []
            self._begin(first, frame)
            self._preview = None  # that was it
        self._sway.find(pixels, FARTHEST if begins else STEP)
        pixels = moved(pixels, self._sway.shift, self._background.planes.transpose(1, 2, 0))
        known = self._shifted(self._moved, -1)
        if self._reference.has_moved(pixels) or self._sway.ends:
            self._begin(frame.pixels, frame)
            self._rest = STILL
            if not begins:
                self._warn(frame, "camera", MOVES)
            return []
        planes, background = self._exposed(pixels), self._background.planes
        rows, columns = unseen(self._sway.shift)  # they have the exposure of the background
        planes[:, rows], planes[:, :, columns] = background[:, rows], background[:, :, columns]
        self._renew(planes, frame)
        mask = self._foreground(planes, known)
        if np.count_nonzero(mask) > self.config.most * mask.size:
            self._begin(frame.pixels, frame)
            self._flooded += not begins
            if self._flooded == STILL:
                self._warn(frame, "camera", MOVES)
            elif self._flooded == 1:
                text = "the picture changes all over; its background is learned anew"
                self._warn(frame, "light", text)
            return []
        self._flooded = 0
        mask = without_tremble(mask, planes, self._background)
        self._memory.remember(mask, known)
        if self._frames % LEARNED == 0:
            learned = self._update.learned_from(planes, mask, frame.time, known)
            self._model.learn(learned, min(LEARNED * self._rate, 1.0))
        if self._rest:
            self._rest -= 1
            return []
        boxes = self._objects(frame, pixels, mask, known)
        return [Detection(box) for box in self._shifted(boxes, 1)]

    def _begin(self, pixels: Bytes, frame: Frame) -> None:
        planes = planes_of(pixels)
        self._exposure = Exposure(pixels)
        self._reference = ReferenceImage(pixels)
        self._preview, self._begun = Preview(), frame.time
        self._preview.add(pixels)
        self._learn(planes, frame)
        self._background = Background(planes, self.config.noise)
        self._sway = Sway()
        self._sway.refer(planes[1])
        self._memory = ForegroundMemory()

    def _learn(self, planes: Planes, frame: Frame) -> None:
        """Take a picture as the background, and forget the frames before."""
        config = self.config
        self._update = SelectiveUpdate(planes, frame.time, config.trial, config.patience)
        self._model.begin(planes)
        self._frames = 0

    def _renew(self, planes: Planes, frame: Frame) -> None:
        """Take the usual colors since it began as the background, as often as they tell more."""
        if self._preview and frame.time - self._begun > self.config.preview:
            self._preview = None
        if self._preview and self._preview.add(planes.transpose(1, 2, 0)):
            self._learn(planes_of(usual_colors(self._preview.pictures)), frame)

    @property
    def _rate(self) -> float:
        """The share of the frame that enters the background: more at the start."""
        return max(1 / (2 * (FIRST + self._frames)), 1 / self.config.history)

    def _foreground(self, planes: Planes, known: Sequence[Box]) -> Bytes:
        """Return the foreground without shadows, (H, W) of 0 and 1."""
        config = self.config
        if self._frames % RENEWED == 0:
            self._background = Background(self._model.picture(), config.noise)
        if self._frames % LASTS == 0:
            self._sway.refer(self._background.planes[1])
        self._frames += 1
        differs = self._model.foreground(planes)
        limits = LightLimits(config.shadow, HIGHLIGHT, TINT, TEXTURE)
        mask = without_light(differs, planes, self._background, limits)
        return self._memory.added(with_enclosed(mask, differs), differs, known)

    def _objects(self, frame: Frame, pixels: Bytes, mask: Bytes, known: Sequence[Box]) -> list[Box]:
        """Return the boxes of the objects in the foreground."""
        least = self.config.least
        boxes = blobs(mask, least, known)
        if self._frames % SMALL_EVERY == 0 and "small" not in self.warnings:
            self._small += small_patches(mask, least) - SMALL_RATIO * len(boxes)
            if self._small > SMALL_EXCESS:
                text = (
                    f"most of what moves has less than {100 * least:g} % of the picture, and is "
                    f"left out; if these are objects, give a detector.least below {least:g}, such "
                    f"as {least / SMALL:.2g}"
                )
                self._warn(frame, "small", text)
        if boxes:
            boxes = without_ghosts(boxes, mask, pixels, self._background.planes[1])
        if len(boxes) > LIMIT:
            text = f"there are {len(boxes)} moving patches; only the {LIMIT} largest are taken"
            self._warn(frame, "flood", text)
        return boxes[:LIMIT]

    def _shifted(self, boxes: Sequence[Box], way: int) -> list[Box]:
        """Return boxes as far from their places as the camera sways, to and fro."""
        x, y = self._sway.shift
        return [box._replace(x=box.x + way * x, y=box.y + way * y) for box in boxes]

    def _exposed(self, pixels: Bytes) -> Planes:
        """Return a frame with its usual brightness and contrast."""
        curves = self._exposure.curves(pixels)
        if curves is None:
            return planes_of(pixels)
        self._exposure.learn(curves)
        tables = tables_of(curves)
        planes = planes_of(pixels, tables)
        for plane, usual, table in zip(planes, self._background.planes, tables, strict=True):
            if table[BRIGHTEST] < BRIGHTEST:  # what is too bright may be any brighter color
                clipped = plane >= table[BRIGHTEST]
                np.maximum(plane, usual, out=plane, where=clipped)
            if table[DARKEST] > DARKEST:  # and what is too dark any darker one
                clipped = plane <= table[DARKEST]
                np.minimum(plane, usual, out=plane, where=clipped)
        return planes

    def _warn(self, frame: Frame, kind: str, text: str) -> None:
        self.warnings.setdefault(kind, f"Frame {frame.index}: {text}.")
