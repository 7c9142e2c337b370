"""The rows of passes and of stretches: those that are needed in memory, all on disk."""

from __future__ import annotations

from collections.abc import Container

import numpy as np

from motes_studio.document import DrawnTarget
from motes_studio.plan import PassNeed, StretchNeed, needs, own_frames
from motes_studio.store import Store
from motes_studio.tables import CUES, Table, pack


def cues_of(target: DrawnTarget) -> int:
    """Return the number of cues of an object's tracker."""
    return len(target.tracker.cues)


class Results:
    """What has been computed in a session.

    Parameters
    ----------
    session, store
        Where it is kept.
    """

    def __init__(self, session: str, store: Store) -> None:
        self._session, self._store = session, store
        self._tables: dict[str, Table] = {}

    def put(self, key: str, table: Table) -> None:
        """Take all rows of a pass or of a stretch."""
        self._store.replace_parts(self._session, key, pack(table))
        self._tables[key] = table

    def get(self, key: str, target: DrawnTarget) -> Table | None:
        """Return the rows of a pass or of a stretch; None if it has not been tracked."""
        if key not in self._tables:
            data = self._store.parts(self._session, key)
            if not data:
                return None
            self._tables[key] = np.frombuffer(data).reshape(-1, CUES + cues_of(target))
        return self._tables[key]

    def of_object(self, target: DrawnTarget) -> Table | None:
        """Return the rows of all frames of an object; None unless it is tracked completely."""
        tables = []
        for need, first in own_frames(needs(target)):
            table = self.get(need.key, target)
            if table is None:
                return None
            tables.append(table[first - need.stretch.first :])
        return np.concatenate(tables)

    def know(self, target: DrawnTarget, table: Table) -> None:
        """Take the rows of all frames of an object, which need not be tracked then."""
        for need in needs(target):
            first, last = (frame - target.first for frame in need.stretch[:2])
            self.put(need.key, table[first : last + 1])

    def of_pass(self, need: PassNeed | None, target: DrawnTarget) -> Table | None:
        """Return the rows of a pass, in order of the frames; None unless all have been made."""
        table = None if need is None else self.get(need.key, target)
        if need is None or table is None or len(table) < need.frames:
            return None
        table = table[: need.frames]
        return table[::-1] if need.task.stop < need.task.start else table

    def missing(self, need: StretchNeed, target: DrawnTarget) -> list[PassNeed]:
        """Return the passes over a stretch that have not been made."""
        return [each for each in need.passes if self.of_pass(each, target) is None]

    def keep(self, used: Container[str]) -> None:
        """Keep in memory only what the document needs; all else is on disk."""
        self._tables = {key: table for key, table in self._tables.items() if key in used}
