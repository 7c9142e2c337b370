"""What is remembered of rows, in one file beside them: the run that made them, and corrections."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import msgspec
from msgspec.structs import replace

from motes import __version__
from motes.core.config import Config, checked_seed, from_dict
from motes.core.errors import ConfigError, InputError
from motes.core.files import check_writable, is_special, write_whole, writing
from motes.core.geometry import Ellipse
from motes.correction.join import Stretch
from motes.correction.keyframes import Mark, Region, keyframes
from motes.mot.analytics.real_units import RealUnits
from motes.mot.analytics.regions import Regions
from motes.rows.schema import text_name
from motes.sot.algorithm import Algorithm
from motes.sot.presets import TrackerConfig
from motes.video.film import Film
from motes.video.sources import Source, check_rate

FORMAT = 3
"""Version of the file."""


class History(msgspec.Struct, frozen=True, kw_only=True):
    """How rows were made, and what has been corrected; every command that reads rows reads it."""

    ENDING: ClassVar = ".run.json"
    """The file of `rows.csv` is `rows.csv.run.json`."""
    form: int = FORMAT
    """Version of the file."""
    film: str
    width: int
    height: int
    frames: int | None
    """Name and size of the film, and the number of its frames; None before they are all known."""
    start: int
    end: int | None
    """The frames that are used."""
    config: dict[str, Any]
    seed: int
    """The tracker: all values of its preset, and the seed of its random numbers."""
    motes: str = __version__
    """Version of motes."""
    stride: int = 1
    """Every n-th frame is used, where n is this number."""
    fps: float | None = None
    """Frames per second that give the times; None where the film has times of its own."""
    preset: str | None = None
    """The name of the tracker's preset."""
    places: Regions | None = None
    """The lines and zones of `motes watch`; None for rows of `motes track`."""
    units: RealUnits | None = None
    """How pixels become metres, if they do."""
    corrections: list[list[tuple[int, list[float] | None]]] = []
    """The marks of each command, in order: frames with a region or None. A later mark of a frame
    replaces an earlier one."""
    unfinished: list[tuple[int, int]] = []
    """First and last frames of stretches whose rows may not be written yet. A command notes all of
    its stretches here before it writes any row, so that it can be finished after a kill."""
    lines: int | None = None
    """How many lines the file of rows had when its run or its last correction ended, by which a
    part of it is told from the whole; None until then."""
    last: int | None = None
    """The last frame that the run has seen; None until it ended."""
    objects: dict[int, History] = {}
    """Where several objects are tracked, the histories of those that have been corrected, by their
    identities."""

    @classmethod
    def of_run(
        cls,
        film: Source | Film,
        config: Config,
        seed: int,
        preset: str | None = None,
        *,
        units: RealUnits | None = None,
        places: Regions | None = None,
        start: int = 0,
        end: int | None = None,
        stride: int = 1,
    ) -> History:
        """Return the history of a run that begins, without keyframes."""
        return cls(
            film=text_name(Path(film.name).name),
            width=film.width,
            height=film.height,
            frames=None,
            start=start,
            end=end,
            stride=stride,
            fps=film.even_rate,
            preset=preset,
            config=config.to_dict(),
            seed=seed,
            units=units,
            places=places,
        )

    @classmethod
    def begin(
        cls,
        film: Film,
        config: TrackerConfig,
        seed: int,
        marks: Sequence[Mark],
        units: RealUnits | None = None,
        preset: str | None = None,
    ) -> History:
        """Return the history of a film with its first keyframes."""
        used = film.frames
        empty = cls.of_run(film, config, seed, preset, units=units, start=used.start, end=used.stop)
        return replace(empty, frames=len(film.times)).corrected(marks)

    @classmethod
    def load(cls, path: Path) -> History:
        """Return a history that `save` has written.

        Raises an InputError if it cannot be read or is none.
        """
        try:
            history = msgspec.json.decode(path.read_bytes(), type=cls)
            for each in (history, *history.objects.values()):
                if each.form != FORMAT:
                    raise InputError(f"{path} is of another version of motes; make the rows anew.")
                end = each.end if each.end is not None else each.frames
                stop = each.frames if each.frames is not None else end
                if each.start < 0 or (end is not None and not each.start < end <= (stop or 0)):
                    last = "" if end is None else f" to {end - 1}"
                    raise ConfigError(f"the frames {each.start}{last} are none")
                checked_seed(each.seed)
                check_rate(each.fps)
                each.keys  # noqa: B018
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror}.") from None
        except (msgspec.MsgspecError, ConfigError, RecursionError) as error:
            why = str(error).rstrip(".")
            raise InputError(
                f"{path} does not tell how its rows were made ({why}); repair it, or delete it: "
                f"the first row is then the only keyframe."
            ) from None
        return history

    def save(self, rows: Path, *, whole: bool = False) -> None:
        """Write the history beside its rows, with the number of their lines if they are complete.

        Raises a FormatError if the file cannot be written.
        """
        lines, path = line_count(rows) if whole else None, self.path(rows)
        with writing(path):
            write_whole(path, self.encoded(lines))

    def encoded(self, lines: int | None = None) -> bytes:
        """Return the content of the file."""
        return (
            msgspec.json.format(msgspec.json.encode(replace(self, lines=lines)), indent=1) + b"\n"
        )

    def check_tracker(self, path: Path) -> None:
        """Raise an InputError if the tracker has keys of an earlier version.

        Only who goes on with this tracker needs it: its rows can be drawn and converted without.
        """
        try:
            self.tracker  # noqa: B018
        except ConfigError as error:
            raise InputError(
                f"{path} has a tracker that motes {__version__} does not have "
                f"({str(error).rstrip('.')}); correct that key there, or delete the "
                f"key to go on with the tracker of this version."
            ) from None

    @property
    def used(self) -> range:
        """The frames that are used, as far as they are known."""
        return range(
            self.start, (self.end if self.last is None else self.last + 1) or 0, self.stride
        )

    @property
    def tracker(self) -> TrackerConfig:
        """The configuration of the tracker of `motes track`."""
        config: TrackerConfig = from_dict(self.config, Algorithm)
        return config

    @property
    def keys(self) -> dict[int, Region | None]:
        """The keyframes after all corrections."""
        latest: dict[int, Sequence[float] | None] = {}
        for marks in self.corrections:
            latest |= dict(keyframes(marks))
        return keyframes(latest.items())

    def corrected(self, marks: Sequence[Mark]) -> History:
        """Return the history with further marks; those of one command must agree.

        Marks that are all known already add nothing: a command that is repeated after a signal, or
        one that only finishes it, leaves the file that it would have left at once.
        """
        found = keyframes(marks)
        if self.keys | found == self.keys:
            return self
        new = [(frame, None if mark is None else [*mark]) for frame, mark in found.items()]
        return replace(self, corrections=[*self.corrections, new])

    def of(self, identity: int | None) -> History:
        """Return the history of one of several objects; the same one for None."""
        if identity is None:
            return self
        return self.objects.get(identity, replace(self, objects={}))

    def boxed(self) -> History:
        """Return the history with the upright ellipse of its first frame as the box around it.

        It stays as it is where a correction has marked another region, and so chosen a form.
        """
        ((frame, region), *more), *rest = self.corrections
        marked = more or any(mark for each in rest for _, mark in each)
        if not rest or marked or region is None or len(region) != 5 or region[4]:
            return self
        return replace(self, corrections=[[(frame, [*Ellipse(*region).box])], *rest])

    def unfinished_with(self, left: Iterable[Stretch]) -> History:
        """Return the history with stretches that are not finished."""
        return replace(self, unfinished=[(each.first, each.last) for each in left])

    @classmethod
    def path(cls, rows: Path) -> Path:
        """Return the path of the history beside a file of rows."""
        return rows.with_name(rows.name + cls.ENDING)

    @classmethod
    def beside(cls, rows: Path) -> History | None:
        """Return what is remembered of rows; None if there is nothing beside them.

        Raises an InputError if the file cannot be read, or the rows have fewer lines than when
        their run ended.
        """
        path = cls.path(rows)
        if not path.exists():
            return None
        known = cls.load(path)
        with contextlib.suppress(OSError):  # who reads the rows says why they cannot be read
            count = line_count(rows)
            if known.lines is not None and count < known.lines:
                raise InputError(
                    f"{rows} has {count} lines of {known.lines}, by {path.name}: it is cut off; "
                    f"make it anew, or if that is meant, correct the lines there."
                )
        return known

    def check(self, film: Film | Source) -> None:
        """Check that this is the history of a film.

        Raises an InputError if the film has another size or, where it is known, another number of
        frames.
        """
        count = len(film.times) if isinstance(film, Film) else self.frames
        other = self.frames not in (None, count)
        if other or (film.width, film.height) != (self.width, self.height):
            # A film that is read only as far as the rows go may have more frames than are counted.
            here, there = (
                f"{f'{frames} frames of ' * other}{each.width}x{each.height}"
                for each, frames in ((film, count), (self, self.frames))
            )
            raise InputError(
                f"{film.name} has {here}, but the rows are of {self.film}, with {there}; give "
                f"that film."
            )


def line_count(rows: Path) -> int:
    """Return the number of lines with an end in a file of rows; raise an OSError without it."""
    with rows.open("rb") as file:
        return sum(part.count(b"\n") for part in iter(lambda: file.read(1 << 20), b""))


def check_beside(rows: Path, overwrite: bool) -> None:
    """Raise a FormatError if other rows are remembered beside new ones, and must stay so."""
    if not is_special(rows) and History.path(rows).exists():
        check_writable(History.path(rows), overwrite)


def hand_on(known: History | None, rows: Path) -> None:
    """Write what is known of new rows beside them; what is there of older rows goes.

    Beside a pipe or a device, as /dev/stdout, nothing is remembered. Raises a FormatError if the
    file cannot be written.
    """
    if is_special(rows):
        return
    if known is None:
        History.path(rows).unlink(missing_ok=True)
    else:
        known.save(rows, whole=True)
