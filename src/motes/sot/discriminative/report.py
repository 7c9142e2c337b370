"""The report of a step of the default tracker, in the form of the first region.

The tracker itself follows a box that turns in steps. What is reported is the region that the user
gave, moved, with a smooth size and a smooth turn.
"""

from __future__ import annotations

import math

import numpy as np
from msgspec.structs import replace

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.sot.algorithm import StepInfo
from motes.sot.discriminative.config import DiscriminativeConfig
from motes.sot.discriminative.expert import LARGEST_LOG_ODDS, probability
from motes.sot.discriminative.localization import WindowEstimate, color_weight
from motes.sot.discriminative.placing import NO_PARTICLES
from motes.sot.discriminative.rival import APART
from motes.sot.discriminative.size import Trend
from motes.sot.discriminative.state import DiscriminativeState
from motes.sot.filtering.resampling import Weights, mean_ellipse

DRIFT_SIGMA = APART / 2
"""Standard deviation of a center, as a share of the mean side, that the particles do not show: the
learned filter may have drifted from the center of the target, but hardly to another place."""


def report(
    config: DiscriminativeConfig,
    state: DiscriminativeState,
    frame: Frame,
    estimate: WindowEstimate | None = None,
    ellipses: Floats = NO_PARTICLES,
) -> StepInfo:
    """Return the report of an estimate, in the form of the first region.

    Its confidence is that the target is there, and is it. While a lost target is searched for, the
    particles are those of the search. The state is that after the frame; the weights of the
    particles (N, 5) are those of the estimate. Without an estimate the user has placed the target,
    which has no particles then: the track has the covariance and the effective sample size of
    particles that all lie there.
    """
    evidence, similarity, weights = LARGEST_LOG_ODDS, 1.0, None
    if estimate is not None:
        evidence, similarity, weights = estimate.evidence, estimate.similarity, estimate.weights
        if not state.standing.trusted and len(state.search_particles):
            ellipses, weights = state.search_particles, None
    count = len(ellipses)
    if not count:
        ellipses = np.tile(np.array(state.ellipse), (config.particles, 1))
    weights = weights or Weights.uniform(len(ellipses))
    grown = math.exp(state.size.value)
    size = grown * ellipses[:, 2:4] / np.array(state.ellipse[2:4])
    shaped = np.empty((len(ellipses), 5))
    shaped[:] = state.shape
    shaped[:, :2] = ellipses[:, :2]
    shaped[:, 2:4] *= size
    turn = state.turn.angle.value
    shaped[:, 4] += ellipses[:, 4] + (turn - state.ellipse.theta)
    found = reported_ellipse(state.shape, state.ellipse, state.size, turn)
    covariance = mean_ellipse(shaped, weights.values)[1]
    if count:
        drift = (DRIFT_SIGMA * state.ellipse.side) ** 2
        covariance[0, 0] += drift
        covariance[1, 1] += drift
    track = Track(
        frame=frame.index,
        time=frame.time,
        ellipse=found,
        covariance=covariance,
        confidence=probability(evidence) * state.belief.probability,
        status=state.reported.status,
        distance=1 - min(max(similarity, 0.0), 1.0),
        effective_sample_size=weights.effective_sample_size,
        belief=state.belief.probability,
    )
    share = color_weight(state.contrast)
    return StepInfo(
        track,
        shaped[:count],
        weights.values[:count],
        None,
        {"correlation": state.correlation, "posterior": state.posterior},
        {"correlation": 1 - share, "posterior": share},
    )


def at_region(info: StepInfo, region: Ellipse, confidence: float, status: Status) -> StepInfo:
    """Return a report of another region, with the particles moved there."""
    track = info.track
    ellipses = info.ellipses.copy()
    ellipses[:, :2] += np.subtract(region[:2], track.ellipse[:2])
    ellipses[:, 2:4] *= np.divide(region[2:4], track.ellipse[2:4])
    ellipses[:, 4] += region.theta - track.ellipse.theta
    joined = replace(track, ellipse=region, confidence=confidence, status=status)
    return replace(info, track=joined, ellipses=ellipses)


def particles_of(estimate: WindowEstimate, state: DiscriminativeState, found: Ellipse) -> Floats:
    """Return the particles (N, 5) of place and size.

    The N particles of the place are those of `estimate`; the M of the size are repeated. The size
    that is found is the most likely one; the particles show its uncertainty.
    """
    factors = state.factors[np.arange(len(estimate.centers)) % len(state.factors)]
    ellipses = np.empty((len(factors), 5))
    ellipses[:] = found
    ellipses[:, :2] = estimate.centers
    ellipses[:, 2:4] *= (factors / (estimate.weights.values @ factors))[:, None]
    return ellipses


def reported_size(
    state: DiscriminativeState, found: Ellipse, *, sized: bool, learned: bool, jumped: bool
) -> Trend:
    """Return the size to report: smooth, but for a target that was found elsewhere.

    It is told whether the size was estimated, whether the models learned from this frame, and
    whether the search has found this place; `state` is that before the frame.
    """
    first = Ellipse.from_box(state.shape.box).a
    if jumped:
        return Trend(math.log(found.a / first), rough=True)
    if not learned:
        return state.size._replace(growth=0.0)
    if not sized:
        return state.size.predicted()
    return state.size.measured(math.log(found.a / first))


def reported_ellipse(shape: Ellipse, place: Ellipse, size: Trend, turn: float) -> Ellipse:
    """Return the first region `shape` at a place, in a size and turned by `turn` radians."""
    grown = math.exp(size.value)
    return Ellipse(place.x, place.y, shape.a * grown, shape.b * grown, shape.theta + turn)
