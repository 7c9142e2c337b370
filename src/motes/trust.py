"""When to believe one's eyes: what a certainty from 0 to 1 allows a tracker to do.

The rule of being lost that `discriminative` follows, without any pictures.
"""

from __future__ import annotations

from typing import NamedTuple

from motes.config import Config, Count, Share
from motes.track import Status

CALM = 10
"""Frames from the start whose mean certainty is the reference."""


class Standing(NamedTuple):
    """How a tracker stands with its target.

    Attributes
    ----------
    status
        Where the tracker is.
    missed
        Frames since one that was certain while tracking.
    agreed
        Of a lost target: frames in a row that were certain.
    reference, seen
        Mean certainty of the first frames, and of how many.
    """

    status: Status = Status.TRACKING
    missed: int = 0
    agreed: int = 0
    reference: float = 0.0
    seen: int = 0


class Trust(Config, frozen=True):
    """How certain the tracker must be, from 0 to 1.

    Each holds for targets that are easily told from everything else; others ask for a share of
    the certainty that they had in the first frames.

    Attributes
    ----------
    learn
        To learn from a frame.
    keep
        Not to call the target lost, and to take up a lost one where it was.
    find
        To believe that it is somewhere else, where the search has led.
    follow
        To move with what is most like a lost target, so that it is not left behind where it merely
        looks different.
    frames
        A target is lost after so many frames in a row that are not certain enough to keep it, and
        found after as many that are.
    of_first, find_of_first
        See above, for `learn`, `keep` and `follow`, and for `find`.
    """

    learn: Share = 0.3
    keep: Share = 0.25
    find: Share = 0.33
    follow: Share = 0.2
    frames: Count = 3
    of_first: Share = 0.6
    find_of_first: Share = 0.8

    def learns(self, certainty: float, reference: float) -> bool:
        """Return whether a certainty is enough to learn."""
        return certainty >= min(self.learn, self.of_first * reference)

    def keeps(self, certainty: float, reference: float) -> bool:
        """Return whether it is enough to keep a target, or to take up a lost one where it was."""
        return certainty >= min(self.keep, self.of_first * reference)

    def follows(self, certainty: float, standing: Standing) -> bool:
        """Return whether a certainty is enough to move: any is before the target is called lost."""
        low = min(self.follow, self.of_first * standing.reference)
        return standing.status is Status.TRACKING or certainty >= low

    def finds(self, certainty: float, reference: float) -> bool:
        """Return whether it is enough to believe that a target is somewhere else."""
        return certainty >= min(self.find, self.find_of_first * reference)

    def judge(
        self, before: Standing, certainty: float, *, jumped: bool
    ) -> tuple[Standing, bool, bool]:
        """Return how a tracker stands after a frame, whether the target is there, and is learned.

        A target that was lost is tracked again after some frames in a row that agree, so that
        what is only like it is left before anything is learned from it.

        Parameters
        ----------
        certainty
            That the target is where it is now taken to be.
        jumped
            Whether the search has led there in this frame.
        """
        status, missed, agreed, reference, seen = before
        tracking = status is Status.TRACKING
        if tracking and seen < CALM:
            seen, reference = seen + 1, (reference * seen + certainty) / (seen + 1)
        there = (self.finds if jumped else self.keeps)(certainty, reference)
        if tracking:
            missed = 0 if there else missed + 1
            status = Status.TRACKING if missed < self.frames else Status.LOST
        else:
            agreed = (0 if jumped else agreed) + 1 if there else 0
            found = agreed >= self.frames
            missed = 0 if found else missed + 1
            status = Status.TRACKING if found else Status.SEARCHING
        if status is Status.TRACKING:
            agreed = 0
        learned = there and status is Status.TRACKING and self.learns(certainty, reference)
        return Standing(status, missed, agreed, reference, seen), there, learned
