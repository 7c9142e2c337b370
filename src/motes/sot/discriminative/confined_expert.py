"""The confined filter as an expert: it sees the target in a window of five times its side."""

from __future__ import annotations

from motes.core.config import NonNegative
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.cues.confined_filter import ConfinedFilter, ConfinedModel, ConfinedView
from motes.sot.discriminative.evidence import LARGEST_VOICE, NEUTRAL
from motes.sot.discriminative.expert import Expert
from motes.sot.discriminative.rival import APART

TRUSTED_RESPONSE = NEUTRAL / 2
"""From this response on, relative to the first frames, the filter's place counts."""


class Confined(ConfinedFilter, Expert, frozen=True):
    """The response of a filter that is confined to the target; see `ConfinedFilter`."""

    weight: NonNegative = 2.5
    """Log odds for a place with the response of the first frames; see `Evidence`. With 0 the expert
    is not asked."""

    def look(self, model: ConfinedModel, frame: Frame, place: Ellipse) -> ConfinedView:
        """Return the responses around a place."""
        return self.view(model, frame, place)

    def serves(self, sight: ConfinedView, place: Ellipse) -> bool:
        """Return whether the window holds the place, in about its size and in its angle."""
        return sight.covers(place)

    def proposes(self, sight: ConfinedView) -> Ellipse:
        """Return where the response is largest."""
        return sight.peak()

    def refined(self, sight: ConfinedView, place: Ellipse) -> Ellipse | None:
        """Return where the response is largest among the places that may be the same target."""
        response, peak = sight.near(place, APART)
        return peak if response > TRUSTED_RESPONSE else None

    def log_odds(self, sight: ConfinedView, place: Ellipse) -> float:
        """Return by how much the response speaks for a place."""
        response, _ = sight.near(place)
        return self.weight * (min(response, LARGEST_VOICE) - NEUTRAL)
