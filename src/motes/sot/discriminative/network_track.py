"""A trained network beside the particles: each follows the target by itself.

Where their boxes agree, the target is at the mean of both. Where they part, both live on, and the
one counts for whose place the particles' models have more evidence: a network is as sure of a
neighbor as of the target. Who has less for some frames in a row begins again where the other is.
So nothing of a network is fitted, neither a weight nor what its score means.
"""

from __future__ import annotations

from typing import Annotated, Self

import msgspec
import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse
from motes.core.types import Singles
from motes.sot.discriminative.redetection import MIN_HALF_AXIS
from motes.sot.discriminative.standing import FRAMES, Standing
from motes.sot.network.network import Network

AGREES = 0.3
"""Overlap of two boxes from which they show the same target."""


class NetworkTrack(msgspec.Struct, frozen=True, eq=False):
    """What the network knows of the target, and how it stands to the particles."""

    template: Singles
    """The network's template of the target, from the first frame."""
    place: Ellipse
    """Where the network sees the target, in its own size and proportions."""
    score: Annotated[float, Meta(ge=0, le=1)] = 1.0
    """Its score there."""
    ahead: bool = False
    """Whether the network's place has more evidence than the particles', where they part."""
    parted: Annotated[int, Meta(ge=0)] = 0
    """Number of frames in a row in which the same one of them had more evidence."""
    standing: Standing = Standing()
    """The status of the target, by the joint confidence."""

    @property
    def decided(self) -> bool:
        """Whether the one that has less evidence is to begin again where the other one is."""
        return self.parted >= FRAMES

    @classmethod
    def begin(cls, network: Network, frame: Frame, box: Ellipse) -> Self:
        """Return the track of the target in a box of the first frame."""
        return cls(network.learn(frame, box), box)

    def followed(self, network: Network, frame: Frame) -> Self:
        """Return the track with the box that the network chooses in the next frame."""
        box, score = network.look(self.template, frame, self.place).best()
        ends = np.array([frame.width, frame.height])
        seen = np.array(Ellipse.from_box(box))
        seen[:2] = np.clip(seen[:2], 0, ends - 1)
        seen[2:4] = np.clip(seen[2:4], MIN_HALF_AXIS, np.maximum(ends / 2, MIN_HALF_AXIS))
        return replace(self, place=Ellipse(*seen.tolist()), score=score)

    def agreed(self) -> Self:
        """Return the track after a frame in which both agree."""
        return replace(self, ahead=False, parted=0)

    def compared(self, lead: float) -> Self:
        """Return the track after a frame in which both part.

        `lead` is by how much the evidence of its place exceeds that of the particles' place.
        """
        ahead = lead > 0
        return replace(self, ahead=ahead, parted=self.parted + 1 if ahead is self.ahead else 1)

    def placed(self, place: Ellipse) -> Self:
        """Return the track, begun again at a place."""
        return type(self)(self.template, place)

    def mean(self, box: Box, confidence: float) -> Ellipse:
        """Return the ellipse in the mean of the particles' box and its own: it sees no turn.

        They are weighted by the confidence and the score.
        """
        own = confidence / (confidence + self.score)
        mean = own * np.array(box) + (1 - own) * np.array(self.place.box)
        return Ellipse.from_box(mean.tolist())
