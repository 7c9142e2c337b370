"""Where the target is expected in the next frame, and in which light, before it is looked at.

Four models of motion predict the displacement: the target stays in the picture, it stays in the
scene while the camera moves, it goes on as in the last frame, or it does so in the scene. The model
with the least recent error is followed, as in a filter of interacting multiple models (Blom and
Bar-Shalom, IEEE Transactions on Automatic Control 1988) of which only the likeliest model counts.
The camera's motion is the shift between two small pictures by phase correlation (Kuglin and Hines,
International Conference on Cybernetics and Society 1975).

A cloud, a lamp or the exposure of the camera scales all colors. Then models of colors do not know
the target any more, and a tracker that is not certain does not learn how it looks now. So the
change of the light is measured over the whole picture, where the target counts little: as the
median ratio of two small pictures, after the shift of the camera. Frames are seen in the light in
which the models learned, and the models learn what they see in that light.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import msgspec
import numpy as np
from msgspec.structs import replace

from motes import kernels
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats, Singles, Spectra
from motes.cues.fourier import fast_length, irfft2, rfft2, taper, vertex
from motes.cues.search_window import cut

COLUMNS = 96
"""Largest number of rows and of columns."""


def small_picture(frame: Frame) -> Singles:
    """Return the sums of red, green and blue at evenly spaced points of a frame, (h, w).

    All trackers of a frame share it.
    """
    picture: Singles | None = frame.cache.get(small_picture)
    if picture is None:
        rows, columns = small_size(frame.height, frame.width)
        step = frame.width / columns, frame.height / rows
        center = Ellipse((frame.width - 1) / 2, (frame.height - 1) / 2, 1.0, 1.0)
        picture = cut(frame, center, step, (rows, columns)).sum(axis=0)
        frame.cache[small_picture] = picture
    return picture


@cache
def small_size(height: int, width: int) -> tuple[int, int]:
    """Return the number of rows and columns of the small picture of a frame.

    Fourier transforms of these sizes are fast.
    """
    shrink = min(1.0, COLUMNS / max(height, width))
    rows, columns = (max(round(side * shrink), 1) for side in (height, width))
    return fast_length(rows), fast_length(columns)


def overlap(before: Singles, now: Singles, shift: Floats, frame: Frame) -> tuple[Singles, Singles]:
    """Return what two small pictures both show, if the scene has moved by a shift.

    The pictures are (h, w); the shift is x and y in pixels of the frames, which are of one size.
    """
    rows, columns = now.shape
    across = round(float(shift[0]) * columns / frame.width)
    down = round(float(shift[1]) * rows / frame.height)

    def part(picture: Singles, right: int, low: int) -> Singles:
        left, top = max(right, 0), max(low, 0)
        return picture[top : max(rows + min(low, 0), 0), left : max(columns + min(right, 0), 0)]

    return part(before, -across, -down), part(now, across, down)


def difference(pictures: tuple[Singles, Singles]) -> float:
    """Return the mean difference of two pictures; it is infinite if they show nothing."""
    before, now = pictures
    return kernels.planes.mean_difference(now, before) if now.size else math.inf


DARK, BRIGHT = 15, 245
"""Gray levels between which the light of a point is known: the camera cuts off what is beyond."""
LEAST_POINTS = 100
"""With fewer points that both pictures show, the light counts as unchanged."""
LARGEST_CHANGE = math.log(2)
"""Largest change from one frame to the next, as a logarithm: more is a cut to another scene."""
LARGEST_LEVEL = math.log(16)
"""No more is taken off: in a sixteenth of the light, a byte has no colors left."""
UNNOTICED = 0.12
"""A smaller difference of the light is left: the models follow it by themselves, and a camera that
moves over a scene seems to change the light by up to 0.07. It moves a gray of 128 by two bins of
colors."""


class Light(msgspec.Struct, frozen=True):
    """The light after a frame."""

    level: float = 0.0
    """Logarithm of the light, relative to that in which the models learned."""

    def followed(self, before: Singles, now: Singles) -> Light:
        """Return the light of the next frame.

        The pictures (h, w) are what the last and the next frame both show (`overlap`).
        """
        least, most = 3 * DARK, 3 * BRIGHT  # pictures are sums of three colors
        known, ratio = kernels.planes.median_ratio(now, before, least, most)
        if known < LEAST_POINTS:
            return self
        change = min(max(math.log(ratio), -LARGEST_CHANGE), LARGEST_CHANGE)
        return Light(self.level + change)

    def taken_off(self, frame: Frame) -> Frame:
        """Return a frame in the light in which the models learned."""
        if abs(self.level) < UNNOTICED:
            return frame
        level = min(max(self.level, -LARGEST_LEVEL), LARGEST_LEVEL)
        pixels = np.empty(frame.pixels.shape, np.uint8)
        kernels.planes.relight(frame.pixels, math.exp(-level), pixels)
        return Frame(frame.index, frame.time, pixels)

    def learned(self, rate: float) -> Light:
        """Return the light after the models have learned a share `rate` of the frame.

        What the models follow by themselves need not be taken off for ever, and errors of single
        changes do not add up.
        """
        return Light((1 - rate) * self.level)


ERROR_RATE = 0.1
"""Share of the last frame's error in the running mean of a model's errors."""
LEAST_SIGMA = 0.05
"""Standard deviation of a place after a perfect prediction, in mean sides of the target."""
SIGMAS = 2.0
"""Standard deviation of a place in mean errors of the predictions before: motion changes now and
then, so it is wider than the normal density that fits them."""

WHITENED = 1e-3
"""Frequencies weaker than this share of the mean strength count less in the phase correlation."""


class MotionHistory(msgspec.Struct, frozen=True, eq=False):
    """What the prediction knows after a frame."""

    picture: Singles
    spectrum: Spectra
    """The last small picture (h, w), and its transform."""
    camera: Floats
    velocity: Floats
    """(2,), the shift of the scene and of the target from the frame before to the last, in
    pixels."""
    errors: Floats
    """(4,), the running mean of each model's error, in mean sides of the target; in the order of
    `Prediction.shifts`."""
    seen: int = 0
    """In how many frames these were measured."""

    def transition(self, target: Ellipse) -> Transition | None:
        """Return where a target is expected whose center is the predicted one.

        It is None as long as no prediction has been compared with what was seen.
        """
        if not self.seen:
            return None
        sigma = LEAST_SIGMA + SIGMAS * float(self.errors.min())
        return Transition(target.x, target.y, sigma * target.side)

    def leap(self, before: Ellipse, now: Ellipse) -> float:
        """Return the log odds against a move that does not go on as in the last frame."""
        x, y = np.add(before[:2], self.velocity).tolist()
        transition = self.transition(before._replace(x=x, y=y))
        return 0.0 if transition is None else -float(transition.log_density(np.array(now[:2])))


def started(picture: Singles) -> MotionHistory:
    """Return the history after the first frame, given its small picture."""
    return MotionHistory(picture, spectrum_of(picture), np.zeros(2), np.zeros(2), np.zeros(4))


class Transition(NamedTuple):
    """Where the target is expected: the transition density of the filter, a normal one.

    It keeps a target that moves steadily from being given to a neighbor who looks alike. It is as
    wide as the predictions were wrong, so that erratic motion is not held back.
    """

    x: float
    y: float
    """The predicted center."""
    sigma: float
    """Standard deviation in each direction, in pixels."""

    def log_density(self, places: Floats) -> Floats:
        """Return the logarithm of the density at places (N, 2), relative to the center's, (N,)."""
        out: Floats = ((places - self[:2]) ** 2).sum(axis=-1) / (-2 * self.sigma**2)
        return out


class Prediction(NamedTuple):
    """What is predicted for a frame."""

    picture: Singles
    spectrum: Spectra
    """The frame's small picture, and its transform."""
    shifts: Floats
    """(4, 2), the displacement of the target that each model predicts, in pixels: it stays in the
    picture, stays in the scene, goes on in the picture, goes on in the scene."""
    shared: tuple[Singles, Singles]
    """What the small pictures of the last frame and of this one both show: after the camera's
    shift, or without it if they are more alike so."""

    def likeliest(self, history: MotionHistory) -> Floats:
        """Return the displacement (2,) of the model with the least recent error."""
        best: Floats = self.shifts[np.argmin(history.errors)]
        return best

    def update(
        self, history: MotionHistory, before: Ellipse, after: Ellipse | None
    ) -> MotionHistory:
        """Return the history after the frame.

        A target that was not seen, so that `after` is None, counts as at rest in the scene.
        """
        camera = self.shifts[1]
        if after is None:
            now = {"picture": self.picture, "spectrum": self.spectrum}
            return replace(history, **now, camera=camera, velocity=camera)
        velocity = np.subtract(after[:2], before[:2])
        errors = np.hypot(*(self.shifts - velocity).T) / before.side
        rate = max(ERROR_RATE, 1 / (history.seen + 1))  # at first, the mean of all frames
        errors = history.errors + rate * (errors - history.errors)
        picture, spectrum, seen = self.picture, self.spectrum, history.seen + 1
        return MotionHistory(picture, spectrum, camera, velocity, errors, seen)


def predictions(history: MotionHistory, picture: Singles, frame: Frame) -> Prediction:
    """Return what the four models predict for a frame, given its small picture."""
    spectrum = spectrum_of(picture)
    camera = camera_shift(history.spectrum, spectrum, frame)
    moved, still = overlap(history.picture, picture, camera, frame), (history.picture, picture)
    # A blurred or sudden pan gives a wrong shift now and then. Then more is alike at rest.
    shared = min(moved, still, key=difference)
    steady = history.velocity
    shifts = np.array([np.zeros(2), camera, steady, camera + steady - history.camera])
    return Prediction(picture, spectrum, shifts, shared)


def spectrum_of(picture: Singles) -> Spectra:
    """Return the transform (h, w // 2 + 1) of a small picture (h, w), tapered."""
    return rfft2((picture - picture.mean()) * taper(*picture.shape))


def camera_shift(before: Spectra, after: Spectra, frame: Frame) -> Floats:
    """Return the shift of the scene between two frames of one size, in pixels, (2,): x and y.

    It is the maximum of the phase correlation, refined by a parabola in each direction.
    """
    rows, columns = small_size(frame.height, frame.width)
    product = before.conj() * after
    strength = np.abs(product)
    # Multiplied, since numpy divides complex numbers by real ones as if these were complex, too.
    product *= 1 / (strength + WHITENED * float(strength.mean()) + np.finfo(np.float32).tiny)
    plane = irfft2(product, columns)
    row, column = divmod(int(np.argmax(plane)), columns)
    across = _peak(plane[row], column) * frame.width / columns
    down = _peak(plane[:, column], row) * frame.height / rows
    return np.array([across, down])


def _peak(line: Singles, index: int) -> float:
    """Return the place of the maximum of a cyclic line, as a signed shift, between its values."""
    size = len(line)
    between = vertex(line[index - 1], line[index], line[(index + 1) % size])
    return (index if index <= size // 2 else index - size) + between
