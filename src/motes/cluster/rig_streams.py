"""The news of groups of cameras as they come to the program, and the numbers of identities."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from typing import Any

from motes.cluster.rig_messages import Associated, Batch, GroupNews

ROOM = 1000
"""Number of reports of a group that may wait in the program."""


class GroupStream:
    """The news of a group that wait, and what the program holds for its handover actor.

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

    def pop_urgent(self) -> GroupNews | None:
        """Take the first news, unless it is a report of a recording; else return None."""
        first = self.news[0]
        if isinstance(first, Associated) and not first.live:
            return None
        return self.news.popleft()  # type: ignore[no-any-return]


class Numbers:
    """Numbers the identities of all groups in the order of their births, as one process does.

    Each group counts on its own, from 1.

    Parameters
    ----------
    groups
        The number of groups.
    """

    def __init__(self, groups: int) -> None:
        self._names = [dict[int, int]() for _ in range(groups)]
        self._newest = 0

    def of(self, group: int, news: Associated) -> dict[int, int]:
        """Return the identities in the rig of the objects of a report."""
        names = self._names[group]
        for number in range(len(names) + 1, news.newest + 1):
            self._newest += 1
            names[number] = self._newest
        return {own: names[number] for own, number in news.identities.items()}

    def named(self, group: int, merged: Mapping[int, int]) -> dict[int, int]:
        """Return the numbers in the rig of a group's merged identities."""
        names = self._names[group]
        return {names[gone]: names[kept] for gone, kept in merged.items()}
