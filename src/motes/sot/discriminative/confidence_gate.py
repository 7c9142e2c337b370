"""When to believe one's eyes: what a certainty from 0 to 1 allows a tracker to do.

The rule of being lost that `discriminative` follows, without any pictures.
"""

from __future__ import annotations

from typing import NamedTuple

from motes.core.config import Config, Count, Share
from motes.core.track import Status

REFERENCE_FRAMES = 10
"""Frames from the start whose mean certainty is the reference."""


class TargetStatus(NamedTuple):
    """How a tracker stands with its target.

    Attributes
    ----------
    status
        Where the tracker is.
    frames_missed
        Frames since one in which it was believed to be there.
    confirmations
        Frames in a row that were certain.
    contradictions
        Frames in a row that speak against the status.
    reference, seen
        Mean certainty of the first frames, and of how many.
    """

    status: Status = Status.TRACKING
    frames_missed: int = 0
    confirmations: int = 0
    contradictions: int = 0
    reference: float = 0.0
    seen: int = 0


class ConfidenceGate(Config, frozen=True):
    """How certain the tracker must be, from 0 to 1.

    Each holds for targets that are easily told from everything else; others ask for a share of
    the certainty that they had in the first frames.

    Attributes
    ----------
    learn
        To learn from a frame.
    keep
        Not to look for the target elsewhere, and not to call it lost.
    respond
        Nor is it called lost at half that certainty if the learned filter responds so much: a
        target that looks unlike itself at first may still be as it was of late.
    find
        To believe that it is somewhere else, where the search has led.
    follow
        To move with what is most like a lost target, so that it is not left behind where it merely
        looks different.
    frames
        A target is lost after so many frames in a row that do not keep it, and found after as many
        that do.
    relative_to_start, find_relative_to_start
        See above, for `learn`, `keep` and `follow`, and for `find`.
    """

    learn: Share = 0.3
    keep: Share = 0.25
    respond: Share = 0.16
    find: Share = 0.33
    follow: Share = 0.2
    frames: Count = 3
    relative_to_start: Share = 0.6
    find_relative_to_start: Share = 0.8

    def may_update(self, certainty: float, reference: float) -> bool:
        """Return whether a certainty is enough to learn."""
        return certainty >= min(self.learn, self.relative_to_start * reference)

    def is_present(self, certainty: float, reference: float) -> bool:
        """Return whether it is enough to keep a target where it is, and not to search for it."""
        return certainty >= min(self.keep, self.relative_to_start * reference)

    def was_present(self, standing: TargetStatus) -> bool:
        """Return whether the target was believed to be there of late."""
        return standing.frames_missed < self.frames

    def may_move(self, certainty: float, standing: TargetStatus) -> bool:
        """Return whether a certainty is enough to move: any is in the first frames of doubt."""
        low = min(self.follow, self.relative_to_start * standing.reference)
        return self.was_present(standing) or certainty >= low

    def accepts_redetection(self, certainty: float, reference: float) -> bool:
        """Return whether it is enough to believe that a target is somewhere else."""
        return certainty >= min(self.find, self.find_relative_to_start * reference)

    def update(
        self, before: TargetStatus, certainty: float, response: float, *, jumped: bool
    ) -> tuple[TargetStatus, bool, bool]:
        """Return how a tracker stands after a frame, whether the target is there, and is learned.

        A target that was missed for some frames is believed to be there after as many in a row that
        agree, so that what is only like it is left before anything is learned from it.

        Parameters
        ----------
        certainty
            That the target is where it is now taken to be.
        response
            Of the learned filter there.
        jumped
            Whether the search has led there in this frame.
        """
        status, missed, agreed, against, reference, seen = before
        trusted, tracking = self.was_present(before), status is Status.TRACKING
        if trusted and seen < REFERENCE_FRAMES:
            seen, reference = seen + 1, (reference * seen + certainty) / (seen + 1)
        there = (self.accepts_redetection if jumped else self.is_present)(certainty, reference)
        responds = response >= self.respond and self.is_present(2 * certainty, reference)
        kept = there or (responds and not jumped)
        if jumped:
            agreed = against = 0
        agreed = agreed + 1 if there else 0
        against = against + 1 if kept is not tracking else 0
        believed = there and (trusted or agreed >= self.frames)
        missed = 0 if believed else missed + 1
        if against == self.frames:
            against, status = 0, Status.LOST if tracking else Status.TRACKING
        elif not tracking:
            status = Status.SEARCHING
        learned = believed and self.may_update(certainty, reference)
        return TargetStatus(status, missed, agreed, against, reference, seen), there, learned
