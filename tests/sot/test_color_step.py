"""The compiled step of filters on color alone, against the step part by part."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from motes.core.saved_state import pack
from motes.cues.color import Color
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.likelihood import Exponential, Gaussian
from motes.sot.filtering.motion import EllipseWalk, Noise, RandomWalk, SecondOrder
from motes.sot.filtering.resampling import KldSampling, Multinomial, Systematic
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import ADAPTIVE, NUMMIARO, ZHAO_PEI
from oracles import region, scene

CENTERS = [(40 + 2 * i, 30 + i) for i in range(6)] + [None, None, (58, 42), (60, 43)]
"""The target is hidden for a while, so that it is searched for."""
SMALL = replace(NUMMIARO, particles=20, presence=replace(NUMMIARO.presence, frames=1))


def bits(config: ParticleFilter) -> bytes:
    """Return all that steps give over a film, to the last bit."""
    rng = np.random.default_rng(3)
    state, info = config.init(rng, scene(0, CENTERS[0]), region((40, 30)))
    out = [state, info]
    for index, center in enumerate(CENTERS[1:], 1):
        state, info = config.step(rng, state, scene(index, center))
        out += [state, info]
    return msgspec.msgpack.encode(out, enc_hook=pack) + repr(rng.bit_generator.state).encode()


@pytest.mark.parametrize(
    "config",
    [
        SMALL,
        replace(SMALL, adaptation=ADAPTIVE.adaptation),
        replace(SMALL, motion=RandomWalk(noise=Noise(angle=0.1))),
        replace(SMALL, motion=SecondOrder(noise=Noise(angle=0.1))),
        replace(SMALL, likelihood=Gaussian(sigma=0.05, epsilon=0.01)),
        replace(SMALL, likelihood=Gaussian(sigma=0.001)),
        replace(SMALL, color=Color(space="hsv+v", bins=(4, 4, 4), kernel="gaussian")),
        replace(SMALL, budget=KldSampling(min=10, max=40)),
    ],
    ids=["plain", "learns", "walk", "second order", "likelihood", "narrow", "hsv+v", "budget"],
)
def test_one_call_gives_the_same_as_part_by_part(config: ParticleFilter) -> None:
    assert config.color_step is not None
    parts = replace(config)
    parts.__dict__["color_step"] = None
    assert bits(config) == bits(parts)


class Own(Color, frozen=True):
    """A cue that may do something else."""


@pytest.mark.parametrize(
    "changes",
    [
        {"color": None, "extra_cues": {"own": Own()}},
        {"motion": EllipseWalk()},
        {"likelihood": Exponential()},
        {"resampling": Systematic()},
        {"resampling": Multinomial(threshold=0.5)},
        {"hog": ZHAO_PEI.hog},
        {"presence": AppearanceRule(in_frame=True)},
    ],
)
def test_other_parts_are_called_one_by_one(changes: dict[str, Any]) -> None:
    config = replace(SMALL, **changes)
    assert config.color_step is None
    assert bits(config)
