"""What a session gives and takes as files, and what it answers about rows."""

from __future__ import annotations

import asyncio
import tempfile
from functools import partial
from pathlib import Path
from typing import NamedTuple

import msgspec

from motes.core.errors import ConfigError
from motes.rows.schema import FORMS
from motes.studio import drawing, exports, imports
from motes.studio.commands import Number
from motes.studio.document import DrawnTarget
from motes.studio.messages import DoubtfulFrame, Overlay
from motes.studio.plan import pass_to
from motes.studio.sessions import LiveSession
from motes.studio.tables import Table, tracks
from motes.studio.tracking import find_doubts, look_at

HISTORY = "corrections"
"""The name of the export that `motes refine` needs beside the rows."""

MOST_DOUBTS = 100


class File(NamedTuple):
    """A file: its name, its content, and what of it is to be said."""

    name: str
    data: bytes
    said: str = ""


class Question(msgspec.Struct, frozen=True):
    """What the address of a request about a session says; each question takes what it needs.

    The frame, the object (None for all), the size of a picture, how many are wanted, the format of
    a file, and whether the many-object mode is meant.
    """

    index: Number = 0
    object: Number | None = None
    width: Number = 1280
    height: Number = 54
    count: Number = 20
    format: str = "csv"
    scene: str | None = None


class Imported(msgspec.Struct, frozen=True):
    """The numbers of the objects that a file has brought, and what of it was left out."""

    objects: list[int]
    left_out: list[str]


async def export(session: LiveSession, about: Question) -> File:
    """Return rows in a format: of one object, of all, or of the many-object mode.

    Raises
    ------
    MotesError
        If there are none, or the format cannot hold them.
    """
    if about.scene is not None:
        return await _export_scene(session, about.format)
    film, form = session.facts, about.format
    targets = _targets(session, about.object)
    if form == HISTORY:
        if len(targets) > 1:
            raise ConfigError("Corrections are of one object; choose one.")
        stem = exports.file_name(film, targets[0].name, "csv")
        return File(f"{stem}.run.json", exports.history_file(targets[0], film))
    exports.check_formats(form, several=len(targets) > 1)
    tables = {each.object: (each.name, _table(session, each)) for each in targets}

    def made() -> tuple[bytes, str]:
        found = {key: (name, tracks(table)) for key, (name, table) in tables.items()}
        if len(found) > 1:
            return exports.recorded_file(form, film, session.files, exports.objects_rows(found))
        ((name, only),) = found.values()
        rows, label = exports.target_rows(only), exports.class_of(name)
        return exports.recorded_file(form, film, session.files, rows, label)

    what = "objects" if len(targets) > 1 else targets[0].name
    return File(exports.file_name(film, what, form), *await asyncio.to_thread(made))


async def _export_scene(session: LiveSession, form: str) -> File:
    """Return the objects of the many-object mode in a format, or its events as JSON Lines."""
    film = session.facts
    if form == "events":
        lines = (msgspec.json.encode(event) + b"\n" for event in session.watching.events())
        return File(exports.file_name(film, "events", "jsonl"), b"".join(lines))
    exports.check_formats(form, several=True)
    frames = session.watching.frames()
    if form in FORMS.values():  # as `motes watch` writes them: a row for each object
        frames = [row for row in frames if row.objects]
    made = await asyncio.to_thread(exports.recorded_file, form, film, session.files, frames)
    return File(exports.file_name(film, "watched", form), *made)


async def command(session: LiveSession, about: Question) -> exports.Reproduction:
    """Return how an object is tracked again; without one, how all that moves is."""
    if about.object is not None:
        return exports.command_of(session.document.target(about.object), session.facts)
    asked = session.watching.asked
    if asked is None:
        raise ConfigError("Nothing was tracked yet; draw an object, or track all that moves.")
    return exports.watch_command(session.facts, *asked)


async def film(session: LiveSession, about: Question) -> File:
    """Return a film in which one object, or all are drawn."""
    targets = _targets(session, about.object)
    tables = {target.object: _table(session, target) for target in targets}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        task = partial(drawing.annotated, tables=tables, path=str(path))
        await session.ask(task, frames=session.facts.frames)
        stem = Path(session.facts.name).stem
        return File(f"{stem}-annotated.mp4", path.read_bytes())


async def strip(session: LiveSession, about: Question) -> File:
    """Return thumbnails of the film side by side."""
    return File("strip.jpg", await session.strip(about.count, about.height))


async def doubts(session: LiveSession, about: Question) -> list[DoubtfulFrame]:
    """Return doubtful frames of an object, in the order of `motes check`."""
    target = _target(session, about)
    rows = session.board.rows(target.object, target.first, target.last)
    if not len(rows):
        return []
    count = min(about.count, MOST_DOUBTS)
    task = partial(find_doubts, table=rows, marks=target.marks, count=count)
    return msgspec.json.decode(await session.ask(task), type=list[DoubtfulFrame])


async def overlay(session: LiveSession, about: Question) -> Overlay:
    """Return what the tracker of an object sees in a frame.

    A tracker starts at the nearest keyframe before the frame, or else after it, and goes there.
    """
    target = _target(session, about)
    session.check_frame(about.index)
    run = pass_to(target, about.index)
    task = partial(look_at, number=target.object, run=run)
    data = await session.ask(task, frames=abs(run.stop - run.start))
    return msgspec.json.decode(data, type=Overlay)


async def take(
    session: LiveSession, name: str, data: bytes, form: str | None, most: int
) -> Imported:
    """Add the objects of a file; a ZIP may hold `most` bytes."""
    recorded, known = await asyncio.to_thread(
        imports.recording, name, data, form, session.facts, session.files, most
    )
    before = session.document.following
    document, tables = imports.taken(
        session.document, recorded, known, session.times, Path(name).stem or "object"
    )
    session.take_rows(document, tables)
    numbers = [each.object for each in document.targets if each.object >= before]
    return Imported(numbers, [*recorded.left_out, *recorded.notes])


def _target(session: LiveSession, about: Question) -> DrawnTarget:
    if about.object is None:
        raise ConfigError("Name an object, as in ?object=1.")
    return session.document.target(about.object)


def _targets(session: LiveSession, number: int | None) -> list[DrawnTarget]:
    document = session.document
    if number is not None:
        return [document.target(number)]
    if not document.targets:
        raise ConfigError("There is no object; draw one first.")
    return [*document.targets]


def _table(session: LiveSession, target: DrawnTarget) -> Table:
    """Return the rows of an object: the result, or what there is of it so far."""
    final = session.jobs.results.of_object(target)
    if final is not None:
        return final
    shown = session.board.rows(target.object, target.first, target.last)
    if len(shown):
        return shown
    raise ConfigError(f"{target.name} has no rows yet; track it first.")
