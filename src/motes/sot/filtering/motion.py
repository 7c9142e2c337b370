"""How a target moves: p(x_t | x_{t-1}).

A motion model has its own state columns. The rest of the program sees ellipses only. The noise of
positions and sizes is proportional to the target's first region. All noise is given for one
reference interval of 1/25 s; over dt seconds, its standard deviation grows with the square root of
dt. Nummiaro et al., equations 8 and 9 and section VII.

Colors depend little on size: a smaller ellipse inside the target has almost the same histogram. So
the two half-axes mostly grow and shrink together, and return slowly to their first size.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from functools import cached_property
from typing import Annotated

import numpy as np
from msgspec import Meta

from motes import kernels
from motes.core.config import Config, Share
from motes.core.frame import FRAME_INTERVAL
from motes.core.geometry import Ellipse
from motes.core.registry import Registry
from motes.core.types import Floats
from motes.kernels import structures

Scale = Annotated[float, Meta(ge=0, le=1e6)]
"""A standard deviation: large enough for any motion, small enough that nothing overflows."""
Return = Annotated[float, Meta(ge=0, lt=1)]

LONGEST_INTERVAL = 1.0
"""Longest interval between two frames, in seconds.

A longer gap counts as this one; the noise would hide the last known place otherwise."""


class Motion:
    """The interface of a motion model, which is also a `Config` with a tag.

    Methods do not change their arguments, and all randomness comes from `rng`.
    """

    __slots__ = ()

    @abstractmethod
    def initial(self, ellipses: Floats) -> Floats:
        """Return states (N, d), at rest, for ellipses (N, 5)."""

    @abstractmethod
    def propagate(
        self, rng: np.random.Generator, states: Floats, dt: float, first: Ellipse
    ) -> Floats:
        """Return new states (N, d) drawn from p(x_t | x_{t-1}), `dt` seconds later.

        `first` is the target's first region, to which noise may be proportional. Half-axes stay at
        one pixel or more. With `dt` 0 the states stay the same.
        """

    @abstractmethod
    def ellipses(self, states: Floats) -> Floats:
        """Return the ellipses (N, 5) of states (N, d): the inverse of `initial`."""


class Noise(Config, frozen=True):
    """Random motion of a target in one reference interval of 1/25 s."""

    position: Scale = 0.6
    """Noise of the center in 1/25 s: standard deviation of x and y, as a share of the mean
    half-axis sqrt(a b) of the target's first region. A larger value follows faster targets."""
    size: Share = 0.05
    """Noise of the size in 1/25 s: standard deviation of the natural logarithm of a factor common
    to both half-axes. A larger value follows faster changes of the size."""
    size_return: Share = 0.05
    """Pull back to the first size: share of the difference of the half-axes' logarithms that is
    removed in 1/25 s. A larger value keeps the size nearer to the first one; 0 is no pull."""
    aspect: Scale = 0.003
    """Noise of the proportions in 1/25 s: standard deviation of each half-axis by itself, as a
    share of the first region's half-axis. A larger value follows faster changes of the
    proportions."""
    angle: Scale = 0.0
    """Noise of the angle in 1/25 s: standard deviation of theta, in radians. A larger value follows
    faster turns; with 0 the angle never changes."""


class Walking(Motion, Config, frozen=True, dict=True):
    """The base of motions in which a state's columns take noise, and some change others.

    State: x, y, a, b, theta, then k orders of changes of the first four, such as velocities, per
    reference interval.
    """

    noise: Noise = Noise()
    """Noise of the center, the size, the proportions and the angle in 1/25 s."""

    @property
    def changes(self) -> tuple[float, ...]:
        """Standard deviations of the changes' noise, as shares of that of what they change."""
        return ()

    @property
    def kept(self) -> float:
        """Share of a change that is left after one reference interval."""
        return 1.0

    def initial(self, ellipses: Floats) -> Floats:
        """Return the ellipses at rest, (N, 5 + 4k)."""
        states = np.zeros((len(ellipses), 5 + 4 * len(self.changes)))
        states[:, :5] = ellipses
        return states

    def propagate(
        self, rng: np.random.Generator, states: Floats, dt: float, first: Ellipse
    ) -> Floats:
        """Return A s + w (Nummiaro et al., equation 9)."""
        n, columns = states.shape
        out, steps = np.empty((n, columns)), dt / FRAME_INTERVAL
        normal = rng.standard_normal((n, columns + 1))  # one a column, and one of the size
        kernels.particles.walk(states, normal, self.kernel_noise, steps, first[2:4], out)
        return out

    def ellipses(self, states: Floats) -> Floats:
        """Return the first five columns."""
        return states[:, :5]

    @cached_property
    def kernel_noise(self) -> structures.NoiseScales:
        """The noise in the form that kernels take."""
        noise = self.noise
        return structures.NoiseScales(
            noise.position, noise.size, noise.size_return, noise.aspect, noise.angle,
            np.array(self.changes, float), self.kept,
        )  # fmt: skip


class RandomWalk(Walking, frozen=True, tag="random_walk"):
    """Random walk: the target stays where it was, plus noise.

    A model of zero order. State: x, y, a, b, theta.
    """


class ConstantVelocity(Walking, frozen=True, tag="constant_velocity"):
    """Constant velocity: noise changes the velocities of the center and of the half-axes.

    A model of first order: Nummiaro et al., equation 8. State: x, y, a, b, theta and the changes of
    the first four, per reference interval.
    """

    velocity: Scale = 0.5
    """Noise of the velocities: standard deviation in 1/25 s, as a share of the noise of the center
    and of the proportions. A larger value follows faster changes of velocity."""
    persistence: Share = 1.0
    """Share of a velocity that is left after 1/25 s. With a larger value a target keeps its motion
    for longer: 1 is the paper's constant velocity, 0 is a random walk."""

    @property
    def changes(self) -> tuple[float, ...]:
        """The share of velocities."""
        return (self.velocity,)

    @property
    def kept(self) -> float:
        """The persistence."""
        return self.persistence


class SecondOrder(ConstantVelocity, frozen=True, tag="second_order"):
    """Second order: accelerations change the velocities, and noise changes both.

    The extension that Nummiaro et al. name in sections IV and VI. State: x, y, a, b, theta, then
    velocities and accelerations of the first four, per reference interval.
    """

    persistence: Share = 0.9
    """Share of a velocity and of an acceleration that is left after 1/25 s. With a larger value a
    target keeps its motion for longer."""
    acceleration: Scale = 0.2
    """Noise of the accelerations: standard deviation in 1/25 s, as a share of the noise of the
    center and of the proportions. A larger value follows faster changes of acceleration."""

    @property
    def changes(self) -> tuple[float, ...]:
        """The shares of velocities and accelerations."""
        return self.velocity, self.acceleration


class EllipseWalk(Motion, Config, frozen=True, tag="ellipse_walk"):
    """Random walk of center, minor half-axis, eccentricity and angle: Maggio et al., section 5.

    State: x, y, h, e, theta. h is the half-length of the minor axis, e the eccentricity
    sqrt(1 - (minor / major)²), theta the angle of the major axis.
    """

    position: Scale = 5.5
    """Noise of the center: standard deviation of x and y in 1/25 s, in pixels. A larger value
    follows faster targets. The paper has 5.5."""
    size: Share = 0.05
    """Noise of the size: standard deviation of the minor half-axis h in 1/25 s, relative to h. A
    larger value follows faster changes of the size. The paper has 0.05."""
    eccentricity: Share = 0.021
    """Noise of the proportions: standard deviation of the eccentricity e in 1/25 s. A larger value
    follows faster changes of the proportions. The paper has 0.021."""
    angle: Scale = math.radians(10)
    """Noise of the angle: standard deviation of theta in 1/25 s, in radians. A larger value follows
    faster turns. The paper has 10 degrees."""

    def initial(self, ellipses: Floats) -> Floats:
        """Return x, y, h, e, theta of ellipses, (N, 5)."""
        states = ellipses.copy()
        a, b = ellipses[:, 2], ellipses[:, 3]
        minor, major = np.minimum(a, b), np.maximum(a, b)
        states[:, 2], states[:, 3] = minor, np.sqrt(1 - (minor / major) ** 2)
        states[:, 4] += np.where(a < b, np.pi / 2, 0.0)
        return states

    def propagate(
        self, rng: np.random.Generator, states: Floats, dt: float, first: Ellipse
    ) -> Floats:
        """Return states plus noise; e stays within [0, 0.995], h at one pixel or more."""
        grown = math.sqrt(dt / FRAME_INTERVAL)
        out = rng.standard_normal(states.shape)
        out *= [self.position * grown] * 2 + [
            self.size * grown, self.eccentricity * grown, self.angle * grown
        ]  # fmt: skip
        out[:, 2] = np.maximum(np.exp(out[:, 2]) * states[:, 2], 1.0)
        out[:, :2] += states[:, :2]
        out[:, 3:] += states[:, 3:]
        out[:, 3] = np.minimum(np.abs(out[:, 3]), 0.995)
        return out

    def ellipses(self, states: Floats) -> Floats:
        """Return the ellipses, a being the major half-axis."""
        out = states.copy()
        out[:, 2], out[:, 3] = states[:, 2] / np.sqrt(1 - states[:, 3] ** 2), states[:, 2]
        return out


class Autoregressive(Motion, Config, frozen=True, tag="autoregressive"):
    """Second-order autoregressive dynamics: Zhao and Pei, equation 17.

    State: x, y, s, their previous values, the width w and height h that the scale s multiplies, and
    x0, y0, where the target began; then theta, which stays (the paper's boxes are upright). With
    origins x0, y0 and 1,

        x_t - x0 = (k + p) (x_{t-1} - x0) - k p (x_{t-2} - x0) + noise

    and the same for y and s. The paper does not give its A. With k = 1 and p = 1 a target keeps its
    velocity, and x0 cancels out. p below 1 slows the target down; k below 1 pulls it back to its
    origin. Previous values are those of one reference interval ago, whatever the time between
    frames.
    """

    position: Scale = 0.6
    """Noise of the center: standard deviation of x and y in 1/25 s, as a share of the mean
    half-axis sqrt(a b) of the target's first region. A larger value follows faster targets."""
    size: Share = 0.05
    """Noise of the size: standard deviation of the scale s in 1/25 s; 1 is the first size. A larger
    value follows faster changes of the size."""
    persistence: Share = 0.5
    """Share p of a displacement that the target repeats in the next 1/25 s. With a larger value it
    keeps its motion for longer; with 1 it never slows down."""
    position_return: Return = 0.0
    """Pull back to the first place: share 1 - k of the way that the target goes back in 1/25 s. A
    larger value keeps it nearer to the first place; 0 is no pull."""
    size_return: Return = 0.05
    """Pull back to the first size: share 1 - k of the way that the scale goes back in 1/25 s. A
    larger value keeps the size nearer to the first one; 0 is no pull."""

    def initial(self, ellipses: Floats) -> Floats:
        """Return the ellipses at rest at their origins, (N, 11)."""
        x, y, a, b, theta = ellipses.T
        one = np.ones(len(ellipses))
        return np.stack([x, y, one, x, y, one, 2 * a, 2 * b, x, y, theta], axis=1)

    def propagate(
        self, rng: np.random.Generator, states: Floats, dt: float, first: Ellipse
    ) -> Floats:
        """Return A s + w; half-axes stay at one pixel or more."""
        steps = dt / FRAME_INTERVAL
        position = self.position * math.sqrt(first.a * first.b)
        noise = rng.standard_normal((len(states), 3)) * [position, position, self.size]
        kept = 1 - np.array([self.position_return, self.position_return, self.size_return])
        origin = np.ones((len(states), 3))
        origin[:, :2] = states[:, 8:10]
        # The part of x_t - x0 beyond k (x_{t-1} - x0) shrinks to the share p, and noise is added.
        off = states[:, :3] - origin
        change = off - kept * (states[:, 3:6] - origin)
        change = self.persistence**steps * change + math.sqrt(steps) * noise
        off = kept**steps * off + steps * change
        out = states.copy()
        out[:, :3], out[:, 3:6] = origin + off, origin + (off - change) / kept
        out[:, 2] = np.maximum(out[:, 2], 2 / states[:, 6:8].min(axis=1))
        return out

    def ellipses(self, states: Floats) -> Floats:
        """Return the ellipses: half-axes s w / 2 and s h / 2."""
        out = np.empty((len(states), 5))
        out[:, :2], out[:, 4] = states[:, :2], states[:, 10]
        out[:, 2:4] = 0.5 * states[:, 2:3] * states[:, 6:8]
        return out


MOTIONS = Registry[type[Motion]](
    "motion model",
    "motes.motions",
    Motion,
    {
        "random_walk": RandomWalk,
        "constant_velocity": ConstantVelocity,
        "second_order": SecondOrder,
        "ellipse_walk": EllipseWalk,
        "autoregressive": Autoregressive,
    },
)
