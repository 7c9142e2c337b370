"""The rows of passes and of stretches: those that are needed in memory, all on disk."""

from __future__ import annotations

from collections.abc import Container, Sequence

import numpy as np
from msgspec.structs import replace

from motes import ConfigError, Status, Track
from motes_studio.document import Document, DrawnTarget
from motes_studio.plan import PassNeed, StretchNeed, needs, own_frames
from motes_studio.store import Store
from motes_studio.tables import CUES, Table, digest, line, pack, table_of, without


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

    def carried(self, before: Document, after: Document, times: Sequence[float]) -> Document:
        """Return a changed document in which objects keep the rows that they have from files.

        A frame between objects that are joined has no place: nobody knows where it is.

        Raises
        ------
        ConfigError
            If not all rows of these objects are known.
        """
        old = [each for each in before.targets if each not in after.targets]
        if not any(each.imported for each in old):
            return after
        rows: dict[int, list[float]] = {}
        for each in reversed(old):  # where both have a frame, that of the first one stays
            table = self.of_object(replace(each, absent=()))
            table = self.of_object(each) if table is None else table
            if table is None:
                raise ConfigError(
                    f"{each.name} is not tracked to its end; track it first, so that rows of a "
                    f"file can stay."
                )
            rows.update(zip(each.frames, table[:, :CUES].tolist(), strict=True))
        return replace(after, targets=tuple(
            each if each in before.targets else self._with_rows(each, rows, times)
            for each in after.targets
        ))  # fmt: skip

    def _with_rows(
        self, target: DrawnTarget, rows: dict[int, list[float]], times: Sequence[float]
    ) -> DrawnTarget:
        cues = [0.0] * cues_of(target)
        for frame in {*target.frames} - rows.keys():
            rows[frame] = line(Track.nowhere(frame, times[frame], Status.LOST), [], final=True)
        table = table_of(([*rows[frame], *cues] for frame in target.frames), len(cues))
        target = replace(target, imported=digest(table))
        self.know(replace(target, absent=()), table)  # as it is without marks of absence
        self.know(target, without(table, target.absences))
        return target

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
