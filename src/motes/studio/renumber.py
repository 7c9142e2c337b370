"""A document whose film is read otherwise than before: its frames have other numbers."""

from __future__ import annotations

import bisect
from collections.abc import Sequence

from msgspec.structs import replace

from motes.studio.document import Document


def renumbered(document: Document, before: Sequence[float], times: Sequence[float]) -> Document:
    """Return a document for a film that is read otherwise: each frame is the one nearest in time.

    Parameters
    ----------
    document
        What was drawn.
    before, times
        The times of the frames then, and those of now.
    """

    def place(frame: int) -> int:
        after = bisect.bisect_left(times, before[frame], hi=len(times) - 1)
        earlier = after > 0 and before[frame] - times[after - 1] < times[after] - before[frame]
        return after - earlier

    targets = (
        replace(
            each,
            first=place(each.first),
            last=place(each.last),
            keys={place(frame): region for frame, region in each.keys.items()},
            absent=tuple((place(first), place(last)) for first, last in each.absent),
        )
        for each in document.targets
    )
    return replace(document, targets=tuple(targets))
