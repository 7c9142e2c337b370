"""Whether the target is tracked, lost or searched for.

The rules read log odds only, no pixels. At log odds of 0 the target is as likely there as not, and
the confidence is one half.
"""

from __future__ import annotations

from typing import NamedTuple, Self

from motes.core.track import Status

FRAMES = 3
"""A target is lost after this many frames in a row that speak against it, and found after as many
that speak for it: single frames are blurred, or wrong by chance."""


class Standing(NamedTuple):
    """The status of a target, and the counts that it follows from."""

    status: Status = Status.TRACKING
    """The status that the track reports."""
    missed: int = 0
    """Number of frames since the target was last believed to be there."""
    confirmed: int = 0
    """Number of frames in a row that speak for the target."""
    contradicted: int = 0
    """Number of frames in a row that contradict the status."""

    @property
    def trusted(self) -> bool:
        """Whether the target was believed to be there in one of the last frames."""
        return self.missed < FRAMES

    def after(self, evidence: float, *, jumped: bool) -> Self:
        """Return the status after a frame.

        A lost target is believed in only after some frames in a row. So the tracker learns nothing
        from an object that is only similar. `evidence` is the log odds that the target is at the
        estimate, or another number of their sign; it has `jumped` if the search has found this
        place in this frame.
        """
        there, tracking = evidence > 0, self.status is Status.TRACKING
        confirmed, contradicted = (0, 0) if jumped else (self.confirmed, self.contradicted)
        confirmed = confirmed + 1 if there else 0
        contradicted = contradicted + 1 if there is not tracking else 0
        believed = there and (self.trusted or confirmed >= FRAMES)
        status = self.status if tracking else Status.SEARCHING
        if contradicted == FRAMES:
            contradicted, status = 0, Status.LOST if tracking else Status.TRACKING
        missed = 0 if believed else self.missed + 1
        return type(self)(status, missed, confirmed, contradicted)
