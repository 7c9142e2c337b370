"""Is a pixel the target's? Its color's share inside the target beside its share around it.

p(target | color) by Bayes' rule with equal priors, from histograms of the target and of its
surroundings (Bertinetto et al., Staple, CVPR 2016, section 3.4).
"""

from __future__ import annotations

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import kernels
from motes.config import Config
from motes.cues.window import Grid, Singles, grid
from motes.frame import Frame
from motes.geometry import Ellipse

Floats = NDArray[np.float64]

COLORS = 32**3
CORE = 0.8
"""Share of the box's sides within which every pixel counts as the target's."""
BORDER = 0.3
"""Width of the strips on both sides of the border, as a share of the half sides."""


class PosteriorModel(msgspec.Struct, frozen=True, eq=False, tag="posterior"):
    """Shares of colors.

    Attributes
    ----------
    inside, outside
        (32768,) in the target and around it; each sums to 1.
    a, b
        Half-axes of the target's first region, from which the grid follows.
    """

    inside: Singles
    outside: Singles
    a: float
    b: float

    @property
    def grid(self) -> Grid:
        """The samples that are read."""
        return grid(self.a, self.b)


class Posterior(Config, frozen=True):
    """The cue: 1 - mean of p(target | color) over an ellipse's box.

    Attributes
    ----------
    haste
        How many times faster than other cues it learns: colors change with the light.
    """

    haste: float = 2.0

    def learn(self, frame: Frame, ellipse: Ellipse) -> PosteriorModel:
        """Return the colors of the region in `ellipse` and of its surroundings."""
        box = ellipse.box
        a, b = box.width / 2, box.height / 2
        inside, outside = self.lesson(grid(a, b), frame, ellipse)
        return PosteriorModel(inside, outside, a, b)

    def distances(self, model: PosteriorModel, frame: Frame, ellipses: Floats) -> Floats:
        """Return 1 - mean posterior of ellipses (N, 5), in the window around their mean, (N,)."""
        place = Ellipse(*ellipses.mean(axis=0).tolist())
        integral = self.integral(model, frame, place)
        return 1 - means(integral, model.grid, place, ellipses, CORE)

    def lesson(
        self, samples: Grid, frame: Frame, place: Ellipse, x: float = 0.0, y: float = 0.0
    ) -> tuple[Singles, Singles]:
        """Return the colors inside and around a target x, y samples off its window's center."""
        column, row = samples.center
        half = np.array([samples.width, samples.height]) / 2
        middle = np.array([column + x, row + y])
        inner, outer = (
            (*(middle - share * half).tolist(), *(middle + share * half).tolist())
            for share in (CORE, 1.0)
        )
        inside, outside = np.empty(COLORS, np.float32), np.empty(COLORS, np.float32)
        kernels.color_counts(samples.cut(frame, place), inner, outer, inside, outside)
        return inside, outside

    def taught(
        self,
        model: PosteriorModel,
        frame: Frame,
        place: Ellipse,
        rate: float,
        x: float = 0.0,
        y: float = 0.0,
    ) -> PosteriorModel:
        """Return the model with a share `rate` (times `haste`) of what a window shows."""
        inside, outside = self.lesson(model.grid, frame, place, x, y)
        rate = min(self.haste * rate, 1.0)
        return replace(
            model,
            inside=(1 - rate) * model.inside + rate * inside,
            outside=(1 - rate) * model.outside + rate * outside,
        )

    def integral(self, model: PosteriorModel, frame: Frame, place: Ellipse) -> Floats:
        """Return the posterior of the window around `place`, summed up, (H + 1, W + 1)."""
        samples = model.grid.cut(frame, place)
        out = np.empty((samples.shape[1] + 1, samples.shape[2] + 1))
        kernels.color_integral(samples, model.inside, model.outside, out)
        return out


def means(
    integral: Floats, samples: Grid, place: Ellipse, ellipses: Floats, scale: float
) -> Floats:
    """Return the mean posterior over the boxes of upright ellipses (N, 5), scaled, (N,).

    Parameters
    ----------
    integral
        (H + 1, W + 1), as `Posterior.integral` has it, of the window around `place`.
    samples
        Its grid.
    place
        Its target.
    ellipses
        (N, 5) in pixels.
    scale
        Of the boxes.
    """
    step_x, step_y = samples.step(place)
    column, row = samples.center
    corner = place.x - (column + 0.5) * step_x, place.y - (row + 0.5) * step_y
    out = np.empty(len(ellipses))
    kernels.box_means(integral, ellipses, corner, (step_x, step_y), scale, out)
    return out


def borders(integral: Floats, samples: Grid, place: Ellipse, ellipses: Floats) -> Floats:
    """Return the mean posterior just inside and just outside of boxes, (N, 2); as for `means`."""
    low, one, high = (
        means(integral, samples, place, ellipses, scale) for scale in (1 - BORDER, 1.0, 1 + BORDER)
    )
    less, more = (1 - BORDER) ** 2, (1 + BORDER) ** 2
    return np.stack([(one - less * low) / (1 - less), (more * high - one) / (more - 1)], axis=1)
