"""A trained network as one more expert of the default tracker.

It proposes a place, as the confined filter does, and is the only expert that sees the target's
proportions. It follows the target by itself, so that it may be right where the others are wrong,
and is placed anew where the evidence has decided against it.
"""

from __future__ import annotations

from typing import NamedTuple

import msgspec
import numpy as np
from msgspec.structs import replace

from motes.core.config import Config, NonNegative
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, iou
from motes.core.types import Floats
from motes.sot.discriminative.evidence import NEUTRAL
from motes.sot.discriminative.expert import AGREES, Expert
from motes.sot.network.network import Network, NetworkModel
from motes.sot.network.view import Candidate, NetworkView


class NetworkTarget(msgspec.Struct, frozen=True, eq=False):
    """What the network knows of the target."""

    model: NetworkModel
    """The template of the first frame."""
    place: Ellipse
    """Where the network has seen the target, in its own size and proportions."""


class NetworkSight(NamedTuple):
    """What the network sees in a frame."""

    view: NetworkView
    """The boxes that it sees."""
    candidate: Candidate
    """The box that it would choose."""

    @property
    def place(self) -> Ellipse:
        """The ellipse in the chosen box."""
        return Ellipse.from_box(self.candidate.box)


class NetworkExpert(Expert, Config, frozen=True):
    """A trained network that joins the experts."""

    network: Network
    """The network."""
    weight: NonNegative = 4.0
    """Log odds for a place that the network is sure of; see `Evidence`."""

    def learn(self, frame: Frame, box: Ellipse) -> NetworkTarget:
        """Return the target in a box."""
        return NetworkTarget(self.network.learn(frame, box), box)

    def look(
        self, model: NetworkTarget, frame: Frame, place: Ellipse, shift: Floats
    ) -> NetworkSight:
        """Return what the network sees where it has followed the target itself."""
        x, y = np.clip(model.place[:2] + shift, 0, (frame.width - 1, frame.height - 1)).tolist()
        view = self.network.look(model.model, frame, model.place._replace(x=x, y=y))
        return NetworkSight(view, view.best())

    def proposes(self, sight: NetworkSight) -> Ellipse:
        """Return the chosen place."""
        return sight.place

    def region(self, sight: NetworkSight) -> tuple[Ellipse, float]:
        """Return the chosen place, in its own proportions, and its score."""
        return sight.place, sight.candidate.score

    def log_odds(self, sight: NetworkSight, place: Ellipse) -> float:
        """Return by how much the network's score speaks for a place."""
        [score] = sight.view.score_at(np.array([place]))
        return self.weight * (float(score) - NEUTRAL)

    def updated(
        self,
        model: NetworkTarget,
        frame: Frame,
        sight: NetworkSight,
        place: Ellipse,
        share: float,
    ) -> NetworkTarget:
        """Return the target where the network has seen it, or at a decided place that differs."""
        if share and iou(sight.candidate.box, place.box) <= AGREES:
            a, b = (half * place.side / model.place.side for half in model.place[2:4])
            return replace(model, place=place._replace(a=a, b=b, theta=0.0))
        return replace(model, place=sight.place)

    def placed(self, model: NetworkTarget, box: Ellipse) -> NetworkTarget:
        """Return the target where the user has placed it."""
        return replace(model, place=box)
