"""What a tracker compares around its estimate in a frame: surfaces of its cues, and orientations.

These are figure 3 of Nummiaro et al. and figure 1 of Maggio et al.
"""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.cues.structure_tensor import Orientation
from motes.sot.presets import TrackerConfig
from motes.sot.step_info import StepInfo

STEPS = 61
"""Number of places in x and in y at which a surface is computed."""


def rho_surface(
    config: TrackerConfig, frame: Frame, info: StepInfo
) -> tuple[Floats, Floats, Floats]:
    """Return the Bhattacharyya coefficient for the estimate's ellipse where it is moved to.

    Returns
    -------
    The places in x (n,) and in y (m,), and the coefficients over all cues (m, n).
    """
    x, y, distances = cue_distances(config, frame, info)
    rho = np.zeros(x.size * y.size)
    for name, each in distances.items():
        rho += info.cue_weights[name] * (1 - each**2)
    return x, y, rho.reshape(y.size, x.size)


def cue_distances(
    config: TrackerConfig, frame: Frame, info: StepInfo
) -> tuple[Floats, Floats, dict[str, Floats]]:
    """Return how far the estimate's ellipse is from the target model where it is moved to.

    Returns
    -------
    The places in x (n,) and in y (m,), and for each cue the distances (m * n,), row by row.
    """
    ellipse = info.track.ellipse
    reach = max(ellipse.box[2:])
    x = np.linspace(max(ellipse.x - reach, 0), min(ellipse.x + reach, frame.width - 1), STEPS)
    y = np.linspace(max(ellipse.y - reach, 0), min(ellipse.y + reach, frame.height - 1), STEPS)
    moved = np.tile(np.array(ellipse), (STEPS, STEPS, 1))
    moved[..., 0], moved[..., 1] = np.meshgrid(x, y)
    places = moved.reshape(-1, 5)
    cues = config.cues.items()
    return x, y, {name: cue.distances(info.models[name], frame, places) for name, cue in cues}


def orientation_of(cue: Orientation, frame: Frame, ellipse: Ellipse) -> tuple[Floats, Floats]:
    """Return the ROH and the FOH of a region: its orientations, turned with it, and a spectrum."""
    rotated, spectrum = (
        replace(cue, form=form).learn(frame, ellipse).histogram for form in ("rotated", "fourier")
    )
    return rotated, spectrum
