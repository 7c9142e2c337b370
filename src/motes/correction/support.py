"""Which of two passes follows the target in each frame: a hidden Markov model.

Each pass is on the target or off it, so there are four states: neither, forward only, backward
only, both. A pass is on at its own keyframe; it may leave the target and find it again. What is
observed is whether both agree, how confident each is, and whether a pass meets the keyframe at its
end. The probabilities of the states follow by the forward-backward algorithm (Rabiner, A tutorial
on hidden Markov models, Proceedings of the IEEE 1989).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motes.core.types import Flags, Floats

LEAVES = 0.01
"""Probability that a pass leaves its target from one frame to the next."""
FINDS = 0.02
"""Probability that it finds the target again."""
AGREE = 0.95
"""Probability that two passes on the target overlap by more than half; if one is off it, they do so
with 1 minus this."""
INDEPENDENT = 10
"""Confidences of this many frames in a row tell as much as one: neighbors err alike."""
SUREST = 0.95
"""A confidence counts as this at most, and as 1 minus this at least."""
ON = np.array([[False, True, False, True], [False, False, True, True]])
"""Whether forward and backward pass are on the target, in each of the four states."""


class Support(NamedTuple):
    """What supports the track."""

    used: Flags
    """(m, n), whether each pass is used; of two, in the likeliest state."""
    probability: Floats
    """(n,), the probability that a pass that is used is on the target."""


def support(
    confidence: Floats, agree: Flags, meets: tuple[bool | None, bool], absent: Flags
) -> Support:
    """Return which of two passes follow the target, each from its keyframe at one end.

    The confidence (2, n) is that of the forward and of the backward pass; they agree (n,) where
    they overlap by more than half. `meets` is whether the forward pass meets the last keyframe, and
    the backward pass the first one; None without a last keyframe: the backward pass began where the
    forward one had ended.
    """
    sure = np.clip(confidence, 1 - SUREST, SUREST)
    odds = np.log(sure / (1 - sure)) / INDEPENDENT
    log = np.where(ON[:, None, :], odds[:, :, None] / 2, -odds[:, :, None] / 2).sum(axis=0)
    expected = np.where(agree, AGREE, 1 - AGREE)[:, None]
    log += np.log(np.where(ON.all(axis=0), expected, 1 - expected))
    for i, (met, frame) in enumerate(zip(meets, (-1, 0), strict=True)):
        if met is not None:
            log[frame] += np.log(np.where(ON[i] == met, AGREE, 1 - AGREE))
    likelihood = np.exp(log - log.max(axis=1, keepdims=True))
    likelihood[np.ix_(absent, ON.any(axis=0))] = 0

    stay = np.array([[1 - FINDS, FINDS], [LEAVES, 1 - LEAVES]])
    transition = np.kron(stay, stay)  # of the states in the order of `ON`
    ahead, behind = np.empty_like(likelihood), np.empty_like(likelihood)
    ahead[0] = _normalized(ON[0] * likelihood[0])
    for t in range(1, len(ahead)):
        ahead[t] = _normalized((ahead[t - 1] @ transition) * likelihood[t])
    behind[-1] = ON[1] if meets[0] is not None else ON[0] == ON[1]
    for t in range(len(behind) - 2, -1, -1):
        behind[t] = _normalized(transition @ (likelihood[t + 1] * behind[t + 1]))
    posterior = ahead * behind
    posterior /= posterior.sum(axis=1, keepdims=True)
    used: Flags = ON[:, posterior.argmax(axis=1)]
    held = (ON[:, None, :] & used[:, :, None]).any(axis=0)
    return Support(used, (posterior * held).sum(axis=1))


def _normalized(weights: Floats) -> Floats:
    out: Floats = weights / weights.sum()
    return out
