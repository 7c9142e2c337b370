"""What a session gives and takes as files, and what it answers about rows."""

from __future__ import annotations

import asyncio
import io
import shutil
import tempfile
from collections.abc import Callable
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import BinaryIO, NamedTuple

import msgspec

from motes import ConfigError, FormatError
from motes_studio import drawing, exports, imports
from motes_studio.commands import Number
from motes_studio.document import DrawnTarget, check_frame
from motes_studio.film_worker import EndedError
from motes_studio.messages import DoubtfulFrame, Overlay
from motes_studio.plan import pass_to
from motes_studio.results import cues_of
from motes_studio.sessions import LiveSession
from motes_studio.tables import Table, unpack, without
from motes_studio.tracking import find_doubts, look_at

HISTORY = "corrections"
"""The name of the export that `motes refine` needs beside the rows."""

MOST_DOUBTS = 100


class File(NamedTuple):
    """A file: its name, its content read from its begin and closed, and what is to be said."""

    name: str
    data: BinaryIO
    said: str = ""


class Question(msgspec.Struct, frozen=True):
    """What the address of a request about a session says; each question takes what it needs.

    The frame, the object (None for all), the size of a picture, how many are wanted, the format of
    a file, whether guesses are in it as if they were seen, and whether the many-object mode is
    meant.
    """

    index: Number = 0
    object: Number | None = None
    width: Number = 1280
    height: Number = 54
    count: Number = 20
    format: str = "csv"
    guesses: bool = False
    scene: str | None = None


class Imported(msgspec.Struct, frozen=True):
    """The numbers of the objects that a file has brought, and what of it was left out."""

    objects: list[int]
    left_out: list[str]


async def export(session: LiveSession, about: Question) -> File:
    """Return rows in a format: of one object, of all, or of the many-object mode.

    Of all objects, those are left out that have not been tracked to their ends.

    Raises
    ------
    MotesError
        If there are none, a run still makes them, or the format cannot hold them.
    """
    if about.scene is not None:
        return await _export_scene(session, about)
    film, form = session.facts, about.format
    if form == HISTORY:
        targets = _targets(session, about.object)
        if len(targets) > 1:
            raise ConfigError("Corrections are of one object; choose one.")
        stem = exports.file_name(film, targets[0].name, "csv")
        return File(f"{stem}.run.json", io.BytesIO(exports.history_file(targets[0], film)))
    tables = _tables(session, about.object)
    exports.check_formats(form, several=len(tables) > 1)
    named = {each.object: (each.name, table) for each, table in tables}
    what = "objects" if len(tables) > 1 else tables[0][0].name
    task = partial(exports.write_objects, form=form, film=film, tables=named, guesses=about.guesses)
    return await _made(session, exports.file_name(film, what, form), task)


async def _export_scene(session: LiveSession, about: Question) -> File:
    """Return the objects of the many-object mode in a format, or its events as JSON Lines."""
    film, job, form = session.facts, session.watching.job, about.format
    if job is not None and job.active:
        raise ConfigError("All that moves is being tracked; wait for the end, or stop the run.")
    if form == "events":
        events = sorted(session.watching.events(), key=itemgetter("frame"))  # as `motes watch`
        lines = (msgspec.json.encode(event) + b"\n" for event in events)
        return File(exports.file_name(film, "events", "jsonl"), io.BytesIO(b"".join(lines)))
    exports.check_formats(form, several=True)
    parts = session.watching.parts()
    task = partial(exports.write_scene, form=form, film=film, parts=parts, guesses=about.guesses)
    return await _made(session, exports.file_name(film, "watched", form), task)


async def _made(session: LiveSession, name: str, task: Callable[..., bytes]) -> File:
    """Return the file that a task has written, and the remark that the task returns."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "file"
        said = await session.work(partial(task, path=str(path)))
        return File(name, await asyncio.to_thread(_kept, path), said.decode())


def _kept(path: Path) -> BinaryIO:
    """Return a copy of a file that is gone as soon as it is closed."""
    kept = tempfile.TemporaryFile()  # noqa: SIM115  (who reads it closes it)
    with path.open("rb") as file:
        shutil.copyfileobj(file, kept, 1 << 20)
    kept.seek(0)
    return kept


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
    tables = {each.object: table for each, table in _tables(session, about.object)}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        task = partial(drawing.annotated, tables=tables, path=str(path))
        await session.ask(task, frames=session.facts.frames)
        stem = Path(session.facts.name).stem
        return File(f"{stem}-annotated.mp4", await asyncio.to_thread(_kept, path))


async def strip(session: LiveSession, about: Question) -> File:
    """Return thumbnails of the film side by side."""
    return File("strip.jpg", io.BytesIO(await session.strip(about.count, about.height)))


async def times(session: LiveSession, _: Question) -> list[float]:
    """Return the time of each frame; none if all are where the rate of the film has them."""
    fps = session.facts.fps
    uneven = any(abs(time * fps - index) > 0.5 for index, time in enumerate(session.times))
    return session.times if uneven else []


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
    check_frame(about.index, target.frames)
    run = pass_to(target, about.index)
    task = partial(look_at, number=target.object, run=run)
    data = await session.ask(task, frames=abs(run.stop - run.start))
    return msgspec.json.decode(data, type=Overlay)


async def take(session: LiveSession, path: Path, form: str | None, most: int) -> Imported:
    """Add the objects of a file, which may hold `most` bytes once unpacked."""
    task = partial(imports.read_file, path=str(path), form=form, film=session.facts, most=most)
    try:
        data = await session.work(task)
    except EndedError:
        raise FormatError(
            f"{path.name} needs more time or memory than a worker may have; send a part of it."
        ) from None
    found = msgspec.msgpack.decode(data, type=imports.Taken)
    before = session.document.following
    document = imports.arrived(session.document, found.targets)
    new = document.targets[len(document.targets) - len(found.targets) :]
    tables = {
        target.object: unpack(rows, cues_of(target))
        for target, rows in zip(new, found.rows, strict=False)  # keyframes alone have no rows
    }
    session.take_rows(document, tables)
    return Imported([*range(before, document.following)], found.left_out)


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


def _tables(session: LiveSession, number: int | None) -> list[tuple[DrawnTarget, Table]]:
    """Return the rows of an object as far as there are any; of all, those that are complete.

    Raises
    ------
    ConfigError
        If there are none, or a run still makes them.
    """
    targets = _targets(session, number)
    for each in targets:
        if session.jobs.runs(each.object):
            raise ConfigError(f"{each.name} is being tracked; wait for the end, or stop the run.")
    known = [(each, session.jobs.results.of_object(each)) for each in targets]
    if found := [(each, table) for each, table in known if table is not None]:
        return found
    if number is None:
        raise ConfigError("No object is tracked to its end; track one first.")
    (target,) = targets
    shown = session.board.rows(number, target.first, target.last)
    if not len(shown):
        raise ConfigError(f"{target.name} has no rows yet; track it first.")
    return [(target, without(shown, target.absences))]
