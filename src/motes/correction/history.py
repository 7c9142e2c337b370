"""The history of corrections: a file beside the rows from which the run can be repeated."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import msgspec
from msgspec.structs import replace

from motes.core.config import from_dict, to_dict
from motes.core.errors import ConfigError, FormatError, InputError
from motes.core.files import write_whole
from motes.core.geometry import Ellipse
from motes.core.seed import checked_seed
from motes.correction.join import Stretch
from motes.correction.keyframes import keyframes
from motes.mot.analytics.real_units import RealUnits
from motes.sot.algorithm import Algorithm
from motes.sot.presets import TrackerConfig
from motes.video.film import Film

FORMAT = 1
"""Version of the file."""
ENDING = ".corrections.json"
"""The file of `rows.csv` is `rows.csv.corrections.json`."""

Marks = Sequence[tuple[int, Sequence[float] | None]]


class History(msgspec.Struct, frozen=True):
    """What has been done to a film.

    Attributes
    ----------
    motes
        Version of the file.
    film, width, height, frames
        Name and size of the film, and the number of its frames.
    start, end
        The frames that are used.
    config, seed
        The tracker.
    units
        How pixels become metres, if the rows have metres.
    corrections
        The marks of each command, in order: frames with a region or None. A later mark of a frame
        replaces an earlier one.
    unfinished
        First and last frames of stretches whose rows may not be written yet. A command notes all of
        its stretches here before it writes any row, so that it can be finished after a kill.
    """

    motes: int
    film: str
    width: int
    height: int
    frames: int
    start: int
    end: int
    config: dict[str, Any]
    seed: int
    units: dict[str, Any] | None = None
    corrections: list[list[tuple[int, list[float] | None]]] = []
    unfinished: list[tuple[int, int]] = []

    @classmethod
    def begin(
        cls,
        film: Film,
        config: TrackerConfig,
        seed: int,
        marks: Marks,
        units: RealUnits | None = None,
    ) -> History:
        """Return the history of a film with its first keyframes."""
        empty = cls(
            motes=FORMAT,
            film=Path(film.name).name,
            width=film.width,
            height=film.height,
            frames=len(film.times),
            start=film.frames.start,
            end=film.frames.stop,
            config=to_dict(config),
            seed=seed,
            units=None if units is None else to_dict(units),
        )
        return empty.corrected(marks)

    @classmethod
    def load(cls, path: Path) -> History:
        """Return a history that `save` has written.

        Raises
        ------
        InputError
            If it cannot be read or is none.
        """
        try:
            history = msgspec.json.decode(path.read_bytes(), type=cls)
            if history.motes != FORMAT:
                raise InputError(f"{path} is of another version of motes; make the rows anew.")
            if not 0 <= history.start < history.end <= history.frames:
                raise ConfigError(f"the frames {history.start} to {history.end - 1} are none")
            checked_seed(history.seed)
            history.tracker  # noqa: B018
            history.real_units  # noqa: B018
            history.keys  # noqa: B018
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror}.") from None
        except (msgspec.MsgspecError, ConfigError, RecursionError) as error:
            why = str(error).rstrip(".")
            raise InputError(
                f"{path} is no history of corrections ({why}); repair it, or delete it: the "
                f"first row is then the only keyframe."
            ) from None
        return history

    def save(self, path: Path) -> None:
        """Write the history.

        Raises
        ------
        FormatError
            If the file cannot be written.
        """
        try:
            write_whole(path, msgspec.json.format(msgspec.json.encode(self), indent=1) + b"\n")
        except OSError as error:
            raise FormatError(
                f"{path} cannot be written: {error.strerror}; make room, or choose another place."
            ) from None

    @property
    def tracker(self) -> TrackerConfig:
        """The configuration of the tracker."""
        config: TrackerConfig = from_dict(self.config, Algorithm)
        return config

    @property
    def real_units(self) -> RealUnits | None:
        """How pixels become metres; None without metres."""
        return None if self.units is None else from_dict(self.units, RealUnits)

    @property
    def keys(self) -> dict[int, Ellipse | None]:
        """The keyframes after all corrections."""
        latest: dict[int, Sequence[float] | None] = {}
        for marks in self.corrections:
            latest |= dict(keyframes(marks))
        return keyframes(latest.items())

    def corrected(self, marks: Marks) -> History:
        """Return the history with further marks; those of one command must not contradict."""
        found = keyframes(marks)
        new = [(frame, None if mark is None else [*mark]) for frame, mark in found.items()]
        return replace(self, corrections=[*self.corrections, new])

    def unfinished_with(self, left: Iterable[Stretch]) -> History:
        """Return the history with stretches that are not finished."""
        return replace(self, unfinished=[(each.first, each.last) for each in left])

    def repeats(self, other: History) -> bool:
        """Return whether two runs have the same film, tracker and keyframes after all commands."""
        first, second = (
            msgspec.json.encode(replace(each, corrections=[], unfinished=[]))
            for each in (self, other)
        )
        return first == second and self.keys == other.keys

    def check(self, film: Film) -> None:
        """Check that this is the history of a film.

        Raises
        ------
        InputError
            If the film has another size or number of frames.
        """
        here = film.width, film.height, len(film.times)
        if here != (self.width, self.height, self.frames):
            raise InputError(
                f"{film.name} has {here[2]} frames of {here[0]}x{here[1]}, but the rows are of "
                f"{self.film}, with {self.frames} frames of {self.width}x{self.height}; give that "
                f"film."
            )


def history_path(rows: Path) -> Path:
    """Return the path of the history beside a file of rows."""
    return rows.with_name(rows.name + ENDING)
