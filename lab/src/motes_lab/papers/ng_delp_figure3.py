"""Ng and Delp, figure 3: likelihood against distance, and with the sigma of equation 24."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from motes import ParticleFilter, configure
from motes.core import Floats
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.report.tables import Cell, Row, Table, number
from motes_lab.track_figures import charts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STEP, ROW = 0.01, 0.1
"""Step in distance between points of a curve, and between rows of the table."""
SIGMA, EPSILON = 0.15, 0.1
"""Those of the paper's figure, for equations 22 and 23."""
NEAREST = 0.4
"""The distance of the best particle, d_min of equation 24: in the text, a fixed sigma gives all
particles nearly the same likelihood from there on."""


def ng_delp_figure3(*, results: ResultOptions = ResultOptions()) -> int:
    """Ng and Delp, figure 3: likelihood against distance."""
    return results.show("ng-delp-figure3", figure3())


def figure3() -> Experiment:
    """Yield the likelihoods of equations 22 and 23, and that of 24 if no particle is nearer."""
    fixed = {"type": "gaussian", "sigma": SIGMA}
    curves = [
        (name, *_curve(keys, low))
        for name, keys, low in (
            (f"sigma {SIGMA:g} (22)", fixed, 0),
            (f"epsilon {EPSILON:g} (23)", {**fixed, "epsilon": EPSILON}, 0),
            (f"best at {NEAREST:g} (24)", {"epsilon": EPSILON}, NEAREST),
        )
    ]
    rows: list[Row] = []
    for distance in np.arange(0, 1 + ROW / 2, ROW):
        likelihoods = (
            Cell("") if distance < x[0] - 1e-9 else number(float(np.interp(distance, x, y)))
            for _, x, y in curves
        )
        rows.append((number(float(distance), 1), *likelihoods))
    table = Table(
        "Observation likelihood by distance",
        ("distance", *(name for name, *_ in curves)),
        rows,
        note="Equations 23 and 24 with the same epsilon; 24 gives its best particle exp(-1) and "
        "epsilon, wherever that is.",
    )
    yield Result({"": table}, lambda: _draw(curves))


def _curve(keys: Mapping[str, object], nearest: float) -> tuple[Floats, Floats]:
    """Return distances from the nearest one on, and the likelihoods of particles there.

    The keys are those of ng_delp's likelihood that differ.
    """
    config = configure("ng_delp", {"likelihood": keys})
    assert isinstance(config, ParticleFilter)
    distances = np.append(nearest, np.arange(0, 1 + STEP / 2, STEP))
    distances = np.unique(distances[distances >= nearest])
    return distances, np.exp(config.likelihood.log(distances[None]))[0]


def _draw(curves: list[tuple[str, Floats, Floats]]) -> Figure:
    figure = charts.new_figure(3.8)
    axes = figure.add_subplot()
    charts.style_axes(axes, "Observation likelihood", "distance", "likelihood")
    colors = (charts.BLUE, charts.VERMILION, charts.GREEN)
    for (name, x, y), color in zip(curves, colors, strict=True):
        axes.plot(x, y, color=color, linewidth=1.6, label=name)
    axes.set(xlim=(0, 1), ylim=(0, None))
    charts.legend(axes)
    return figure
