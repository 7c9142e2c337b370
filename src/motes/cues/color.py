"""Color: the histogram of a target, and the posterior of its colors against its surroundings.

Histograms are under a weighting kernel, and compared by the Bhattacharyya distance (Nummiaro et
al., section III). The posterior is the probability that a pixel belongs to the target, by Bayes'
rule with equal priors, from both histograms (Bertinetto et al., Staple, CVPR 2016, section 3.4).
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from msgspec import Meta
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import kernels
from motes.core.config import Config, Share
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, as_ellipse, as_ellipses
from motes.core.types import Floats, Singles
from motes.cues.base import Cue, HistogramModel, PixelHistogramCue, check_bins
from motes.cues.sampling import Profile
from motes.cues.search_window import WindowModel
from motes.kernels.structures import ColorBins, ColorTarget

Bins = Annotated[int, Meta(ge=1, le=64)]

SPACES = {"rgb": kernels.color.RGB, "hsv": kernels.color.HSV, "hsv+v": kernels.color.HSV_V}


class ColorModel(HistogramModel, frozen=True, eq=False, dict=True, tag="color"):
    """A target's color histogram."""

    @cached_property
    def occupied(self) -> NDArray[np.intp]:
        """The indices of the occupied bins."""
        return (self.histogram > 0).nonzero()[0]

    @cached_property
    def roots(self) -> Floats:
        """Square roots of the occupied bins, in order; empty bins add nothing to equation 6."""
        return np.sqrt(self.histogram[self.occupied])

    @cached_property
    def slots(self) -> NDArray[np.uint32]:
        """For each bin, its index among the occupied bins; their number if it is empty."""
        count = len(self.occupied)
        slots = np.full(self.histogram.size, count, np.uint32)
        slots[self.occupied] = np.arange(count, dtype=np.uint32)
        return slots


class Color(PixelHistogramCue, frozen=True):
    """Weighted color histogram of an ellipse: Nummiaro et al., equations 2 to 7."""

    space: Literal["rgb", "hsv", "hsv+v"] = "rgb"
    """Color space of the histogram. With `rgb` and `hsv` it has three dimensions. With `hsv+v`, a
    pixel with color falls into a bin of hue and saturation, any other into a bin of value alone
    (Zhao and Pei, section 2.1). A pixel has color if its saturation is above 0.1 and its value
    above 0.2 (Perez et al., ECCV 2002)."""
    bins: tuple[Bins, Bins, Bins] = (8, 8, 8)
    """Number of bins of each channel: 8x8x8 for `rgb`, 8x8x4 for `hsv`, 8x8 + 8 for `hsv+v`. More
    bins separate more colors, but the histogram changes more with the light."""
    kernel: Profile = "radial"

    model_type = ColorModel

    @property
    def size(self) -> int:
        """Number of bins of a histogram, m."""
        if self.space == "hsv+v":
            return self.bins[0] * self.bins[1] + self.bins[2]
        return math.prod(self.bins)

    def histograms(self, frame: Frame, ellipses: Floats) -> Floats:
        """Return the histogram of each ellipse (equation 3).

        Parameters
        ----------
        frame
            The picture.
        ellipses
            (N, 5): x, y, a, b, theta.

        Returns
        -------
        (N, m); each row sums to 1, or is zero where the ellipse lies outside the frame.
        """
        m, ellipses = self.size, as_ellipses(ellipses)
        histograms = np.empty((len(ellipses), m))
        slots = np.arange(m, dtype=np.uint32)
        kernels.color.histograms(
            frame.pixels, ellipses, self.reading, slots, self._bins, histograms
        )
        return histograms

    def distances(self, model: ColorModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return the Bhattacharyya distance of each ellipse (N, 5) to the model, shape (N,)."""
        check_bins(model, self.size)
        ellipses = as_ellipses(ellipses)
        distances = np.empty(len(ellipses))
        kernels.color.distances(frame.pixels, ellipses, self.target(model), distances)
        return distances

    def target(self, model: ColorModel) -> ColorTarget:
        """Return what kernels need to compare ellipses with a model, which has the cue's bins."""
        return ColorTarget(self.reading, model.slots, model.roots, self._bins)

    def shift(self, model: ColorModel, frame: Frame, ellipse: Ellipse) -> tuple[float, float]:
        """Return the ellipse's center after one mean-shift iteration.

        It is the mean of the ellipse's pixels. The weight of a pixel is sqrt(q / p) of its bin,
        with the model's histogram q and the region's p. This is exact for the Epanechnikov kernel.
        Comaniciu, Ramesh and Meer, Real-time
        tracking of non-rigid objects using mean shift, CVPR 2000, equations 10 and 11.
        """
        check_bins(model, self.size)
        region = np.array(as_ellipse(ellipse))
        seen = self.histograms(frame, region[None])[0][model.histogram > 0]
        ratios = np.zeros(seen.size + 1)
        np.divide(model.roots, np.sqrt(seen), out=ratios[:-1], where=seen > 0)
        center = region[:2].copy()
        kernels.color.mean_shift(
            frame.pixels, region, self.sampling.lattice, self.sampling.grid, model.slots, ratios,
            self._bins, center,
        )  # fmt: skip
        return float(center[0]), float(center[1])

    @cached_property
    def _bins(self) -> ColorBins:
        return ColorBins(SPACES[self.space], *self.bins)


COLORS = 32**3
GRAY = 256 / 32 / 2
"""Mean difference between a pixel's channels below which a film is gray: half of a color's side."""
CORE_FRACTION = 0.8
"""Share of the box's sides: every pixel within counts as the target's."""
BORDER = 0.3
"""Width of the strips inside and outside of the border, as a share of the half sides."""
SURROUNDINGS = 1.4
"""Size of the outer box of the contrast, relative to the target's box."""


class PosteriorModel(WindowModel, frozen=True, eq=False, tag="posterior"):
    """The learned colors of a target and of its surroundings."""

    inside: Singles
    outside: Singles
    """(32768,), shares of the colors in the target and around it; each sums to 1."""
    texture: PosteriorModel | None = None
    """In a gray film, the same of its texture."""


class Posterior(Cue, Config, frozen=True):
    """Posterior of the target's colors against its surroundings, updated while it is present.

    The distance is 1 - mean of p(target | color) over an ellipse's box.
    """

    learning_rate: Share = 0.04
    """Share of the current frame in the updated color histograms. With a larger value they follow
    changes faster; 0 keeps them fixed. The default is higher than that of other cues, since colors
    change with the light."""

    def learn(self, frame: Frame, ellipse: Ellipse) -> PosteriorModel:
        """Return the colors of the region in `ellipse` and of its surroundings."""
        ellipse = as_ellipse(ellipse)
        inside, outside = np.zeros((2, COLORS), np.float32)
        model = PosteriorModel(ellipse.a, ellipse.b, ellipse, inside, outside)
        if is_gray(frame):
            model = replace(model, texture=model)
        return self.updated(model, model.grid.sample_window(frame, ellipse), 1.0)

    def distances(self, model: PosteriorModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return 1 - mean posterior of ellipses (N, 5), each in a window near it, (N,)."""
        grid, ellipses = model.grid, as_ellipses(ellipses)
        out = np.zeros(len(ellipses))
        for place, mine in grid.tile_windows(frame, model.place, ellipses):
            offsets = grid.offsets(place, ellipses[mine, :2])
            halves = CORE_FRACTION * ellipses[mine, 2:4] / grid.step(place)
            integral, _ = self.integrals(model, grid.sample_window(frame, place))
            out[mine] = means(integral, np.hstack([offsets, halves]))
        return 1 - out

    def update_reading(
        self, model: PosteriorModel, frame: Frame, ellipse: Ellipse
    ) -> PosteriorModel:
        """Return the model updated with the colors of a target in `ellipse`."""
        window = model.grid.sample_window(frame, ellipse)
        return replace(self.updated(model, window, self.learning_rate), place=ellipse)

    def learn_also(self, model: PosteriorModel, frame: Frame, ellipse: Ellipse) -> PosteriorModel:
        """Return the mean of the model's colors and those of the region in `ellipse`."""
        return self.updated(model, model.grid.sample_window(frame, ellipse), 0.5)

    def updated(
        self, model: PosteriorModel, window: Singles, rate: float, x: float = 0.0, y: float = 0.0
    ) -> PosteriorModel:
        """Return the model moved by a share `rate` towards the colors of a window (3, H, W).

        The target is x, y samples off the window's center.
        """
        grid = model.grid
        middle, half = np.add(grid.center, (x, y)), np.array(grid.half)
        inner, outer = (
            (*(middle - share * half).tolist(), *(middle + share * half).tolist())
            for share in (CORE_FRACTION, 1.0)
        )
        inside, outside = (1 - rate) * model.inside, (1 - rate) * model.outside
        kernels.color_posterior.add_colors(window, inner, outer, rate, inside, outside)
        texture = model.texture and self.updated(model.texture, textured(window), rate, x, y)
        return replace(model, inside=inside, outside=outside, texture=texture)

    def integral(self, model: PosteriorModel, window: Singles) -> Floats:
        """Return the integral image of a window's posterior, (H + 1, W + 1); window: (3, H, W)."""
        out = np.empty((window.shape[1] + 1, window.shape[2] + 1))
        kernels.color_posterior.color_integral(window, model.inside, model.outside, out)
        return out

    def integrals(self, model: PosteriorModel, window: Singles) -> tuple[Floats, Floats]:
        """Return the integral images that tell the place and the border, each (H + 1, W + 1).

        They are one, but for a gray film: there texture tells a target from its surroundings, which
        gray does not; but it is blurred, so the border is told by gray.
        """
        integral = self.integral(model, window)
        if model.texture is None:
            return integral, integral
        return self.integral(model.texture, textured(window)), integral


def is_gray(frame: Frame) -> bool:
    """Return whether a frame has no colors but the noise of its compression."""
    pixels = frame.pixels[::4, ::4].astype(np.int16)
    differences = np.abs(pixels - pixels[..., 1:2]).mean(axis=(0, 1))
    return float(differences.max()) < GRAY


def textured(window: Singles) -> Singles:
    """Return the texture of a gray window (3, H, W) in the place of its colors."""
    out = np.empty_like(window)
    kernels.color_posterior.texture(window[1], out)
    return out


def means(integral: Floats, boxes: Floats) -> Floats:
    """Return the mean posterior over boxes, (N,).

    `integral` (H + 1, W + 1) is the result of `Posterior.integral`. Boxes (N, 4) are x and y off
    the window's center, half width and half height, in samples.
    """
    out = np.empty(len(boxes))
    kernels.bilinear.box_means(integral, boxes, out)
    return out


def _scales(*scales: float) -> Floats:
    """Return factors (n, 1, 4) by which the sides of boxes (N, 4) are multiplied."""
    return np.array([[(1.0, 1.0, scale, scale)] for scale in scales])


BORDERS, CONTRAST = _scales(1 - BORDER, 1.0, 1 + BORDER), _scales(CORE_FRACTION, 1.0, SURROUNDINGS)
"""The sizes that `borders` and `contrast` compare, as factors of boxes."""


def borders(integral: Floats, boxes: Floats) -> Floats:
    """Return the mean posterior just inside and just outside of boxes (see `means`), (N, 2)."""
    low, one, high = means(integral, (BORDERS * boxes).reshape(-1, 4)).reshape(3, -1)
    less, more = (1 - BORDER) ** 2, (1 + BORDER) ** 2
    return np.stack([(one - less * low) / (1 - less), (more * high - one) / (more - 1)], axis=1)


def contrast(integral: Floats, box: Floats) -> float:
    """Return the mean posterior in a target's box (4,) minus that around it, -1 to 1."""
    core, one, wide = means(integral, (CONTRAST * box).reshape(-1, 4)).tolist()
    area = SURROUNDINGS**2
    return float(core - (area * wide - one) / (area - 1))
