"""Calls of public functions with numbers, shapes and types that nobody means.

An input is the name of a call and the seed of its arguments. `make sanitize` makes these calls with
kernels that notice every access beside an array.
"""

from collections.abc import Callable, Sequence
from functools import cached_property
from random import Random
from typing import Any

import numpy as np
from numpy.typing import NDArray

import motes
from motes import Box, Ellipse, Frame, MotesError
from motes.cues import sunflower, visible
from motes.cues.color import Color, Posterior
from motes.cues.correlation_filter import Correlation, ScaleFilter
from motes.cues.gradients import Edges, Hog
from motes.cues.sampling import Checkerboard, EveryPixel, Lattice
from motes.cues.structure_tensor import Orientation
from motes.mot.expected import Expected
from motes.sot.discriminative.expert import Confined
from motes.sot.discriminative.redetection import Redetection
from motes.sot.filtering.appearance_rule import AppearanceRule
from motes.sot.filtering.bin_updates import AnchoredKalman, GaussianBins, KalmanBins
from motes.sot.filtering.fusion import Fixed, PrintedMixture
from motes.sot.filtering.likelihood import BestParticle, Exponential, Gaussian
from motes.sot.filtering.model_update import ExponentialForgetting
from motes.sot.filtering.motion import (
    Autoregressive,
    ConstantVelocity,
    EllipseWalk,
    RandomWalk,
    SecondOrder,
)
from motes.sot.filtering.resampling import KldSampling, Multinomial, Systematic, Weights

from .outcomes import READ, REFUSED, DefectError, check_finite, check_message

NUMBERS = (
    0.0, -0.0, 1.0, -1.0, 0.5, 3.0, -7.0, 40.0, 1e3, -1e3, 1e6, 1e9, -1e9, 2**31, 2**32, 1e15, 1e16,
    -1e19, 1e155, 1e300, -1e300, 5e-324, 1e-20, np.nan, np.inf, -np.inf,
)  # fmt: skip
KINDS = (np.float32, np.int64, np.float16, object, np.complex128, "U8")
CUES: tuple[Any, ...] = (
    Color(), Color(space="hsv", bins=(8, 8, 4)), Color(space="hsv+v", kernel="gaussian"),
    Color(bins=(3, 5, 2), sampling=EveryPixel()), Edges(), Edges(bins=5, sampling=EveryPixel()),
    Hog(), Hog(cells=3, bins=5, sampling=Checkerboard()), Hog(cells=2, sampling=EveryPixel()),
    Orientation(), Orientation(form="fourier", bins=9, sampling=Checkerboard(share="quarter")),
    Orientation(sampling=EveryPixel(), window=0.01), Posterior(), Correlation(),
)  # fmt: skip
MOTIONS = (RandomWalk(), ConstantVelocity(), SecondOrder(), EllipseWalk(), Autoregressive())


class _Wild:
    """Arguments: most are as they should be, some are not."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.odd = False
        """Whether an array has a shape or a type that no caller means; Python may say so."""

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def one(self, values: Sequence[Any]) -> Any:
        return values[int(self.rng.integers(len(values)))]

    def number(self, usual: float, share: float = 0.3) -> float:
        return float(self.one(NUMBERS)) if self.chance(share) else usual

    @cached_property
    def size(self) -> tuple[int, int]:
        """Height and width of frames."""
        sizes = (1, 1), (1, 2), (2, 1), (3, 200), (9, 7), (48, 64), (48, 64), (120, 160)
        return sizes[self.rng.integers(len(sizes))]

    def frame(self, index: int = 0) -> Frame:
        """Return a frame as it may lie in memory: RGB, BGR, gray, a part of a larger one."""
        height, width = self.size if self.chance(0.9) else (5, 11)
        pixels = self.rng.integers(0, 256, (height + 2, width + 3, 4), np.uint8)
        views = (
            pixels[:height, :width, :3].copy(), pixels[1 : height + 1, 2 : width + 2, :3],
            pixels[:height, :width, 2::-1], pixels[:height, :width, 0],
            pixels[height - 1 :: -1, :width], pixels[:height, width - 1 :: -1, :3],
            pixels[:height, :width] > 99,
        )  # fmt: skip
        return Frame(index, index / 25, self.one(views))

    def ellipse(self, share: float = 0.2) -> Ellipse:
        height, width = self.size
        low = (-9, -9, 1, 1, -4), (width + 9, height + 9, width + 1, height + 1, 4)
        return Ellipse(*(self.number(value, share) for value in self.rng.uniform(*low)))

    def good(self) -> Ellipse:
        return self.ellipse(0.0)

    def array(self, values: Any) -> Any:
        """Return values as an array; at times with another shape, type or order."""
        array = np.asarray(values, np.float64)
        if self.chance(0.1):
            return self.one((np.asfortranarray(array), np.repeat(array, 2, axis=0)[::2], array))
        if self.chance(0.9):
            return array
        self.odd = True
        ways: list[Callable[[], Any]] = [
            lambda: array[..., :-1], lambda: np.concatenate([array, array], axis=-1),
            lambda: array.ravel(), lambda: array[None], lambda: array[:0], lambda: None,
            lambda: "ellipses", lambda: array.astype(self.one(KINDS)), lambda: array.tolist(),
        ]  # fmt: skip
        with np.errstate(all="ignore"):
            return self.one(ways)()

    def ellipses(self, share: float = 0.05) -> Any:
        return self.array([self.ellipse(share) for _ in range(self.rng.integers(1, 30))])

    def numbers(self, *shape: int, share: float = 0.1) -> Any:
        values = self.rng.random(shape)
        wild = self.rng.random(shape) < share
        return self.array(np.where(wild, self.rng.choice(NUMBERS, shape), values))


def _cue(wild: _Wild) -> tuple[Any, Any]:
    """Return a cue and a target model of it, or, at times, of the same cue with other bins."""
    cue = wild.one(CUES)
    if wild.chance(0.1):
        same = [each for each in CUES if type(each) is type(cue)]
        other = wild.one(same)
        wild.odd = other != cue
        return cue, other.learn(wild.frame(), wild.good())
    return cue, cue.learn(wild.frame(), wild.good())


def _learn(wild: _Wild) -> None:
    wild.one(CUES).learn(wild.frame(), wild.ellipse())


def _compare(wild: _Wild) -> None:
    cue, model = _cue(wild)
    ellipses = wild.ellipses()
    found = cue.distances(model, wild.frame(), ellipses)
    if found.shape != (len(ellipses),) or not ((found >= 0) & (found <= 1)).all():
        raise DefectError(f"Distances are {found}.")


def _observe(wild: _Wild) -> None:
    cue, model = _cue(wild)
    for method in (cue.update_reading, cue.learn_also, getattr(cue, "observe", None)):
        if method is not None and wild.chance(0.5):
            method(model, wild.frame(), wild.ellipse())


def _histograms(wild: _Wild) -> None:
    found = wild.one([cue for cue in CUES if hasattr(cue, "histograms")]).histograms(
        wild.frame(), wild.ellipses()
    )
    check_finite(found.ravel().tolist())


def _shift(wild: _Wild) -> None:
    cue = wild.one([cue for cue in CUES if isinstance(cue, Color)])
    check_finite(cue.shift(cue.learn(wild.frame(), wild.good()), wild.frame(), wild.ellipse()))


def _scales(wild: _Wild) -> None:
    cue = ScaleFilter(count=int(wild.one((1, 2, 13))))
    model = cue.learn(wild.frame(), wild.ellipse(0.1))
    spectra = cue.spectra(model, wild.frame(), wild.ellipse(0.1))
    cue.between(cue.response(cue.updated(model, spectra, 0.3), spectra).astype(float))


def _sampling(wild: _Wild) -> None:
    visible(wild.frame(), wild.ellipses())
    sunflower(int(wild.rng.integers(1, 300)))
    cue = Color(sampling=Lattice(points=int(wild.rng.integers(8, 300))))
    cue.distances(cue.learn(wild.frame(), wild.good()), wild.frame(), wild.ellipses())


def _expert(wild: _Wild) -> None:
    expert = wild.one((Confined(), Redetection()))
    model = expert.learn(wild.frame(), wild.ellipse(0.05))
    if isinstance(expert, Redetection):
        expert.log_odds(model, wild.frame(), wild.ellipse())
        return
    sight = expert.look(model, wild.frame(), wild.ellipse(0.05))
    expert.log_odds(sight, wild.good())
    expert.updated(model, wild.frame(), sight, wild.good(), 0.5)


def _motion(wild: _Wild) -> None:
    model = wild.one(MOTIONS)
    states = model.initial(wild.ellipses())
    if wild.chance(0.1):
        states, wild.odd = wild.one(MOTIONS).initial(wild.ellipses()), True
    after = model.propagate(wild.rng, states, abs(wild.number(0.04)), wild.good())
    model.ellipses(after)


def _weights(wild: _Wild) -> None:
    n = int(wild.rng.integers(1, 50))
    weights = Weights.from_log(wild.numbers(n))
    check_finite([*weights.values.tolist(), weights.effective_sample_size])
    method = wild.one((Multinomial(threshold=0.5), Systematic()))
    method.due(weights)
    chosen = method.ancestors(wild.rng, weights, int(wild.rng.integers(0, 60)))
    weights.values[chosen]


def _likelihood(wild: _Wild) -> None:
    distances = wild.numbers(int(wild.rng.integers(1, 4)), int(wild.rng.integers(1, 40)))
    wild.one((Gaussian(), BestParticle(), Exponential())).log(distances)


def _fusion(wild: _Wild) -> None:
    names, n = ["color", "edges", "hog"][: wild.rng.integers(1, 4)], int(wild.rng.integers(1, 40))
    ellipses = wild.array([wild.ellipse(0.02) for _ in range(n)])
    rule = wild.one((Fixed(), PrintedMixture()))
    weights, _ = rule.fuse(names, wild.numbers(n), wild.numbers(len(names), n), ellipses)
    check_finite(weights.values.tolist())


def _strategy(wild: _Wild) -> None:
    strategy = wild.one((ExponentialForgetting(learning_rate=0.2), KalmanBins(frames=2),
                         GaussianBins(), AnchoredKalman(frames=2)))  # fmt: skip
    memory, histogram, first = None, np.full(8, 1 / 8), np.full(8, 1 / 8)
    for _ in range(4):
        histogram, memory = strategy.learn(memory, histogram, first, wild.numbers(8, share=0.02))


def _presence(wild: _Wild) -> None:
    cue, model = _cue(wild)
    rule = AppearanceRule(max_positions=50)
    found = rule.background(
        cue, model, wild.frame(), wild.ellipse(), target_in_frame=wild.chance(0.5)
    )
    rule.threshold(found)
    rule.counted(wild.numbers(4), wild.numbers(4, 5), wild.frame())
    KldSampling().count(wild.ellipses(0.0), wild.good())


def _expect(wild: _Wild) -> None:
    """Expect a target of each kind of filter, tracked or lost, at any ellipses."""
    wild.__dict__["size"] = (48, 64)
    name = wild.one(("nummiaro", "ng_delp", "maggio", "zhao_pei"))
    tracker = motes.Tracker(name, seed=0)
    pixels = wild.rng.integers(0, 256, (48, 64, 3), np.uint8)
    tracker.init(pixels, (20, 12, 16, 14))
    for _ in range(4):
        tracker.update(np.zeros_like(pixels) if wild.chance(0.7) else pixels)
    tracker.expect(wild.ellipses(wild.one((0.0, 0.002, 0.05))))
    check_finite(tracker.update(pixels).ellipse)


def _scene(wild: _Wild) -> None:
    """Follow what a detector returns: boxes of any numbers, in any form."""
    wild.__dict__["size"] = (48, 64)

    def detect(frame: Frame) -> Any:
        low, high = (-9, -9, 2, 2), (60, 40, 40, 30)
        share = float(wild.one((0.0, 0.05)))
        boxes = [
            tuple(wild.number(value, share) for value in wild.rng.uniform(low, high))
            for _ in range(wild.rng.integers(0, 5))
        ]
        forms: tuple[Callable[[], Any], ...] = (
            lambda: boxes,
            lambda: wild.array(boxes or np.empty((0, 4))),
            lambda: [motes.Detection(Box(*box), wild.number(0.5, share), "car") for box in boxes],
        )
        return wild.one(forms)()

    scene = motes.Scene(detect, seed=0)
    blocks: NDArray[np.uint8] = np.kron(
        wild.rng.integers(0, 256, (6, 8, 3), np.uint8), np.ones((8, 8, 1), np.uint8)
    )
    model = Expected.CUE.learn(Frame(0, 0.0, blocks), Ellipse(20, 20, 9, 9))
    for _ in range(6):
        if wild.chance(0.3):
            share = float(wild.one((0.0, 0.01)))
            scene.expect([Expected(1, wild.ellipses(share), wild.numbers(2, share=share), model,
                                   wild.chance(0.5))])  # fmt: skip
        for track in scene.update(blocks):
            check_finite(track.box)


CALLS: dict[str, Callable[[_Wild], None]] = {
    call.__name__[1:]: call
    for call in (
        _learn, _compare, _observe, _histograms, _shift, _scales, _sampling, _expert, _motion,
        _weights, _likelihood, _fusion, _strategy, _presence, _expect, _scene,
    )
}  # fmt: skip


def seeds() -> list[bytes]:
    """Return each call once."""
    return [name.encode() for name in CALLS]


def mutate(random: Random, calls: Sequence[bytes]) -> bytes:
    """Return a call with other arguments."""
    return random.choice(calls) + b" %d" % random.randrange(1 << 32)


def check(data: bytes) -> str:
    """Make a call: it returns what can be used, or refuses what it was given."""
    name, _, seed = data.decode().partition(" ")
    wild = _Wild(int(seed or 0))
    with np.errstate(all="ignore"):
        try:
            CALLS[name](wild)
        except MotesError as error:
            check_message(str(error))
            return REFUSED
        except (TypeError, ValueError, IndexError, AttributeError, RuntimeWarning):
            if not wild.odd:
                raise
            return REFUSED
    return READ
