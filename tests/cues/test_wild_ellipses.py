"""Ellipses that are none: refused where a target is learned, and harmless where particles are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from motes import kernels
from motes.core.errors import ConfigError
from motes.core.geometry import Ellipse
from motes.cues import (
    Color,
    Correlation,
    Edges,
    EveryPixel,
    Hog,
    Orientation,
    Posterior,
    ScaleFilter,
)
from motes.filtering import Confined
from oracles import frame, mosaic, rows

GOOD = Ellipse(30.0, 20.0, 8.0, 6.0, 0.2)
WILD = [
    GOOD._replace(**{field: value})
    for field, values in {
        "x": (np.nan, np.inf, -1e300),
        "a": (np.nan, 0.0, -3.0, 1e300),
        "b": (np.inf, -6.0),
        "theta": (np.nan, np.inf),
    }.items()
    for value in values
]
CUES: Sequence[Any] = (
    Color(sampling=EveryPixel()), Edges(), Hog(), Orientation(), Posterior(), Correlation(),
)  # fmt: skip
PICTURE = frame(mosaic(0, 40, 60))


@pytest.mark.parametrize(
    "cue", [*CUES, ScaleFilter(), Confined()], ids=lambda each: type(each).__name__
)
def test_nothing_is_learned_of_what_is_no_ellipse(cue: Any) -> None:
    for ellipse in WILD:
        with pytest.raises(ConfigError, match="region"):
            cue.learn(PICTURE, ellipse)
    assert cue.learn(PICTURE, GOOD) is not None


@pytest.mark.parametrize("cue", CUES, ids=lambda each: type(each).__name__)
def test_no_particle_is_too_wild_to_be_compared(cue: Any) -> None:
    model = cue.learn(PICTURE, GOOD)
    negative = GOOD._replace(a=-8.0, b=-6.0)  # of which a kernel had room for too few pixels
    found = cue.distances(model, PICTURE, rows(*WILD, negative, GOOD))
    np.testing.assert_array_equal(found[:-1], 1)
    assert found[-1] < 0.7
    for turned in (np.asfortranarray(rows(*WILD, GOOD)), rows(*WILD, GOOD).tolist()):
        assert cue.distances(model, PICTURE, turned)[-1] == found[-1]
    for wrong in (rows(GOOD)[:, :4], rows(GOOD)[0], "ellipses", None):
        with pytest.raises(ConfigError, match=r"an array \(N, 5\)"):
            cue.distances(model, PICTURE, wrong)


@pytest.mark.parametrize(
    ("cue", "other"),
    [
        (Color(), Color(bins=(4, 4, 4))), (Color(bins=(4, 4, 4)), Color()),
        (Edges(), Edges(bins=5)), (Edges(bins=5), Edges()), (Hog(), Hog(cells=3)),
        (Orientation(), Orientation(form="fourier", bins=9)), (Color(), Posterior()),
    ],
)  # fmt: skip
def test_a_model_of_other_bins_is_refused(cue: Any, other: Any) -> None:
    """One of fewer bins had a distance, which meant nothing."""
    model = other.learn(PICTURE, GOOD)
    calls = [cue.learn_also, *([cue.shift] if isinstance(cue, Color) else [])]
    with pytest.raises(ConfigError, match="no histogram of"):
        cue.distances(model, PICTURE, rows(GOOD))
    for call in calls:
        with pytest.raises(ConfigError, match="no histogram of"):
            call(model, PICTURE, GOOD)


# Kernels, by themselves


@pytest.mark.parametrize("wild", [np.nan, np.inf, -np.inf, 1e300, -1e300, 1e19])
def test_a_window_at_any_place_has_the_picture_s_pixels(wild: float) -> None:
    out = np.empty((3, 12, 16), np.float32)
    steps: Sequence[Any] = ((0.5, 0.7), (2.2, 1.5), (wild, 1.0), (-1.3, wild), (0.4, -wild))
    for place in range(5):
        for step in steps:
            ellipse = list(GOOD)
            ellipse[place] = wild
            for theta in (0.0, ellipse[4]):
                target = Ellipse(*ellipse)._replace(theta=theta)
                kernels.search_window.cut_around(PICTURE.pixels, target, step, out)
                assert ((out >= 0) & (out <= 255)).all()
