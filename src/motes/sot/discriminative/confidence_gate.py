"""What a certainty from 0 to 1 allows the default tracker to do: learn, stay, move, or be found.

The rules here read numbers only, no pixels.
"""

from __future__ import annotations

from typing import NamedTuple

from motes.core.config import Config, Count, Share
from motes.core.track import Status

REFERENCE_FRAMES = 10
"""The mean certainty of this many frames, from the start, is the reference."""


class TargetStatus(NamedTuple):
    """The status of a target, and the counts that it follows from.

    Attributes
    ----------
    status
        The status that the track reports.
    frames_missed
        Number of frames since the target was last accepted as present.
    confirmations
        Number of frames in a row that were certain.
    contradictions
        Number of frames in a row that contradict the status.
    reference, seen
        Mean certainty of the first frames, and the number of these frames.
    """

    status: Status = Status.TRACKING
    frames_missed: int = 0
    confirmations: int = 0
    contradictions: int = 0
    reference: float = 0.0
    seen: int = 0


class ConfidenceGate(Config, frozen=True):
    """How certain the tracker must be for each action, from 0 to 1.

    These thresholds hold for targets that differ clearly from their surroundings. For other targets
    a threshold is lower: a share of the mean certainty in the first frames.

    Attributes
    ----------
    learn
        Certainty to learn from a frame.
    keep
        Certainty to keep the target where it is: it is not searched for elsewhere, nor lost.
    respond
        Response of the learned filter that also keeps the target, if the certainty is at least half
        of `keep`: a target may differ from the first frame and still look as it did lately.
    find
        Certainty to accept that the target is where the search has led.
    follow
        Certainty to move a lost target to the most similar place. The target may only look
        different for a while, and must not be left behind.
    frames
        A target is lost after this many frames in a row below `keep`. It is found after as many
        frames in a row above it.
    relative_to_start
        Share of the certainty in the first frames that is enough for `learn`, `keep` and `follow`.
    find_relative_to_start
        Share of the certainty in the first frames that is enough for `find`. With a larger value,
        fewer places are accepted.
    """

    learn: Share = 0.33
    keep: Share = 0.275
    respond: Share = 0.16
    find: Share = 0.36
    follow: Share = 0.22
    frames: Count = 3
    relative_to_start: Share = 0.6
    find_relative_to_start: Share = 0.8

    def may_update(self, certainty: float, reference: float) -> bool:
        """Return whether a certainty is enough to learn from the frame."""
        return certainty >= min(self.learn, self.relative_to_start * reference)

    def is_present(self, certainty: float, reference: float) -> bool:
        """Return whether a certainty is enough to keep a target where it is."""
        return certainty >= min(self.keep, self.relative_to_start * reference)

    def was_present(self, standing: TargetStatus) -> bool:
        """Return whether the target was present in one of the last frames."""
        return standing.frames_missed < self.frames

    def may_move(self, certainty: float, standing: TargetStatus) -> bool:
        """Return whether a certainty is enough to move; in the first missed frames, any is."""
        low = min(self.follow, self.relative_to_start * standing.reference)
        return self.was_present(standing) or certainty >= low

    def accepts_redetection(self, certainty: float, reference: float) -> bool:
        """Return whether a certainty is enough to accept a place that the search has found."""
        return certainty >= min(self.find, self.find_relative_to_start * reference)

    def update(
        self, before: TargetStatus, certainty: float, response: float, *, jumped: bool
    ) -> tuple[TargetStatus, bool, bool]:
        """Return the status after a frame, whether the target is present, and whether to learn.

        A missed target is accepted as present only after `frames` certain frames in a row. So the
        tracker learns nothing from an object that is only similar.

        Parameters
        ----------
        before
            The status after the last frame.
        certainty
            Certainty that the target is at the estimate.
        response
            Response of the learned filter at the estimate.
        jumped
            Whether the search has found this place in this frame.
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
