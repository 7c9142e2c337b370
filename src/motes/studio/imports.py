"""Tracks from files of other tools, as objects whose rows are known."""

from __future__ import annotations

import io
import os
import tempfile
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from motes.core.errors import ConfigError, FormatError, MotesError
from motes.core.geometry import Ellipse
from motes.core.track import Status
from motes.correction.keyframes import check_keyframes
from motes.formats import registry
from motes.formats.aspects import COLUMNS
from motes.formats.recording import FilmFacts, Recording
from motes.formats.visibility import VISIBLE
from motes.rows.journal import ObjectRow
from motes.studio.commands import Region
from motes.studio.document import Document, DrawnTarget, ranges
from motes.studio.document import appended as appended_to
from motes.studio.messages import OpenFilm
from motes.studio.safety import plain_name
from motes.studio.tables import Table, line, table_of

ZIP = b"PK\x03\x04"
"""How a ZIP begins."""
FILES = 100_000
"""Files that a ZIP may hold."""
COLORS = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9", "#cc79a7", "#f0e442")
"""The palette of Okabe and Ito, whose colors color-blind readers can distinguish."""


def recording(
    name: str, data: bytes, form: str | None, film: OpenFilm, files: Sequence[str], most: int
) -> tuple[Recording, str]:
    """Return the objects in an uploaded file, and its format, which is recognized unless given.

    The film may have the names of its images. A ZIP may hold a file or a folder of `most` bytes.

    Raises
    ------
    MotesError
        If it cannot be read, or has frames that the film does not.
    """
    facts = FilmFacts(
        source=film.name, width=film.width, height=film.height, frames=film.frames, fps=film.fps,
        files=files,
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / plain_name(name)
        try:
            if data.startswith(ZIP):
                path = _unpacked(path, data, most)
            else:
                path.write_bytes(data)
            form = form or registry.recognized(path)
            read = registry.read(path, form, facts)
            recorded = Recording(read.head, [*read], [*read.left_out])  # also of what is read later
        except MotesError as error:
            raise FormatError(str(error).replace(f"{folder}{os.sep}", "")) from None
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
    return recorded, form


def _unpacked(path: Path, data: bytes, most: int) -> Path:
    """Unpack a ZIP into a folder; return that folder, or the only file or folder in it."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            files = archive.infolist()
            if len(files) > FILES or sum(each.file_size for each in files) > most:
                raise FormatError(
                    f"{path.name} holds more than {FILES:,} files or {most >> 20} MB; send less."
                )
            archive.extractall(path)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError):
        # RuntimeError: it has a password, or is compressed in another way.
        raise FormatError(f"{path.name} cannot be unpacked; make the ZIP anew.") from None
    while path.is_dir() and len(inside := [*path.iterdir()]) == 1:
        (path,) = inside
    return path


def taken(
    document: Document, recorded: Recording, form: str, times: Sequence[float], stem: str
) -> tuple[Document, dict[int, Table]]:
    """Return the document with the objects of a file, and their rows by their numbers.

    The first frame in which an object is visible is its keyframe; in formats of keyframes, all that
    a person has drawn are. A file of keyframes alone has no rows.

    Raises
    ------
    ConfigError
        If there is no object, or there are too many.
    FormatError
        If boxes have no identity, and there are several in a frame.
    """
    if form == "keyframes":
        return appended_to(document, _marked(document.following, recorded, times, stem)), {}
    found: dict[int, dict[int, ObjectRow]] = {}
    for row in recorded:
        for each in row.objects:
            if row.frame in found.setdefault(each.identity, {}):
                raise FormatError(
                    f"Frame {row.frame} has several boxes without an identity, of which no track "
                    f"can be made; take a format with identities."
                )
            found[each.identity][row.frame] = each
    tables: dict[int, Table] = {}
    own = COLUMNS in registry.FORMATS.resolve(form).holds  # rows of motes, which have ellipses
    for identity, rows in sorted(found.items()):
        drawn = [frame for frame, each in rows.items() if each.status in VISIBLE]
        if not drawn:
            continue
        some = not all(each.keyframe for each in rows.values())
        keys = [frame for frame in drawn if rows[frame].keyframe] if some else drawn[:1]
        places = {frame: rows[frame].ellipse for frame in keys}
        number = document.following
        first, last = min(rows), max(rows)
        target = DrawnTarget(
            number,
            (rows[drawn[0]].label or stem if len(found) == 1 else f"{stem} {identity}")[:100],
            COLORS[(number - 1) % len(COLORS)], "default", None, 0, first, last,
            keys={frame: tuple(each) for frame, each in places.items()} if own else _drawn(places),
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


def _marked(number: int, recorded: Recording, times: Sequence[float], stem: str) -> DrawnTarget:
    """Return an object with the keyframes and absences of a file, in all frames of the film."""
    marks = {row.frame: row.objects[0].ellipse if row.objects else None for row in recorded}
    head, frames = recorded.head, range(len(times))
    check_keyframes(marks, head.source, frames, head.width, head.height)
    keys = _drawn({frame: region for frame, region in marks.items() if region is not None})
    absent = ranges(frame for frame, region in marks.items() if region is None)
    name, color = stem[:100], COLORS[(number - 1) % len(COLORS)]
    return DrawnTarget(number, name, color, "default", None, 0, 0, frames[-1], absent, keys=keys)


def _drawn(places: Mapping[int, Ellipse]) -> dict[int, Region]:
    """Return places as they were drawn: boxes where no ellipse is turned."""
    boxed = not any(each.theta for each in places.values())
    return {frame: tuple(each.box if boxed else each) for frame, each in places.items()}
