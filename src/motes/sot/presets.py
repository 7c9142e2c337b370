"""The trackers of the papers as configurations; comments give the source of each number."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from typing import Any

from msgspec.structs import replace

from motes.core.config import from_dict, merge
from motes.core.errors import ConfigError
from motes.core.registry import open_registry, tag_of
from motes.cues.base import CUES
from motes.cues.color import Color
from motes.cues.gradients import Edges, Hog
from motes.cues.sampling import EveryPixel, Lattice, Sampling
from motes.cues.structure_tensor import Orientation
from motes.sot.algorithm import TRACKERS, Algorithm
from motes.sot.discriminative.tracker import Discriminative
from motes.sot.filtering.appearance_rule import AppearanceRule, Calibration
from motes.sot.filtering.bin_updates import AnchoredKalman, GaussianBins, KalmanBins
from motes.sot.filtering.fusion import Fixed, PrintedMixture
from motes.sot.filtering.likelihood import BestParticle, Exponential, Gaussian
from motes.sot.filtering.model_update import ExponentialForgetting, PerCue
from motes.sot.filtering.motion import Autoregressive, ConstantVelocity, EllipseWalk, Noise
from motes.sot.filtering.resampling import Multinomial
from motes.sot.mean_shift import MeanShift
from motes.sot.particle_filter import ParticleFilter

TrackerConfig = ParticleFilter | MeanShift | Discriminative

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
    color=Color(space="rgb", bins=(8, 8, 8), kernel="radial", sampling=Lattice(points=256)),  # III
    likelihood=Gaussian(sigma=0.1),  # equation 10
    resampling=Multinomial(threshold=1.0),  # figure 2
    # Section V and equation 13. Contrast and spread of one half are round numbers from a plateau.
    presence=AppearanceRule(fraction=0.1, deviations=2.0, margin=0.7, contrast=0.5, spread=0.5),
    calibration=Calibration(middle=0.38, width=0.1, spread=2.5),
)

# A model that learns is nearer to what it sees, right or wrong: a calibration of its own.
ADAPTIVE = replace(
    NUMMIARO,
    adaptation=ExponentialForgetting(learning_rate=0.05, anchor=0.4),  # sections IV and VIII
    presence=replace(NUMMIARO.presence, margin=0.75, contrast=0.0, spread=0.0),
    calibration=Calibration(middle=0.31, width=0.09),
)

MEAN_SHIFT = MeanShift(  # section VI
    color=Color(space="rgb", bins=(8, 8, 8), kernel="epanechnikov", sampling=EveryPixel())
)

# Maggio et al. give neither sigma, nor the share of pixels above T, nor the filters' scale. Not the
# paper's: the lattice, the appearance rule with its limits, and the fusion, a product with the
# fixed weights that the paper compares its own with. No adaptive rule was better on film
# (lab/docs/papers.md); maggio:printed has the paper's, a sum, and none of the others.
MAGGIO = ParticleFilter(
    particles=150,  # section 5
    motion=EllipseWalk(position=5.5, size=0.05, eccentricity=0.021, angle=math.radians(10)),  # 5
    color=Color(space="rgb", bins=(10, 10, 10), kernel="epanechnikov"),  # sections 3.1 and 5
    orientation=Orientation(  # sections 3.2 and 5
        bins=36, form="rotated", scale_selection=True, kept_fraction=0.5
    ),
    fusion=Fixed(weights={"color": 0.66, "orientation": 0.34}),  # section 5
    likelihood=Gaussian(sigma=0.15),  # equation 6
    resampling=Multinomial(threshold=1.0),  # section 4.1
    presence=AppearanceRule(margin=0.7, contrast=0.6, spread=0.5),
    calibration=Calibration(middle=0.32, width=0.09, spread=1.5),
)
# Ng and Delp give neither motion, nor number of particles, nor bins of edges, and do not say how
# color and edges become one. The motion is nummiaro's; 150 particles are those of the other filter
# of two cues. Epsilon is 0.1 in their figure 3, "small but non-zero" in the text: with 0.1, the
# many bad particles outweigh the good ones; 150 times 0.001 is less than the best one's exp(-1).
# Not the paper's: the appearance rule with its margin, and lattices, which read fewer pixels still:
# as few points as cost no accuracy.
NG_DELP = ParticleFilter(
    particles=150,
    motion=NUMMIARO.motion,
    color=Color(  # sections 3.1 and 3.3
        space="hsv", bins=(8, 8, 4), kernel="epanechnikov", sampling=Lattice(points=192)
    ),
    edges=Edges(  # section 3.2, equation 14
        threshold=100.0, bins=8, kernel="epanechnikov", sampling=Lattice(points=128)
    ),
    fusion=Fixed(),
    likelihood=BestParticle(epsilon=0.001),  # equations 23 and 24
    resampling=Multinomial(threshold=1.0),
    presence=AppearanceRule(margin=0.7),
    calibration=Calibration(middle=0.55, width=0.17),  # particles that appear have little weight
)


def _reading(config: ParticleFilter, sampling: Sampling) -> ParticleFilter:
    """Return a filter whose cues read other pixels."""
    cues: dict[str, Any] = dict(config.cues)
    return replace(config, **{name: replace(cue, sampling=sampling) for name, cue in cues.items()})


def _alone(config: ParticleFilter, cue: str, *fit: float) -> ParticleFilter:
    """Return a filter with one of its cues, and that cue's calibration."""
    changes: dict[str, Any] = dict.fromkeys(config.cues.keys() - {cue})
    return replace(config, **changes, fusion=Fixed(), calibration=Calibration(*fit))


# Zhao and Pei give neither A nor the noise of their motion, nor lambda, nor L; for the kernel of
# their color histogram they cite Nummiaro et al. Nor do they say how color and HOG become one;
# multiplied, their distances are added up in the exponent. Not the paper's: the appearance rule
# with its limits, without which no model learns, the lattice, and the model update: the paper's
# learns the background as soon as it is tracked (lab/docs/results.md).
ZHAO_PEI = ParticleFilter(
    particles=400,  # section 4
    motion=Autoregressive(  # equation 17
        position=0.6, size=0.02, persistence=0.5, position_return=0.0, size_return=0.1
    ),
    color=Color(space="hsv+v", bins=(8, 8, 8), kernel="radial"),  # sections 2.1 and 3.1
    hog=Hog(cells=1, bins=8, kernel="gaussian"),  # equations 1 and 2, section 4
    fusion=Fixed(),
    likelihood=Exponential(rate=20.0),  # section 2.3
    resampling=Multinomial(threshold=1.0),  # section 2.3
    presence=AppearanceRule(margin=0.7, contrast=0.5, spread=0.5),
    calibration=Calibration(middle=0.2, width=0.06),
    adaptation=AnchoredKalman(),  # close to equations 3 to 15
)

# The papers to the letter. Values that a paper does not give are those of its preset above.
# Comments name the differences. Misprinted equations are corrected.
ALWAYS_PRESENT = AppearanceRule(max_threshold=0.0)
"""For papers without an appearance rule: the target is always there."""
NUMMIARO_PRINTED = replace(
    _reading(NUMMIARO, EveryPixel()),  # equation 3
    motion=ConstantVelocity(
        # Equation 8: H_x and H_y have a noise of their own, and no factor in common; no value.
        noise=Noise(position=0.6, size=0.0, size_return=0.0, aspect=0.02),
        velocity=0.5,
        persistence=1.0,  # equations 8 and 9: velocities are constant
    ),
    calibration=Calibration(middle=0.34, width=0.08),
    presence=AppearanceRule(
        fraction=0.1,  # section V
        frames=2,  # section V: "a couple of frames"
        found_frames=1,  # section V
        deviations=2.0,  # equation 13; no margin, no contrast, no spread, no ceiling
        max_threshold=1.0,
        in_frame=True,  # not printed: equations 11 and 12 know only centers in the picture
        max_positions=10**9,  # equations 11 and 12: every pixel
    ),
)
MAGGIO_PRINTED = replace(
    _reading(MAGGIO, EveryPixel()),
    fusion=PrintedMixture(),  # equations 7 to 10
    presence=ALWAYS_PRESENT,
    calibration=Calibration(middle=0.42, width=0.1),
)
NG_DELP_PRINTED = replace(
    _reading(NG_DELP, EveryPixel()),  # equations 16 to 19
    likelihood=BestParticle(epsilon=0.1, floor=0.001),  # figure 3; equation 24 has no floor
    presence=ALWAYS_PRESENT,
)
ZHAO_PEI_PRINTED = replace(
    _reading(ZHAO_PEI, EveryPixel()),  # section 3.1, equation 2
    presence=ALWAYS_PRESENT,
    calibration=Calibration(middle=0.14, width=0.15),  # a model that learns fast is always near
    adaptation=PerCue(
        cues={
            "color": KalmanBins(frames=10, alpha=0.1),  # equations 3 to 15; section 2.2
            "hog": GaussianBins(beta=0.1, deviations=3.0),  # equation 16
        }
    ),
)

KNOWN: dict[str, tuple[str, TrackerConfig]] = {
    "default": (
        "Correlation filters, a color posterior and particles that search a lost target.",
        Discriminative(),
    ),
    "nummiaro": ("Nummiaro et al.: a particle filter with a color histogram.", NUMMIARO),
    "nummiaro:adaptive": ("The same with a target model that is updated.", ADAPTIVE),
    "nummiaro:printed": (
        "As printed: every pixel, constant velocity, equation 13 alone.",
        NUMMIARO_PRINTED,
    ),
    "mean_shift": (
        "Mean shift on a color histogram, the comparison of Nummiaro et al.",
        MEAN_SHIFT,
    ),
    "maggio": ("Maggio et al.: color and edge orientation (ROH), fixed cue weights.", MAGGIO),
    "maggio:printed": (
        "As printed: adaptive cue weights, every pixel, no appearance rule.",
        MAGGIO_PRINTED,
    ),
    "maggio:C": ("Color alone (table 1).", _alone(MAGGIO, "color", 0.33, 0.15, 1.25)),
    "maggio:O-ROH": (
        "Orientation alone, turned with the target (table 1).",
        _alone(MAGGIO, "orientation", 0.19, 0.09, 0.75),
    ),
    "ng_delp": ("Ng and Delp: color and edge histograms, on a part of the pixels.", NG_DELP),
    "ng_delp:color": ("Color alone.", _alone(NG_DELP, "color", 0.64, 0.2)),
    "ng_delp:edges": ("Edges alone.", _alone(NG_DELP, "edges", 0.0, 0.18)),
    "ng_delp:printed": ("As printed: every pixel, epsilon 0.1, never lost.", NG_DELP_PRINTED),
    "zhao_pei": (
        "Zhao and Pei: color and HOG, target models updated bin by bin, with a gate.",
        ZHAO_PEI,
    ),
    "zhao_pei:printed": (
        "As printed: the updates of equations 3 to 16, every pixel, never lost.",
        ZHAO_PEI_PRINTED,
    ),
}
"""The presets by name, with one line on each."""
PRESETS = {name: config for name, (_, config) in KNOWN.items()}
DESCRIPTIONS = {name: about for name, (about, _) in KNOWN.items()}


def preset(name: str) -> TrackerConfig:
    """Return a preset's configuration.

    Raises
    ------
    ConfigError
        For an unknown name, with the nearest known one.
    """
    if name in PRESETS:
        return PRESETS[name]
    near = difflib.get_close_matches(str(name), PRESETS, n=1)
    hint = f"did you mean {near[0]!r}? " if near else ""
    raise ConfigError(f"No preset {name!r}; {hint}known are {', '.join(PRESETS)}.")


def check_cues(values: Mapping[str, Any]) -> None:
    """Raise a ConfigError if an algorithm with fixed cues is given another cue."""
    algorithm = values.get("type")
    if not isinstance(algorithm, str) or algorithm not in TRACKERS:
        return
    kind: Any = TRACKERS.resolve(algorithm)
    if open_registry(kind)[1] is CUES:
        return
    for name in values:
        if name not in ("type", *kind.__struct_fields__) and name in CUES:
            raise ConfigError(
                f"Algorithm {algorithm!r} takes no cue {name!r}, as its cues are fixed; choose a "
                f"particle filter, such as preset nummiaro."
            )


def configure(base: TrackerConfig | str, *changes: dict[str, Any]) -> TrackerConfig:
    """Return a configuration with changes laid over it, from plain nested values (TOML, flags).

    The base is a configuration, or the name of a preset.

    Raises
    ------
    ConfigError
        For an unknown name or key, or a value that does not fit.
    """
    base = preset(base) if isinstance(base, str) else base
    if not isinstance(base, Algorithm) or not all(isinstance(each, dict) for each in changes):
        raise ConfigError(
            "Give a preset's name or a configuration, then changes, as in configure('nummiaro', "
            "{'particles': 200})."
        )
    values = base.to_dict()
    for change in changes:
        values = merge(values, change)
    check_cues(values)
    if values.get("type") == tag_of(type(base)):
        for name in (each for each in values if each not in ("type", *base.__struct_fields__)):
            for other, each in PRESETS.items():
                if name in each.__struct_fields__:
                    raise ConfigError(f"Config has no key {name!r}; preset {other} has it.")
    config: TrackerConfig = from_dict(values, Algorithm)
    return config
