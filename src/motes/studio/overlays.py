"""What a tracker sees in a frame, small enough to be sent while it runs."""

from __future__ import annotations

import numpy as np

from motes.core.geometry import Ellipse
from motes.sot.step_info import StepInfo
from motes.studio.messages import Overlay

PARTICLES = 200
"""Particles of an overlay at most."""
Places = list[tuple[float, float, float, float, float]]


def overlay_of(info: StepInfo) -> Overlay:
    """Return what a tracker sees, for the page."""
    covariance = info.track.covariance
    particles, weights = _heaviest(info)
    x, y, a, b, theta = map(float, Ellipse(*info.track.ellipse))
    return Overlay(
        number=0,
        object=0,
        frame=info.track.frame,
        ellipse=(x, y, a, b, theta),
        covariance=(float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])),
        particles=particles,
        weights=weights,
    )


def _heaviest(info: StepInfo) -> tuple[Places, list[float]]:
    """Return the heaviest particles of a step, and their weights, of which the largest is 1."""
    weights = np.asarray(info.weights, np.float64)
    if not len(weights):
        return [], []
    order = np.argsort(-weights, kind="stable")[:PARTICLES]
    top = max(float(weights[order[0]]), np.finfo(np.float64).tiny)
    particles = np.round(np.asarray(info.ellipses)[order], 2).tolist()
    return [tuple(each) for each in particles], np.round(weights[order] / top, 4).tolist()
