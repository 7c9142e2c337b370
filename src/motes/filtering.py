"""The parts of a particle filter, to build a configuration of your own.

>>> from motes.filtering import AppearanceRule, EllipseWalk, Exponential
>>> tracker = motes.Tracker(
...     motes.ParticleFilter(
...         color=motes.cues.Color(),
...         motion=EllipseWalk(),
...         likelihood=Exponential(rate=20.0),
...         presence=AppearanceRule(margin=0.7),
...     )
... )
"""

from __future__ import annotations

from motes.sot.discriminative.expert import Confined, Evidence, Expert
from motes.sot.discriminative.redetection import Redetection
from motes.sot.filtering.appearance_rule import AppearanceRule, Calibration
from motes.sot.filtering.bin_updates import AnchoredKalman, GaussianBins, KalmanBins
from motes.sot.filtering.fusion import Fixed, Fusion, PrintedMixture
from motes.sot.filtering.likelihood import BestParticle, Exponential, Gaussian, Likelihood
from motes.sot.filtering.model_update import (
    Adaptation,
    ExponentialForgetting,
    PerCue,
    Strategy,
)
from motes.sot.filtering.motion import (
    Autoregressive,
    ConstantVelocity,
    EllipseWalk,
    Motion,
    Noise,
    RandomWalk,
    SecondOrder,
)
from motes.sot.filtering.resampling import KldSampling, Multinomial, Resampling, Systematic, Weights

__all__ = [
    "Adaptation",
    "AnchoredKalman",
    "AppearanceRule",
    "Autoregressive",
    "BestParticle",
    "Calibration",
    "Confined",
    "ConstantVelocity",
    "EllipseWalk",
    "Evidence",
    "Expert",
    "Exponential",
    "ExponentialForgetting",
    "Fixed",
    "Fusion",
    "Gaussian",
    "GaussianBins",
    "KalmanBins",
    "KldSampling",
    "Likelihood",
    "Motion",
    "Multinomial",
    "Noise",
    "PerCue",
    "PrintedMixture",
    "RandomWalk",
    "Redetection",
    "Resampling",
    "SecondOrder",
    "Strategy",
    "Systematic",
    "Weights",
]
