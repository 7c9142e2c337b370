"""The files of a session, to the byte as the command line writes them; and its command line."""

from __future__ import annotations

import os
import re
import shlex
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import msgspec
from msgspec.structs import replace

from motes import ConfigError, FormatError, Status, Track
from motes.core import counted
from motes.correction import History
from motes.formats import LABEL, Recording, registry
from motes.rows import FORMS, FrameRow, Header, text_name
from motes_studio.commands import Places, Watch
from motes_studio.document import DrawnTarget, places_toml
from motes_studio.messages import OpenFilm
from motes_studio.scenes import ScenePart, config_of
from motes_studio.tables import Table, tracks as tracks_of
from motes_studio.workplace import Workplace

DEFAULT_NAME = re.compile(r"object \d+", re.IGNORECASE)
"""The name that the studio gives to an object."""
NUMBERED = re.compile(r"( \(\d+\))+$")
"""What it adds to the name of an object that is split, or one of several in a file."""
FROM_FILE = "Rows of this object are from a file; this command tracks it between its keyframes."


class Reproduction(msgspec.Struct, frozen=True):
    """How a run is repeated."""

    command: str
    files: dict[str, str]
    """The files that it names; and the whole configuration, in `tracker.toml` or `watch.toml`."""
    note: str = ""
    """In what the rows on the page are others; empty if they are the same."""


def class_of(name: str) -> str:
    """Return the class of an object: the name that a user or a file has given it, else `LABEL`."""
    given = NUMBERED.sub("", " ".join("".join(filter(str.isprintable, name)).split()))
    return LABEL if not given or DEFAULT_NAME.fullmatch(given) else given


def target_rows(tracks: Sequence[Track]) -> list[FrameRow]:
    """Return the rows of one object, as `motes track --at ... -o` writes them."""
    return [FrameRow(track.frame, track.time, (replace(track, smoothed=True),)) for track in tracks]


def objects_rows(found: Mapping[int, tuple[str, Sequence[Track]]]) -> list[FrameRow]:
    """Return the rows of several objects, with their numbers as identities, and their classes."""
    frames: dict[int, tuple[float, list[Track]]] = {}
    for number, (name, tracks) in found.items():
        label = None if class_of(name) == LABEL else class_of(name)
        for track in tracks:
            _, objects = frames.setdefault(track.frame, (track.time, []))
            if track.status is not Status.ABSENT:
                objects.append(replace(track, identity=number, label=label))
    return [FrameRow(frame, time, tuple(each)) for frame, (time, each) in sorted(frames.items())]


def write_objects(
    place: Workplace,
    path: str,
    form: str,
    film: OpenFilm,
    tables: Mapping[int, tuple[str, Table]],
    *,
    guesses: bool = False,
) -> bytes:
    """Write the objects with these names and rows as a file of a format; a task.

    Guesses are written as if they were seen if `guesses`.

    Raises
    ------
    ConfigError
        For an unknown format.
    FormatError
        If the format cannot hold them.
    """
    found = {number: (name, tracks_of(table)) for number, (name, table) in tables.items()}
    if len(found) > 1:
        return _write(place, path, form, film, objects_rows(found), guesses=guesses)
    ((name, only),) = found.values()
    return _write(place, path, form, film, target_rows(only), class_of(name), guesses=guesses)


def write_scene(
    place: Workplace,
    path: str,
    form: str,
    film: OpenFilm,
    parts: Sequence[bytes],
    *,
    guesses: bool = False,
) -> bytes:
    """Write the frames of the many-object mode as a file of a format; a task. As `write_objects`.

    The parts are the JSON of `ScenePart`s.
    """
    found = (msgspec.json.decode(part, type=ScenePart) for part in parts)
    frames = [FrameRow.from_dict(row) for part in found for row in part.frames]
    if form in FORMS.values():  # as `motes watch` writes them: a row for each object
        frames = [row for row in frames if row.objects]
    return _write(place, path, form, film, frames, guesses=guesses)


class _Signs(list[FrameRow]):
    """Frames whose reader gives signs of life."""

    def __init__(self, rows: Sequence[FrameRow], check: Callable[[], None]) -> None:
        super().__init__(rows)
        self._check = check

    def __iter__(self) -> Iterator[FrameRow]:
        for row in super().__iter__():
            self._check()
            yield row


def _write(
    place: Workplace,
    path: str,
    form: str,
    film: OpenFilm,
    rows: Sequence[FrameRow],
    label: str = LABEL,
    *,
    guesses: bool,
) -> bytes:
    """Write objects in a format of `motes convert`; a format of many files as ZIP.

    `label` is the class of objects without one.
    """
    known, files = registry.FORMATS.resolve(form), [*map(text_name, place.film.files)]
    if files:
        rows = [replace(row, file=files[row.frame]) for row in rows]
    signs = _Signs(rows, place.check)
    length = film.frames if known.thinned else 0  # tools go on after the last keyframe
    head = Header(film.name, film.width, film.height, label)
    recording = Recording(head, signs, length=length)
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "file" if known.folder else Path(path)
        try:
            written = registry.write(made, form, recording, guesses=guesses)
            said = _told(written, form, recording)
            if known.folder:
                _zip(made, path)
        except OSError as error:
            raise FormatError(f"{form} cannot be written: {error.strerror}.") from None
    return said.encode()


def _told(written: registry.Written, form: str, recording: Recording) -> str:
    """Return what of the rows a file has not, or has as something else, and what its tool needs."""
    missed, unknown = counted(written.missed, "frame"), counted(written.unknown, "frame")
    parts = [
        f"without {missed} in which a target is {written.missed_told}" * bool(written.missed),
        written.guesses_told,
        f"called absent: {unknown} without a row" * bool(written.unknown),
        registry.frames_told(form, recording).rstrip("."),
    ]
    return "; ".join(filter(None, parts))


def _zip(folder: Path, path: str) -> None:
    """Write the files of a folder as ZIP; equal files give equal bytes."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for each in sorted(folder.rglob("*")):
            if each.is_file():
                name = each.relative_to(folder).as_posix()
                archive.writestr(zipfile.ZipInfo(name), each.read_bytes())


def file_name(film: OpenFilm, what: str, form: str) -> str:
    """Return the name of a file of a format."""
    known = registry.FORMATS.resolve(form)
    ending = known.endings[0] if known.endings else f".{form}"
    ending = f"-{form}.zip" if known.folder else ending
    stem = os.path.splitext(os.path.basename(film.name))[0]
    plain = "".join(each if each.isalnum() or each in "-_" else "_" for each in what)
    return f"{stem}-{plain}{ending}"


def history_file(target: DrawnTarget, film: OpenFilm) -> bytes:
    """Return the history beside rows, from which `motes refine` goes on."""
    end = target.last + 1
    history = History(
        film=os.path.basename(film.name), width=film.width, height=film.height,
        frames=end, start=target.first, end=end, preset=target.preset,
        config=target.tracker.to_dict(), seed=target.seed,
    )  # fmt: skip
    return history.corrected([*target.marks.items()]).encoded()


def command_of(target: DrawnTarget, film: OpenFilm) -> Reproduction:
    """Return the command line that tracks an object again; all that motes tracked to the byte."""
    words = ["motes", "track", film.name]
    if target.first:
        words += ["--start", str(target.first)]
    if target.last + 1 < film.frames:
        words += ["--end", str(target.last + 1)]
    for frame, region in target.keys.items():
        words += ["--at", f"{frame}={','.join(map(exact, region))}"]
    for first, last in target.absent:
        words += ["--absent", f"{first}:{last}" if last > first else str(first)]
    words += ["--preset", target.preset]
    files = {"tracker.toml": target.tracker.to_toml()}
    if target.config is not None:
        words += ["--config", "motes.toml"]
        files["motes.toml"] = target.config
    words += ["--seed", str(target.seed), "-o", "rows.csv"]
    return Reproduction(shlex.join(words), files, FROM_FILE * bool(target.imported))


def watch_command(film: OpenFilm, watch: Watch, places: Places) -> Reproduction:
    """Return the command line that tracks all that moves again."""
    words = ["motes", "watch", film.name, "--detector", watch.detector, "--preset", watch.preset]
    files = {"watch.toml": config_of(watch).to_toml()}
    if watch.config is not None:
        words += ["--config", "motes.toml"]
        files["motes.toml"] = watch.config
    if places != Places():
        words += ["--places", "places.toml"]
        files["places.toml"] = places_toml(places)
    words += ["--seed", str(watch.seed), "-o", "rows.csv", "--events", "events.jsonl"]
    return Reproduction(shlex.join(words), files)


def exact(value: float) -> str:
    """Return a number as text that gives the same number."""
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def check_formats(form: str, *, several: bool) -> None:
    """Raise a ConfigError unless a format can be written, for several objects if need be."""
    known = registry.FORMATS.resolve(form)
    if known.write is None:
        raise ConfigError(f"Files of the format {form} cannot be written; choose another one.")
    if several and known.single:
        raise ConfigError(f"{form} holds one object; choose one, or another format.")
