"""The news of the parts of a rig as they come to the program, and the numbers of identities."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from motes.cluster.handover_actor import ROOM
from motes.cluster.rig_messages import Associated, Batch, PartNews


class PartStream:
    """The news of a part that wait, and what the program holds for its handover actor.

    Attributes
    ----------
    news
        What has come and was not used.
    recorded, over
        Whether its cameras are recordings, and whether all have ended.
    count, state, entries
        As `HandoverActor.start` takes them.
    """

    def __init__(self, recorded: bool) -> None:
        self.news: deque[Any] = deque()
        self.recorded, self.over = recorded, False
        self.count = 0
        self.state: bytes | None = None
        self.entries: list[bytes] = []

    def hold(self, batch: Batch) -> None:
        """Keep the entries of a batch."""
        if batch.state is not None:
            self.state, self.entries = batch.state, []
        elif batch.count > self.count:
            self.entries.append(batch.entries)
        self.count = batch.count

    @property
    def has_room(self) -> bool:
        """Whether more may come: recordings that are ahead of others wait with their news."""
        return len(self.news) <= ROOM

    @property
    def blocks(self) -> bool:
        """Whether others must wait, since an earlier report may come."""
        return self.recorded and not self.over and not self.news

    def pop_urgent(self) -> PartNews | None:
        """Take the first news, unless it is a report of a recording; else return None."""
        first = self.news[0]
        if isinstance(first, Associated) and not first.live:
            return None
        return self.news.popleft()  # type: ignore[no-any-return]


class Numbers:
    """Numbers the identities of recordings in the order of their births, as one process does.

    Parts count on their own, and their numbers have gaps.
    """

    def __init__(self, step: int) -> None:
        self._step, self._names = step, dict[int, int]()
        self._newest = [n + 1 - step for n in range(step)]

    def of(self, part: int, news: Associated) -> dict[int, int]:
        """Return the identities of a report."""
        for number in range(self._newest[part] + self._step, news.newest + 1, self._step):
            self._names[number] = len(self._names) + 1
        self._newest[part] = max(self._newest[part], news.newest)
        return {own: self._names[number] for own, number in news.identities.items()}

    def named(self, merged: Mapping[int, int]) -> dict[int, int]:
        """Return the numbers of merged identities."""
        return {self._names[gone]: self._names[kept] for gone, kept in merged.items()}
