"""The papers' trackers as configuration values; each number names where it comes from."""

from __future__ import annotations

import difflib
from typing import Any

from msgspec.structs import replace

from motes.config import from_dict, merge, to_dict
from motes.cues.color import Color
from motes.errors import ConfigError
from motes.likelihood import Gaussian
from motes.meanshift import Kalman, MeanShift
from motes.motion import ConstantVelocity, Noise
from motes.particle_filter import Adaptation, ParticleFilter
from motes.presence import AppearanceRule, Calibration
from motes.resampling import Resampling
from motes.sampling import EveryPixel, Lattice

TrackerConfig = ParticleFilter | MeanShift

# Nummiaro et al. give no value for sigma and for the noise, only that the noise is proportional to
# the first region. These are round numbers from a plateau over 24 real sequences. Three things are
# not the paper's: a persistence below 1, the lattice, which stands for every pixel, and the margin
# that the appearance rule asks for in addition.
NUMMIARO = ParticleFilter(
    particles=100,  # section VII
    motion=ConstantVelocity(  # equations 8 and 9
        noise=Noise(position=0.6, size=0.05, size_return=0.05, aspect=0.003),
        velocity=0.5,
        persistence=0.8,
    ),
    cue=Color(space="rgb", bins=(8, 8, 8), kernel="radial", sampling=Lattice(points=256)),  # III
    likelihood=Gaussian(sigma=0.1),  # equation 10
    resampling=Resampling(scheme="multinomial", threshold=1.0),  # figure 2
    presence=AppearanceRule(fraction=0.1, deviations=2.0, margin=0.7),  # section V, equation 13
)

# A model that learns is nearer to what it sees, right or wrong: a calibration of its own.
ADAPTIVE = replace(
    NUMMIARO,
    adaptation=Adaptation(rate=0.05, anchor=0.4),  # sections IV and VIII
    presence=replace(NUMMIARO.presence, margin=0.75),
    calibration=Calibration(middle=0.31, width=0.11),
)

MEAN_SHIFT = MeanShift(  # section VI
    cue=Color(space="rgb", bins=(8, 8, 8), kernel="epanechnikov", sampling=EveryPixel()),
    scale=0.05,
)

PRESETS: dict[str, TrackerConfig] = {
    "nummiaro": NUMMIARO,
    "nummiaro:adaptive": ADAPTIVE,
    "mean_shift": MEAN_SHIFT,
    "mean_shift:kalman": replace(MEAN_SHIFT, prediction=Kalman()),  # section VI, predicted start
}


def preset(name: str) -> TrackerConfig:
    """Return a preset's configuration.

    Raises
    ------
    ConfigError
        For an unknown name, with the nearest known one.
    """
    if name in PRESETS:
        return PRESETS[name]
    near = difflib.get_close_matches(name, PRESETS, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise ConfigError(f"No preset {name!r}; {hint}known are {', '.join(PRESETS)}.")


def configure(base: TrackerConfig, *changes: dict[str, Any]) -> TrackerConfig:
    """Return a configuration with changes laid over it, from plain nested values (TOML, flags).

    Raises
    ------
    ConfigError
        For an unknown key or a value that does not fit.
    """
    values = to_dict(base)
    for change in changes:
        values = merge(values, change)
    config: TrackerConfig = from_dict(values, TrackerConfig)
    return config
