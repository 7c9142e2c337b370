"""Tracks from files of other tools, as objects whose rows are known."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

from motes.core.errors import ConfigError, FormatError
from motes.core.track import Status
from motes.formats import registry
from motes.formats.recording import FilmFacts, Recording
from motes.formats.visibility import VISIBLE
from motes.rows.journal import ObjectRow
from motes.studio import messages
from motes.studio.document import Document, DrawnTarget
from motes.studio.document import appended as appended_to
from motes.studio.safety import plain_name
from motes.studio.tables import Table, line, table_of

COLORS = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9", "#cc79a7", "#f0e442")
"""The palette of Okabe and Ito, whose colors color-blind readers can distinguish."""


def recording(name: str, data: bytes, form: str | None, film: messages.OpenFilm) -> Recording:
    """Return the objects in an uploaded file, whose format is recognized unless it is given.

    Raises
    ------
    MotesError
        If it cannot be read, or has frames that the film does not.
    """
    facts = FilmFacts(
        source=film.name, width=film.width, height=film.height, frames=film.frames, fps=film.fps
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / plain_name(name)
        path.write_bytes(data)
        read = registry.read(path, form or registry.recognized(path), facts)
        recorded = Recording(read.head, [*read], [*read.left_out])  # also of what is read later
    rows = recorded.frames
    if rows and rows[-1].frame >= film.frames:
        raise FormatError(
            f"{name} has frame {rows[-1].frame}, but {film.name} has {film.frames} frames; open "
            f"the film that it belongs to."
        )
    head = recorded.head
    if head.width and (head.width, head.height) != (film.width, film.height):
        raise FormatError(
            f"{name} is of a film of {head.width}x{head.height} pixels; open that film."
        )
    return recorded


def taken(
    document: Document, recorded: Recording, times: Sequence[float], stem: str
) -> tuple[Document, dict[int, Table]]:
    """Return the document with the objects of a file, and their rows by their numbers.

    The first frame in which an object is visible is its keyframe; in formats of keyframes, all that
    a person has drawn are.

    Raises
    ------
    ConfigError
        If there is no object, or there are too many.
    """
    found: dict[int, dict[int, ObjectRow]] = {}
    for row in recorded:
        for each in row.objects:
            found.setdefault(each.identity, {})[row.frame] = each
    tables: dict[int, Table] = {}
    for identity, rows in sorted(found.items()):
        drawn = [frame for frame, each in rows.items() if each.status in VISIBLE]
        if not drawn:
            continue
        some = not all(each.keyframe for each in rows.values())
        keys = [frame for frame in drawn if rows[frame].keyframe] if some else drawn[:1]
        number = document.following
        first, last = min(rows), max(rows)
        target = DrawnTarget(
            number,
            (rows[drawn[0]].label or stem if len(found) == 1 else f"{stem} {identity}")[:100],
            COLORS[(number - 1) % len(COLORS)], "default", None, 0, first, last,
            {frame: tuple(rows[frame].ellipse) for frame in keys},
        )  # fmt: skip
        document = appended_to(document, target)
        cues, missing = len(target.tracker.cues), ObjectRow.nowhere(identity, Status.ABSENT)
        tables[number] = table_of(
            (
                line(rows.get(frame, missing).track(frame, times[frame]), [0.0] * cues, final=True)
                for frame in range(first, last + 1)
            ),
            cues,
        )
    if not tables:
        raise ConfigError("The file has no object that is visible; choose another one.")
    return document, tables
