"""A trained network as one more expert of the default tracker.

It proposes a place, as the confined filter does, has a voice in the evidence, and is the only
expert that sees the target's proportions. It follows the target by itself, so that it may be right
where the others are wrong, and is placed anew where the evidence has decided against it.
"""

from __future__ import annotations

from typing import NamedTuple, Self

import msgspec
import numpy as np

from motes.core.frame import Frame
from motes.core.geometry import Box, Ellipse, iou
from motes.core.types import Floats
from motes.sot.network.network import Network, NetworkModel
from motes.sot.network.view import Candidate, NetworkView

AGREES = 0.3
"""Overlap of two boxes from which they show the same target."""
NO_OPINION = 0.4
"""A score that speaks neither for the target nor against it; that of a place not looked at."""


class NetworkTarget(msgspec.Struct, frozen=True, eq=False):
    """What the network knows of the target.

    Attributes
    ----------
    model
        The template of the first frame.
    place
        Where the network has seen the target, in its own size and proportions.
    """

    model: NetworkModel
    place: Ellipse

    @classmethod
    def learn(cls, network: Network, frame: Frame, box: Ellipse) -> Self:
        """Return the target in a box."""
        return cls(network.learn(frame, box), box)


class NetworkOpinion(NamedTuple):
    """What the network says of a frame.

    Attributes
    ----------
    view
        The boxes that it sees.
    candidate
        The box that it would choose.
    """

    view: NetworkView
    candidate: Candidate

    @classmethod
    def of(cls, network: Network, target: NetworkTarget, frame: Frame, shift: Floats) -> Self:
        """Return the opinion on a frame, looked at where the target is expected."""
        x, y = np.clip(target.place[:2] + shift, 0, (frame.width - 1, frame.height - 1)).tolist()
        view = network.look(target.model, frame, target.place._replace(x=x, y=y))
        return cls(view, view.best())

    @property
    def place(self) -> Ellipse:
        """The ellipse in the chosen box."""
        return Ellipse.from_box(self.candidate.box)

    def score(self, place: Ellipse) -> float:
        """Return how much the network holds a place for the target's, 0 to 1."""
        return float(self.view.score_at(np.array([place]))[0])

    def agrees(self, box: Box) -> bool:
        """Return whether the network has chosen about the same box."""
        return float(iou(self.candidate.box, box)) > AGREES

    def followed(self, target: NetworkTarget, found: Ellipse, *, decided: bool) -> NetworkTarget:
        """Return the target after a frame.

        Parameters
        ----------
        found
            Where the tracker has found the target.
        decided
            Whether the evidence has decided for that place.
        """
        if decided and not self.agrees(found.box):
            a, b = (half * found.side / target.place.side for half in target.place[2:4])
            return msgspec.structs.replace(target, place=found._replace(a=a, b=b, theta=0.0))
        return msgspec.structs.replace(target, place=self.place)
