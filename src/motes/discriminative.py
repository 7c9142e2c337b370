"""The default tracker: particles over cues that learn the target against its surroundings.

A step is a particle filter in parts (MacCormick and Isard, ECCV 2000): first where, then how large,
then where exactly. Particles look their likelihood up in dense results: the response of a
correlation filter, and sums of the pixels' color posterior. The first frame's filter is kept, and
how much the place found is like it and stands out in color says how sure the tracker is; it learns
only while it is sure, and searches when it is not.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import msgspec
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from motes.config import Config, Count, NonNegative, Positive, Share
from motes.cues.correlation import Correlation, CorrelationModel, Spectra, at
from motes.cues.posterior import CORE, Posterior, PosteriorModel, borders, means
from motes.cues.sizes import SizeModel, Sizes
from motes.cues.window import Singles
from motes.estimate import mean_ellipse
from motes.frame import Frame
from motes.geometry import Ellipse
from motes.particle_filter import Info
from motes.presence import Calibration
from motes.resampling import Resampling, Weights
from motes.track import Status, Track

Floats = NDArray[np.float64]

SURROUNDINGS = 1.4
"""The contrast is that to the part between the box and one so many times as large."""
CALM = 10
"""Frames from the start whose mean certainty is the reference."""
STEADY = 0.05
"""Share of a frame in the running means of contrast and borders."""
SMALLEST = 2.0
"""Half-axis in pixels."""
UNSEEN = 0.2
"""Standard deviation of a center, as a share of the mean side, that no particle shows: the filter
answers for what it has learned, which may have drifted from the target's middle."""
FRESH = 4
"""Of so many searchers one starts anew in each frame, anywhere."""


class Trust(Config, frozen=True):
    """How certain the tracker must be, from 0 to 1; see `Discriminative.certainty`.

    Each holds for targets that are easily told from everything else; others ask for the share
    `of_first` of the certainty that they had in the first frames.

    Attributes
    ----------
    learn
        To learn from a frame.
    keep
        Not to call the target lost.
    find
        To call a lost one found.
    frames
        A target is lost after so many frames in a row that are not certain enough to keep it.
    of_first
        See above.
    """

    learn: Share = 0.3
    keep: Share = 0.2
    find: Share = 0.25
    frames: Count = 3
    of_first: Share = 0.6


class DiscriminativeState(msgspec.Struct, frozen=True, eq=False):
    """What the next step needs.

    Attributes
    ----------
    time
        Of the last frame, in seconds.
    ellipse
        The last estimate: the box as an upright ellipse.
    shape
        The first region; what is reported is this, moved and scaled.
    correlation, posterior, sizes
        The models.
    contrast
        Running mean of the color contrast while learning; it sets how much color counts.
    border
        (2,) running mean of the posterior just inside and outside of the target's border.
    reference, seen
        Mean certainty of the first frames, and of how many.
    searchers
        (N, 2) centers of the particles that search, while the target is lost.
    status, missed
        Where the tracker is, and for how many frames in a row it was not certain.
    """

    time: float
    ellipse: Ellipse
    shape: Ellipse
    correlation: CorrelationModel
    posterior: PosteriorModel
    sizes: SizeModel
    contrast: float
    border: Floats
    reference: float
    seen: int
    searchers: Floats
    status: Status
    missed: int


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """What one window says.

    Attributes
    ----------
    place
        The window is around this ellipse.
    spectra, plane, integral
        Of its features; the filter's response; the posterior's sums.
    centers, weights
        (N, 2), (N,) the particles.
    found
        Their mean, with the size of `place`.
    score
        What the cues, pooled, say of it.
    """

    place: Ellipse
    spectra: Spectra
    plane: Singles
    integral: Floats
    centers: Floats
    weights: Weights
    found: Ellipse
    score: float


class Discriminative(Config, frozen=True, dict=True, tag="discriminative"):
    """The default tracker.

    Attributes
    ----------
    particles
        How many: N.
    correlation, posterior, sizes
        The cues for the place, and the one for the size.
    color_gain
        How much the color contrast counts in the pool of the cues for the place.
    border_gain
        How much the posterior across the border counts, beside the sizes' filter, for the size.
    sigma
        Of the pooled cues: particles weigh exp(pool / sigma).
    rate
        Share of a frame in what is learned.
    trust
        How certain it must be to learn, and not to be lost.
    calibration
        From 1 - certainty to the confidence.
    resampling
        How particles are selected.
    """

    particles: Count = 400
    correlation: Correlation = Correlation()
    posterior: Posterior = Posterior()
    sizes: Sizes = Sizes()
    color_gain: NonNegative = 1.0
    border_gain: NonNegative = 0.2
    sigma: Positive = 0.02
    rate: Share = 0.02
    trust: Trust = Trust()
    calibration: Calibration = Calibration(middle=0.73, width=0.05)
    resampling: Resampling = Resampling(scheme="systematic", threshold=1.0)

    @cached_property
    def cues(self) -> dict[str, Correlation | Posterior]:
        """The cues for the place, by name."""
        return {"correlation": self.correlation, "posterior": self.posterior}

    def init(
        self, rng: np.random.Generator, frame: Frame, region: Ellipse
    ) -> tuple[DiscriminativeState, Info]:
        """Learn the target in the box around `region` and start tracking it."""
        box = Ellipse.from_box(region.box)
        correlation = self.correlation.learn(frame, box)
        posterior = self.posterior.learn(frame, box)
        integral = self.posterior.integral(posterior, frame, box)
        state = DiscriminativeState(
            time=frame.time,
            ellipse=box,
            shape=region,
            correlation=correlation,
            posterior=posterior,
            sizes=self.sizes.learn(frame, box),
            contrast=contrast(integral, posterior, box, box),
            border=borders(integral, posterior.grid, box, np.array([box]))[0],
            reference=0.0,
            seen=0,
            searchers=np.tile(np.array(box[:2]), (self.particles, 1)),
            status=Status.TRACKING,
            missed=0,
        )
        return state, self._put(state, frame)

    def step(
        self, rng: np.random.Generator, state: DiscriminativeState, frame: Frame
    ) -> tuple[DiscriminativeState, Info]:
        """Look where the target was, or may be: find its place, its size, and look again there."""
        if state.status is not Status.TRACKING:
            state, places = self._search(rng, state, frame)
            looks = [self._look(rng, state, frame, place) for place in places]
            place = max(looks, key=lambda look: look.score).found
            after, info, _ = self._observe(rng, state, frame, place, np.array([place]))
            return after, info
        found = self._look(rng, state, frame, state.ellipse)
        place, sized = self._sized(rng, state, frame, found)
        after, info, learned = self._observe(rng, state, frame, place, sized)
        if learned:
            after = replace(
                after, sizes=self.sizes.taught(state.sizes, frame, after.ellipse, self.rate)
            )
        return after, info

    def correct(
        self, state: DiscriminativeState, frame: Frame, region: Ellipse
    ) -> tuple[DiscriminativeState, Info]:
        """Put the target at `region` of the current frame; what was learned is kept."""
        state = replace(
            state,
            ellipse=Ellipse.from_box(region.box),
            shape=region,
            searchers=np.tile(np.array(region[:2]), (self.particles, 1)),
            status=Status.TRACKING,
            missed=0,
        )
        return state, self._put(state, frame)

    def certainty(self, state: DiscriminativeState, look: Look, found: Ellipse) -> float:
        """Return the geometric mean of response to the first frame's filter and color contrast.

        Both are 0 to 1, and neither is learned into agreement with what the tracker follows: a
        response relative to its own past says nothing, since it rises while the filter learns
        the wrong thing.
        """
        first = self.correlation.first(state.correlation, look.spectra)
        stands_out = contrast(look.integral, state.posterior, look.place, found)
        return math.sqrt(min(max(first, 0.0), 1.0) * max(stands_out, 0.0))

    def _look(
        self, rng: np.random.Generator, state: DiscriminativeState, frame: Frame, place: Ellipse
    ) -> Look:
        """Weigh particles by what the window around a place says, and take their mean.

        Half of them are spread over the window, the others around the response's maximum; they
        are weighed, selected, and weighed again nearby, which sharpens them step by step.
        """
        samples = state.correlation.grid
        spectra = self.correlation.spectra(samples, frame, place)
        plane = self.correlation.response(state.correlation, spectra)
        integral = self.posterior.integral(state.posterior, frame, place)
        share = self._color_share(state)

        ellipses = np.tile(np.array(place), (self.particles, 1))

        def pool(ellipses: Floats) -> Floats:
            response = at(plane, samples, place, ellipses)
            color = means(integral, samples, place, ellipses, CORE)
            return (1 - share) * response + share * color

        row, column = divmod(int(np.argmax(plane)), plane.shape[1])
        peak = np.array([column - plane.shape[1] // 2, row - plane.shape[0] // 2])
        narrow = self.correlation.sharpness * 2 * math.sqrt(place.a * place.b)
        noise = rng.standard_normal((3, self.particles, 2))
        ellipses[::2, :2] += noise[0, ::2] * place[2:4]
        ellipses[1::2, :2] += noise[0, 1::2] * narrow + peak * samples.step(place)
        for layer, spread in ((1, narrow / 2), (2, narrow / 4)):
            weights = Weights.from_log(pool(ellipses) / self.sigma)
            ellipses = ellipses[self.resampling.ancestors(rng, weights, self.particles)]
            ellipses[:, :2] += noise[layer] * spread
        ellipses[:, :2] = np.clip(ellipses[:, :2], 0, [frame.width - 1, frame.height - 1])
        weights = Weights.from_log(pool(ellipses) / self.sigma)
        x, y = (weights.values @ ellipses[:, :2]).tolist()
        found = place._replace(x=x, y=y)
        score = float(pool(np.array([found]))[0])
        return Look(place, spectra, plane, integral, ellipses[:, :2], weights, found, score)

    def _sized(
        self, rng: np.random.Generator, state: DiscriminativeState, frame: Frame, look: Look
    ) -> tuple[Ellipse, Floats]:
        """Return the target with its likeliest size, and particles (N, 5) of it.

        Each size is weighed by the sizes' filter, and by how well the posterior just inside and
        outside of its border is what it was. The likeliest one is taken, not the mean: what is
        nearer to the last size than half a step is no change, so that noise does not add up.
        """
        model, sizes, last = state.sizes, self.sizes, np.array(look.found)
        ellipses = np.tile(last, (sizes.count, 1))
        least = min(1.0, SMALLEST / last[2:4].min())
        most = max(1.0, (np.array([frame.width, frame.height]) / 2 / last[2:4]).min())
        ellipses[:, 2:4] *= np.clip(sizes.factors, least, most)[:, None]
        pool = sizes.response(model, frame, look.found).astype(np.float64)
        errors = borders(look.integral, state.posterior.grid, look.place, ellipses) - state.border
        pool += self.border_gain * np.exp(-50 * (errors**2).sum(axis=1))
        weights = Weights.from_log(pool / self.sigma)
        chosen = self.resampling.ancestors(rng, weights, self.particles)
        return Ellipse(*ellipses[int(np.argmax(pool))].tolist()), ellipses[chosen]

    def _search(
        self, rng: np.random.Generator, state: DiscriminativeState, frame: Frame
    ) -> tuple[DiscriminativeState, list[Ellipse]]:
        """Return where the target may be: where it was lost, and the searcher of likeliest color.

        Searchers walk at random by half of the target's size in a frame, some start anew anywhere,
        and they are selected by the posterior of the colors around them.
        """
        size = state.ellipse
        walk = rng.standard_normal(state.searchers.shape) * size[2:4]
        ends = [frame.width - 1, frame.height - 1]
        centers = np.clip(state.searchers + walk, 0, ends)
        centers[::FRESH] = rng.random((len(centers[::FRESH]), 2)) * ends
        likely = self.posterior.search(state.posterior, frame, centers, size)
        weights = Weights.from_log(likely / 0.125)
        x, y = centers[int(np.argmax(likely))].tolist()
        chosen = self.resampling.ancestors(rng, weights, len(centers))
        state = replace(state, searchers=centers[chosen])
        return state, [_inside(size, frame), size._replace(x=x, y=y)]

    def _observe(
        self,
        rng: np.random.Generator,
        state: DiscriminativeState,
        frame: Frame,
        place: Ellipse,
        sized: Floats,
    ) -> tuple[DiscriminativeState, Info, bool]:
        """Look around a place, judge and learn; `sized` are particles of its size."""
        look = self._look(rng, state, frame, place)
        certainty = self.certainty(state, look, look.found)
        tracking = state.status is Status.TRACKING
        seen, reference = state.seen, state.reference
        if tracking and seen < CALM:
            seen, reference = seen + 1, (reference * seen + certainty) / (seen + 1)
        trust = self.trust
        easy = trust.of_first * reference
        there = certainty >= min(trust.keep if tracking else trust.find, easy)
        missed = 0 if there else state.missed + 1
        if there or (tracking and missed < trust.frames):
            status = Status.TRACKING
        else:
            status = Status.LOST if tracking else Status.SEARCHING
        learned = there and certainty >= min(trust.learn, easy)
        found = look.found if there or tracking else state.ellipse
        if not learned:  # a size seen by one who is not sure is none
            found = found._replace(a=state.ellipse.a, b=state.ellipse.b)
        after = replace(
            state,
            time=frame.time,
            ellipse=found,
            reference=reference,
            seen=seen,
            status=status,
            missed=missed,
            searchers=np.tile(found[:2], (self.particles, 1)) if tracking else state.searchers,
        )
        if learned:
            after = self._learned(after, frame, look)
        if there or tracking:
            ellipses = np.resize(sized, (self.particles, 5))
            ellipses[:, :2], weights = look.centers, look.weights
            # The size is the likeliest one; the particles say how sure that is.
            ellipses[:, 2:4] *= np.array(found[2:4]) / (weights.values @ ellipses[:, 2:4])
        else:
            ellipses = np.tile(np.array(found), (self.particles, 1))
            ellipses[:, :2], weights = state.searchers, Weights.uniform(self.particles)
        return after, self._told(after, frame, ellipses, weights, certainty), learned

    def _put(self, state: DiscriminativeState, frame: Frame) -> Info:
        """Return what there is to say of a target that somebody else has found."""
        ellipses = np.tile(np.array(state.ellipse), (self.particles, 1))
        return self._told(state, frame, ellipses, Weights.uniform(self.particles), 1.0)

    def _told(
        self,
        state: DiscriminativeState,
        frame: Frame,
        ellipses: Floats,
        weights: Weights,
        certainty: float,
    ) -> Info:
        """Return the estimate in the form of the first region, and the particles."""
        size = ellipses[:, 2:4] / np.array(Ellipse.from_box(state.shape.box)[2:4])
        shaped = np.tile(np.array(state.shape), (self.particles, 1))
        shaped[:, :2] = ellipses[:, :2]
        shaped[:, 2:4] *= size
        grown = state.ellipse.a / Ellipse.from_box(state.shape.box).a
        found = state.shape._replace(
            x=state.ellipse.x,
            y=state.ellipse.y,
            a=state.shape.a * grown,
            b=state.shape.b * grown,
        )
        covariance = mean_ellipse(shaped, weights.values)[1]
        if certainty < 1:
            side = 2 * math.sqrt(state.ellipse.a * state.ellipse.b)
            covariance[[0, 1], [0, 1]] += (UNSEEN * side) ** 2
        track = Track(
            frame=frame.index,
            time=frame.time,
            ellipse=found,
            covariance=covariance,
            confidence=self.calibration.probability(1 - certainty),
            status=state.status,
            distance=1 - certainty,
            effective_sample_size=weights.effective_sample_size,
        )
        share = self._color_share(state)
        return Info(
            track,
            shaped,
            weights.values,
            np.full(len(shaped), 1 - certainty),
            len(shaped) if state.missed == 0 else 0,
            {"correlation": state.correlation, "posterior": state.posterior},
            {"correlation": 1 - share, "posterior": share},
        )

    def _learned(self, state: DiscriminativeState, frame: Frame, look: Look) -> DiscriminativeState:
        """Return the state after a frame of which the tracker is certain."""
        grid = state.correlation.grid
        step_x, step_y = grid.step(look.place)
        x, y = (look.found.x - look.place.x) / step_x, (look.found.y - look.place.y) / step_y
        now = contrast(look.integral, state.posterior, look.place, look.found)
        border = borders(look.integral, grid, look.place, np.array([look.found]))[0]
        return replace(
            state,
            correlation=self.correlation.taught(state.correlation, look.spectra, self.rate, x, y),
            posterior=self.posterior.taught(state.posterior, frame, look.place, self.rate, x, y),
            contrast=(1 - STEADY) * state.contrast + STEADY * now,
            border=(1 - STEADY) * state.border + STEADY * border,
        )

    def _color_share(self, state: DiscriminativeState) -> float:
        """Return color's share in the pool: more, the more the target stands out by it."""
        counts = self.color_gain * max(state.contrast, 0.0)
        return counts / (1 + counts)


def contrast(integral: Floats, model: PosteriorModel, place: Ellipse, found: Ellipse) -> float:
    """Return by how much the posterior in a target is above that around it, -1 to 1."""
    core, one, wide = (
        float(means(integral, model.grid, place, np.array([found]), scale)[0])
        for scale in (CORE, 1.0, SURROUNDINGS)
    )
    area = SURROUNDINGS**2
    return core - (area * wide - one) / (area - 1)


def _inside(ellipse: Ellipse, frame: Frame) -> Ellipse:
    """Return an ellipse with its center in the frame."""
    x = min(max(ellipse.x, 0.0), frame.width - 1.0)
    y = min(max(ellipse.y, 0.0), frame.height - 1.0)
    return ellipse._replace(x=x, y=y)
