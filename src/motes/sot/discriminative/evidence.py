"""How sure the default tracker is: the evidence of several experts that the target is at a place.

Each expert has a voice, and the voices are added to log odds, as in a logistic regression. No voice
can veto the others: a gray target has no color contrast, a turned one no likeness to the first
frame, and either may still be known by the rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from motes.core.config import Config, NonNegative

LARGEST_VOICE = 1.5
"""No voice counts as more than this, however strong: it may be wrong, too."""
LARGEST_DISTANCE = 0.6
"""Color histograms farther apart than this are all equally unlike: the light has changed."""
LARGEST_LOG_ODDS = 30.0


class Voices(NamedTuple):
    """What the experts say of a place.

    Attributes
    ----------
    gradients
        Response of the first frame's correlation filter, which never learns.
    contrast
        Color contrast between the box and its surroundings, -1 to 1.
    confined
        Response of the confined filter, relative to that in the first frames.
    colors
        Bhattacharyya distance of the color histogram to that of the first region, 0 to 1.
    network
        How much more than without an opinion a trained network holds the place for the target's;
        0 without a network.
    """

    gradients: float
    contrast: float
    confined: float
    colors: float
    network: float = 0.0


class Evidence(Config, frozen=True):
    """The log odds that the target is at a place.

    They were fitted by logistic regression to places on the target and beside it, half of these
    places where a tracker had been led astray. They are the same for all videos.

    Attributes
    ----------
    gradients, contrast, confined, colors, network
        Weight of each voice. With 0 the expert has no say.
    prior
        Log odds of a place of which no expert says anything.
    """

    gradients: NonNegative = 5.0
    contrast: NonNegative = 5.0
    confined: NonNegative = 2.5
    colors: NonNegative = 3.75
    network: NonNegative = 5.0
    prior: float = -2.0

    def log_odds(self, voices: Voices) -> float:
        """Return the log odds that a place is the target's."""
        return (
            self.prior
            + self.gradients * min(voices.gradients, LARGEST_VOICE)
            + self.contrast * voices.contrast
            + self.confined * min(voices.confined, LARGEST_VOICE)
            - self.colors * min(voices.colors, LARGEST_DISTANCE)
            + self.network * voices.network
        )


def probability(log_odds: float) -> float:
    """Return the probability of log odds, from 0 to 1."""
    return 1 / (1 + math.exp(-min(max(log_odds, -LARGEST_LOG_ODDS), LARGEST_LOG_ODDS)))
