"""How sure the default tracker is: the evidence of several experts that the target is at a place.

Each expert has a voice, and the voices are added to log odds, as in a logistic regression. No voice
can veto the others: a gray target has no color contrast, a turned one no likeness to the first
frame, and either may still be known by the rest.
"""

from __future__ import annotations

import math

from motes.core.config import Config, NonNegative

LARGEST_VOICE = 1.5
"""No voice counts as more than this, however strong: it may be wrong, too."""
NEUTRAL = 0.6
"""A filter's response that speaks neither for a place nor against it."""
LARGEST_LOG_ODDS = 30.0


class Evidence(Config, frozen=True):
    """The log odds that the target is at a place: those of the near window, and of a prior.

    The other experts add theirs. All weights were fitted by logistic regression to places on the
    target and beside it, half of these places where a tracker had been led astray. They are the
    same for all videos. With a weight of 0, a voice has no say.
    """

    gradients: NonNegative = 5.0
    """Weight of the response of the first frame's correlation filter, which never learns."""
    contrast: NonNegative = 5.0
    """Weight of the color contrast between the box and its surroundings, -1 to 1."""
    prior: float = -2.0
    """Log odds of a place of which no expert says anything."""

    def log_odds(self, gradients: float, contrast: float) -> float:
        """Return the log odds of a place with this response and this contrast."""
        loudest = min(gradients, LARGEST_VOICE)
        return self.prior + self.gradients * loudest + self.contrast * contrast


def probability(log_odds: float) -> float:
    """Return the probability of log odds, from 0 to 1."""
    return 1 / (1 + math.exp(-min(max(log_odds, -LARGEST_LOG_ODDS), LARGEST_LOG_ODDS)))
