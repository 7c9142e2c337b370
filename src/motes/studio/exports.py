"""The files of a session, to the byte as the command line writes them; and its command line."""

from __future__ import annotations

import io
import os
import re
import shlex
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec
from msgspec.structs import replace

from motes.core.config import to_dict, to_toml
from motes.core.errors import ConfigError, FormatError
from motes.core.track import Status, Track
from motes.correction.history import FORMAT, History
from motes.formats import registry
from motes.formats.recording import LABEL, Recording
from motes.rows.journal import FrameRow, Header, ObjectRow
from motes.rows.schema import hindsight
from motes.studio.commands import Places, Watch
from motes.studio.document import DrawnTarget, places_toml
from motes.studio.messages import OpenFilm
from motes.studio.scenes import watch_config

DEFAULT_NAME = re.compile(r"object \d+", re.IGNORECASE)
"""The name that the studio gives to an object."""
SPLIT = re.compile(r"( \(2\))+$")
"""What it adds to the name of an object that is split."""


class Reproduction(msgspec.Struct, frozen=True):
    """How a run is repeated."""

    command: str
    """The command line."""
    files: dict[str, str]
    """The files that it names; and the whole configuration, in `tracker.toml` or `watch.toml`."""


def class_of(name: str) -> str:
    """Return the class of an object: the name that a user has given it, else `LABEL`."""
    given = SPLIT.sub("", " ".join("".join(filter(str.isprintable, name)).split()))
    return LABEL if not given or DEFAULT_NAME.fullmatch(given) else given


def target_rows(tracks: Sequence[Track]) -> list[FrameRow]:
    """Return the rows of one object, as `motes track --at ... -o` writes them."""
    return [
        FrameRow(track.frame, track.time, (ObjectRow.of_target(track, hindsight(track)),))
        for track in tracks
    ]


def objects_rows(found: Mapping[int, tuple[str, Sequence[Track]]]) -> list[FrameRow]:
    """Return the rows of several objects, with their numbers as identities, and their classes."""
    frames: dict[int, tuple[float, list[ObjectRow]]] = {}
    for number, (name, tracks) in found.items():
        label = None if class_of(name) == LABEL else class_of(name)
        for track in tracks:
            _, objects = frames.setdefault(track.frame, (track.time, []))
            if track.status is not Status.ABSENT:
                objects.append(replace(ObjectRow.of_target(track), identity=number, label=label))
    return [FrameRow(frame, time, tuple(each)) for frame, (time, each) in sorted(frames.items())]


def recorded_file(
    form: str, film: OpenFilm, files: Sequence[str], rows: Sequence[FrameRow], label: str = LABEL
) -> tuple[bytes, str]:
    """Return objects in a format of `motes convert`, a format of many files as ZIP; and a remark.

    The film may have images: then `files` are their names, by frame. `label` is the class of
    objects without one.

    Raises
    ------
    ConfigError
        For an unknown format.
    FormatError
        If the format cannot hold them.
    """
    known = registry.FORMATS.resolve(form)
    if files:
        rows = [replace(row, file=files[row.frame]) for row in rows]
    recording = Recording(Header(film.name, film.width, film.height, label), rows)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "file"
        try:
            said = registry.write(path, form, recording).guesses_told(form)
        except OSError as error:
            raise FormatError(f"{form} cannot be written: {error.strerror}.") from None
        return zipped(path) if known.folder else path.read_bytes(), said


def zipped(folder: Path) -> bytes:
    """Return the files of a folder as ZIP; equal files give equal bytes."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(folder.rglob("*")):
            if path.is_file():
                name = path.relative_to(folder).as_posix()
                archive.writestr(zipfile.ZipInfo(name), path.read_bytes())
    return out.getvalue()


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
        form=FORMAT, film=os.path.basename(film.name), width=film.width, height=film.height,
        frames=end, start=target.first, end=end, preset=target.preset,
        config=to_dict(target.tracker), seed=target.seed,
    )  # fmt: skip
    return history.corrected([*target.marks.items()]).encoded()


def command_of(target: DrawnTarget, film: OpenFilm) -> Reproduction:
    """Return the command line that tracks an object again, to the byte."""
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
    files = {"tracker.toml": to_toml(target.tracker)}
    if target.config is not None:
        words += ["--config", "motes.toml"]
        files["motes.toml"] = target.config
    words += ["--seed", str(target.seed), "-o", "rows.csv"]
    return Reproduction(shlex.join(words), files)


def watch_command(film: OpenFilm, watch: Watch, places: Places) -> Reproduction:
    """Return the command line that tracks all that moves again."""
    words = ["motes", "watch", film.name, "--detector", watch.detector, "--preset", watch.preset]
    files = {"watch.toml": to_toml(watch_config(watch))}
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
