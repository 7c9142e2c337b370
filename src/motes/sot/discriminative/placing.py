"""Where the target is in a frame: at the predicted place or a rival, turned, or found again."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.types import Floats
from motes.sot.discriminative.config import DiscriminativeConfig
from motes.sot.discriminative.localization import WindowEstimate, localize
from motes.sot.discriminative.prediction import Prediction, Transition
from motes.sot.discriminative.rival import APART, DECIDED, Rival, apart
from motes.sot.discriminative.state import DiscriminativeState

TURN = 0.25
"""Angle of the turned windows to either side, in radians."""
TURN_GAIN = 0.3
"""A turned window must have so much more evidence; otherwise noise would turn the target."""
NO_PARTICLES = np.empty((0, 5))
"""The particles where nothing is searched for, or the user has placed the target."""


class Found(NamedTuple):
    """Where the target is in a frame, before its size is known."""

    estimate: WindowEstimate
    """The estimate of the place."""
    rival: Rival
    """Another place that may be the target's."""
    jumped: bool = False
    """Whether the search has found this place."""
    searchers: Floats = NO_PARTICLES
    """(N, 5) the particles of the search."""


def find(
    config: DiscriminativeConfig,
    rng: np.random.Generator,
    state: DiscriminativeState,
    frame: Frame,
    expected: Prediction,
) -> Found:
    """Return the target's place near the predicted one, or where another expert sees it.

    A far prediction may be wrong: unless the place there is decided, the last one is looked at as
    well. A missed target may be anywhere near.
    """
    last, shift = state.ellipse, expected.likeliest(state.motion)
    predicted = moved(last, shift, frame)
    transition = None if state.standing.missed else state.motion.transition(predicted)
    experts = config.experts
    sights = experts.look(state.experts, frame, predicted)
    sigma = math.inf if transition is None else transition.sigma
    estimate = localize(config, rng, state, frame, predicted, sights, sigma)
    if math.hypot(*shift.tolist()) > APART * last.side and estimate.evidence < DECIDED:
        there = localize(config, rng, state, frame, last, sights)
        estimate = max(estimate, there, key=lambda each: each.evidence)
    proposals = experts.proposals(sights)
    return _compare(config, rng, state, frame, estimate, shift, proposals, transition)


def _compare(
    config: DiscriminativeConfig,
    rng: np.random.Generator,
    state: DiscriminativeState,
    frame: Frame,
    estimate: WindowEstimate,
    shift: Floats,
    proposals: list[Ellipse],
    transition: Transition | None,
) -> Found:
    """Return a window's place, or its rival's, if that has more evidence so far.

    The rival is followed from frame to frame. Without one, it is the proposal with the most
    evidence that is elsewhere. It begins with the log odds of such a leap, if the target may
    as well be where it was expected. It wins only where the target is not: as long as what is
    followed looks like the target, another place that does is a neighbor's. The histograms of the
    first region have to agree, too, as about what the search finds.
    """
    rival = state.rival
    if rival.alive:
        place = moved(rival.place, shift, frame)
        other = localize(config, rng, state, frame, place, estimate.sights)
        rival = rival if apart(other.pose, estimate.pose) else Rival(estimate.pose)
    if not rival.alive:
        places = [
            moved(estimate.pose, np.subtract(seen[:2], estimate.pose[:2]), frame)
            for seen in proposals
        ]
        others = [
            localize(config, rng, state, frame, place, estimate.sights)
            for place in places
            if apart(place, estimate.pose)
        ]
        others = [other for other in others if apart(other.pose, estimate.pose)]
        if not others:
            return Found(estimate, Rival(estimate.pose))
        other = max(others, key=lambda other: other.evidence)
        if transition is not None and estimate.evidence > 0:
            leap = transition.log_density(np.array(other.pose[:2]))
            rival = rival._replace(lead=max(float(leap), -DECIDED))
    rival = rival.after(other.pose, other.evidence - estimate.evidence)
    if rival.wins and estimate.evidence <= 0:
        there, here = (
            config.redetection.log_odds(state.appearance, frame, each.pose)
            for each in (other, estimate)
        )
        if rival.after(other.pose, there - here).wins:
            return Found(other, Rival(other.pose))
    return Found(estimate, Rival(estimate.pose) if rival.loses else rival)


def evidence_at(
    config: DiscriminativeConfig,
    rng: np.random.Generator,
    state: DiscriminativeState,
    frame: Frame,
    place: Ellipse,
) -> float:
    """Return the evidence that the target is at the center of a place."""
    there = state.ellipse._replace(x=place.x, y=place.y)
    sights = config.experts.look(state.experts, frame, there)
    return localize(config, rng, state, frame, there, sights).evidence


def turned(
    config: DiscriminativeConfig,
    rng: np.random.Generator,
    state: DiscriminativeState,
    frame: Frame,
    estimate: WindowEstimate,
) -> WindowEstimate:
    """Return the estimate, or one with more evidence of a window turned to either side, or back.

    A target that is not seen there either is not turned: noise would turn it on and on. Back to
    the angle of the first region, any gain is enough.
    """

    def at(theta: float) -> WindowEstimate:
        window = estimate.pose._replace(theta=theta)
        return localize(config, rng, state, frame, window, estimate.sights)

    theta = estimate.pose.theta
    best = max(at(theta - TURN), at(theta + TURN), key=lambda each: each.evidence)
    if best.evidence > max(estimate.evidence + TURN_GAIN, 0):
        estimate = best
    if abs(estimate.pose.theta) > TURN:
        estimate = max(estimate, at(0.0), key=lambda each: each.evidence)
    return estimate


def search(
    config: DiscriminativeConfig,
    rng: np.random.Generator,
    state: DiscriminativeState,
    frame: Frame,
    found: Found,
) -> Found:
    """Return the target's place, or another one that the search finds and that is decided.

    The search has had more than one chance to be wrong. What it finds is not followed from the
    frame before, so the histograms of the first region have a voice, too: a red car is not a black
    one of the same shape.
    """
    searchers, last = state.search_particles, state.ellipse
    if not len(searchers):
        searchers = np.tile(np.array(last), (config.particles, 1))
    searchers, places = config.redetection.step(
        rng, state.appearance, searchers, frame, last, state.standing.missed + 1
    )

    def judged(place: Ellipse) -> WindowEstimate:
        estimate = localize(config, rng, state, frame, place, found.estimate.sights)
        likeness = config.redetection.log_odds(state.appearance, frame, estimate.pose)
        return replace(estimate, evidence=estimate.evidence + likeness)

    # One after the other: an estimate has a megabyte of windows and transforms.
    best = max(map(judged, places), key=lambda each: each.evidence)
    if best.evidence > DECIDED:
        return Found(best, Rival(best.pose), True, searchers)
    return found._replace(searchers=searchers)


def moved(place: Ellipse, shift: Floats, frame: Frame) -> Ellipse:
    """Return a place moved by a shift (2,) in pixels, its center inside the frame."""
    x, y = (place[:2] + shift).tolist()
    right, low = float(frame.width - 1), float(frame.height - 1)
    return place._replace(x=min(max(x, 0.0), right), y=min(max(y, 0.0), low))
