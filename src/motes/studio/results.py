"""The rows of passes and of stretches: those that are needed in memory, all on disk."""

from __future__ import annotations

from collections.abc import Container

import numpy as np

from motes.studio.document import DrawnTarget
from motes.studio.plan import PassNeed, StretchNeed, needs, own_frames
from motes.studio.store import Store
from motes.studio.tables import CUES, Table, pack, unpack


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
        self._parts: dict[str, list[Table]] = {}
        self._finals: dict[str, Table] = {}

    def begin_pass(self, key: str) -> None:
        """Forget the rows of a pass, which begins anew."""
        self._parts[key] = []
        self._store.forget(self._session, key)

    def add_to_pass(self, key: str, data: bytes, table: Table) -> None:
        """Take further rows of a pass, in order of the pass."""
        self._parts[key].append(table)
        self._store.add_part(self._session, key, data)

    def set_stretch(self, key: str, data: bytes, target: DrawnTarget) -> None:
        """Take the rows of a stretch."""
        self._store.forget(self._session, key)
        self._store.add_part(self._session, key, data)
        self._finals[key] = unpack(data, cues_of(target))

    def of_object(self, target: DrawnTarget) -> Table | None:
        """Return the rows of all frames of an object; None unless it is tracked completely."""
        tables = []
        for need, first in own_frames(needs(target)):
            table = self.of_stretch(need.key, target)
            if table is None:
                return None
            tables.append(table[first - need.stretch.first :])
        return np.concatenate(tables)

    def know(self, target: DrawnTarget, table: Table) -> None:
        """Take the rows of all frames of an object, which need not be tracked then."""
        for need in needs(target):
            first, last = (frame - target.first for frame in need.stretch[:2])
            self._store.forget(self._session, need.key)
            self._store.add_part(self._session, need.key, pack(table[first : last + 1]))

    def of_stretch(self, key: str, target: DrawnTarget) -> Table | None:
        """Return the rows of a stretch; None if it has not been tracked."""
        if key not in self._finals:
            data = self._store.parts(self._session, key)
            if not data:
                return None
            self._finals[key] = unpack(data, cues_of(target))
        return self._finals[key]

    def of_pass(self, need: PassNeed, target: DrawnTarget) -> Table:
        """Return the rows of a pass so far, in order of the pass."""
        cues = cues_of(target)
        if need.key not in self._parts:
            data = self._store.parts(self._session, need.key)
            self._parts[need.key] = [unpack(data, cues)]
        parts = self._parts[need.key]
        if len(parts) != 1:
            parts[:] = [np.concatenate(parts) if parts else np.empty((0, CUES + cues))]
        return parts[0]

    def have(self, need: PassNeed, target: DrawnTarget) -> int:
        """Return how many frames of a pass there are."""
        if need.key not in self._parts:
            self.of_pass(need, target)
        return sum(map(len, self._parts[need.key]))

    def over(self, target: DrawnTarget, need: StretchNeed, each: PassNeed | None) -> Table | None:
        """Return the rows of a pass over a stretch, in order of the frames."""
        if each is None:
            return None
        table = self.of_pass(each, target)[: each.frames]
        return table[::-1] if each is need.backward else table

    def keep(self, used: Container[str]) -> None:
        """Keep in memory only what the document needs; all else is on disk."""
        for key in [*self._parts]:
            if key not in used:
                del self._parts[key]
        for key in [*self._finals]:
            if key not in used:
                del self._finals[key]
