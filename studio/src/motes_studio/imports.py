"""Tracks from files of other tools, as objects whose rows are known.

A file is read by a worker, as a film is: what it holds may need any memory and time. The server
gets no more than objects that a session may have.
"""

from __future__ import annotations

import dataclasses
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import msgspec
from msgspec.structs import replace

from motes import ConfigError, Ellipse, FormatError, MotesError, Status, Track
from motes.correction import check_keyframes
from motes.formats import LABEL, FilmFacts, Recording, parquet, registry
from motes.rows import FORMS, text_name
from motes_studio.commands import Region
from motes_studio.document import MAX_OBJECTS, Document, DrawnTarget, appended, ranges
from motes_studio.messages import OpenFilm
from motes_studio.tables import Table, digest, line, pack, table_of
from motes_studio.workplace import Workplace

ZIP = b"PK\x03\x04"
"""How a ZIP begins."""
FILES = 100_000
"""Files that a ZIP may hold."""
DEPTH = 8
"""Folders in folders that it may have."""
ROWS = 1_000_000
"""Frames that the objects of a file may have together."""
LONGEST = 100
"""Letters that a name may have."""
COLORS = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9", "#cc79a7", "#f0e442")
"""The palette of Okabe and Ito, whose colors color-blind readers can distinguish."""


class Taken(msgspec.Struct, frozen=True):
    """What a file has brought: its objects, numbered from 1, and their rows as `tables.pack`.

    A file of keyframes alone has no rows. `left_out` is what of the file is not here.
    """

    targets: list[DrawnTarget]
    rows: list[bytes]
    left_out: list[str]


def read_file(place: Workplace, path: str, form: str | None, film: OpenFilm, most: int) -> bytes:
    """Return the `Taken` of an uploaded file, in msgpack; a task.

    Its format is recognized unless given. What it holds may have `most` bytes once unpacked.

    Raises
    ------
    MotesError
        If it cannot be read, or has frames or more objects than a session may have.
    """
    given, times = Path(path), place.film.times
    files = [*map(text_name, place.film.files)]
    recorded, known = recording(given, form, film, files, most, place.check)
    place.check()
    targets, tables = taken(recorded, known, times)
    found = Taken(targets, [pack(table) for table in tables], [*recorded.left_out, *recorded.notes])
    return msgspec.msgpack.encode(found)


def arrived(document: Document, targets: Sequence[DrawnTarget]) -> Document:
    """Return the document with the objects of a file, which get the next numbers and colors.

    One without a name gets that of an object that is drawn.

    Raises
    ------
    ConfigError
        If there are too many.
    """
    for target in targets:
        number = document.following
        color = COLORS[(number - 1) % len(COLORS)]
        name = target.name or f"object {number}"
        document = appended(document, replace(target, object=number, name=name, color=color))
    return document


def recording(
    path: Path,
    form: str | None,
    film: OpenFilm,
    files: Sequence[str],
    most: int,
    check: Callable[[], None],
) -> tuple[Recording, str]:
    """Return the objects in a file, and its format, which is recognized unless given.

    The film may have the names of its images. A ZIP may hold a file or a folder of `most` bytes;
    `check` is called after each file that is unpacked.

    Raises
    ------
    MotesError
        If it cannot be read, or has frames that the film does not.
    """
    facts = FilmFacts(
        source=film.name, width=film.width, height=film.height, frames=film.frames, fps=film.fps,
        files=files,
    )  # fmt: skip
    name = path.name
    with tempfile.TemporaryDirectory() as folder:
        try:
            with path.open("rb") as file:
                zipped = file.read(len(ZIP)) == ZIP
            if zipped:
                path = _unpacked(path, Path(folder), most, check)
            form = form or registry.recognized(path)
            packed = form == "parquet" and path.is_file()
            if packed and (size := parquet.size(path)) > most:
                raise FormatError(
                    f"{name} holds {size >> 20} MB of rows, more than {most >> 20} MB; send less."
                )
            read = registry.read(path, form, facts)
            frames = [*read]  # only then all is known that is left out
            recorded = dataclasses.replace(read, frames=frames)
        except MotesError as error:
            said = str(error).replace(f"{folder}/", "").replace(f"{path.parent}/", "")
            raise FormatError(said) from None
    rows = recorded.frames
    if rows and rows[-1].frame >= film.frames:
        raise FormatError(
            f"{name} has frame {rows[-1].frame}, but {film.name} has {film.frames} frames; open "
            f"the film that it belongs to."
        )
    return recorded, form


def _unpacked(path: Path, folder: Path, most: int, check: Callable[[], None]) -> Path:
    """Unpack a ZIP into a folder; return that folder, or the only file or folder in it."""
    try:
        with zipfile.ZipFile(path) as archive:
            files = archive.infolist()
            if len(files) > FILES or sum(each.file_size for each in files) > most:
                raise FormatError(
                    f"{path.name} holds more than {FILES:,} files or {most >> 20} MB; send less."
                )
            if any(each.filename.count("/") > DEPTH for each in files):
                raise FormatError(f"{path.name} has folders in folders, too many; send the inner.")
            for each in files:
                archive.extract(each, folder / path.name)
                check()
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError):
        # RuntimeError: it has a password, or is compressed in another way.
        raise FormatError(f"{path.name} cannot be unpacked; make the ZIP anew.") from None
    path = folder / path.name
    while path.is_dir() and len(inside := [*path.iterdir()]) == 1:
        (path,) = inside
    return path


def taken(
    recorded: Recording, form: str, times: Sequence[float]
) -> tuple[list[DrawnTarget], list[Table]]:
    """Return the objects of a file, numbered from 1, and the rows of each.

    The first frame in which an object is visible is its keyframe; in formats of keyframes, all that
    a person has drawn are. A file of keyframes alone has no rows. The name of an object is its
    class, with its identity behind it where there are several; of one without either it is empty.

    Raises
    ------
    ConfigError
        If there is no object, or there are too many, or too many frames of them.
    FormatError
        If boxes have no identity, and there are several in a frame.
    """
    if form == "keyframes":
        return [_marked(recorded, times)], []
    found: dict[int, dict[int, Track]] = {}
    looked_at = {row.frame for row in recorded}
    for row in recorded:
        for each in row.objects:
            if row.frame in found.setdefault(each.identity, {}):
                raise FormatError(
                    f"Frame {row.frame} has several boxes without an identity, of which no track "
                    f"can be made; take a format with identities."
                )
            found[each.identity][row.frame] = each
    alone = len(found) == 1
    drawn = {
        identity: frames
        for identity, rows in sorted(found.items())
        if (frames := [frame for frame, each in rows.items() if each.visible])
    }
    if not drawn:
        raise ConfigError("The file has no object that is visible; choose another one.")
    if len(drawn) > MAX_OBJECTS:
        raise ConfigError(
            f"The file has {len(drawn):,} objects, and a session has {MAX_OBJECTS} at most; send "
            f"a part of it."
        )
    if sum(max(found[each]) - min(found[each]) + 1 for each in drawn) > ROWS:
        raise ConfigError(f"The file's objects have more than {ROWS:,} frames; send a part of it.")
    targets, tables = [], []
    own = form in (*FORMS.values(), "parquet")  # rows of motes, which have ellipses
    for number, (identity, frames) in enumerate(drawn.items(), start=1):
        rows = found[identity]
        some = not all(each.keyframe for each in rows.values())
        keys = [frame for frame in frames if rows[frame].keyframe] if some else frames[:1]
        places = {frame: rows[frame].ellipse for frame in keys}
        ellipse = own or identity in recorded.ellipses
        first, last = min(rows), max(rows)
        numbered = not alone and identity >= 0  # else it is a box without one
        behind = f" ({identity})" if numbered else ""
        label = rows[frames[0]].label or (LABEL if numbered else "")
        name = label[: LONGEST - len(behind)] + behind
        target = DrawnTarget(
            number, name, COLORS[0], "default", None, 0, first, last,
            keys=_drawn(places, ellipse=ellipse),
        )  # fmt: skip
        cues = len(target.tracker.cues)
        each_frame = (
            replace(rows[frame], time=times[frame])
            if frame in rows
            # Of a frame that the file does not have, nobody knows whether the object is there.
            else Track.nowhere(
                frame, times[frame], Status.ABSENT if frame in looked_at else Status.LOST
            )
            for frame in range(first, last + 1)
        )
        lines = [line(track, [0.0] * cues, final=True) for track in each_frame]
        tables.append(table_of(lines, cues))
        targets.append(replace(target, imported=digest(tables[-1])))
    return targets, tables


def _marked(recorded: Recording, times: Sequence[float]) -> DrawnTarget:
    """Return an object with the keyframes and absences of a file, in all frames of the film."""
    marks = {row.frame: row.objects[0].ellipse if row.objects else None for row in recorded}
    head, frames = recorded.head, range(len(times))
    check_keyframes(marks, head.source, frames, head.width, head.height)
    places = {frame: region for frame, region in marks.items() if region is not None}
    keys = _drawn(places, ellipse=bool(recorded.ellipses))
    absent = ranges(frame for frame, region in marks.items() if region is None)
    return DrawnTarget(1, "", COLORS[0], "default", None, 0, 0, frames[-1], absent, keys=keys)


def _drawn(places: Mapping[int, Ellipse], *, ellipse: bool) -> dict[int, Region]:
    """Return places as they were drawn: boxes, unless as an `ellipse`, or one is turned."""
    ellipse = ellipse or any(each.theta for each in places.values())
    return {frame: tuple(each if ellipse else each.box) for frame, each in places.items()}
