"""Rows of one target, read as tracks, and changed without touching any other row."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import msgspec
import numpy as np
from msgspec.structs import replace

from motes.core.errors import ConfigError, FormatError, InputError
from motes.core.files import lines_of, read_text, same_file, write_whole, writing
from motes.core.geometry import Ellipse, check_angle
from motes.core.track import COLUMNS, DEVIATIONS, ELLIPSE, GROUND, Status, Track
from motes.mot.analytics.real_units import Columns, RealUnits, motion_in_hindsight
from motes.rows.reader import table_of
from motes.rows.schema import HINDSIGHT, NUMBERS, Form, FrameRow, form_of, head, line
from motes.video.film import Film

NEEDED = ("frame", "time", "id", "label", *ELLIPSE, "confidence", "status")
"""The columns without which rows cannot be corrected."""
LARGEST = 1e9
"""Largest number of a row, in any unit."""
LEAST_HALF = 1e-3
"""Least half-axis: rows have three digits."""
TIME_TOLERANCE = 1e-3
"""Seconds by which the time of a row may differ from that of its frame; rows have six digits."""


class KnownRows:
    """The rows of one object in a file that `motes track`, `smooth` or `refine` has written.

    Raises an InputError if the file cannot be read, is empty, lacks a column, or does not have this
    object; also if it has several, and none is chosen. The last line of `growing` rows may be cut
    off, as of a run that was killed; it is then left out. `identity` is which object is meant, None
    for the only one; rows of others stay as they are.

    Attributes
    ----------
    columns
        Their columns.
    identity
        The identity of the object.
    several
        Whether the file has other objects.
    tracks
        The track of each row, in order of the frames; without a place, NaN. The variances are NaN
        where the file has none.
    """

    def __init__(self, path: Path, *, growing: bool = False, identity: int | None = None) -> None:
        self._path, self._form = path, form_of(path)
        self._version = _version(path)
        text = read_text(path, InputError, newline="")
        if growing:
            text = text[: text.rfind("\n") + 1]
        table = table_of(text, path, self._form)
        self.columns = tuple(table.dtype.names or ())
        if missing := [name for name in NEEDED if name not in self.columns]:
            what = f"{path} lacks {', '.join(missing)} among its columns"
            raise InputError(f"{what}; give one of motes track, or make one with motes convert.")
        if not len(table):
            raise InputError(f"{path} has no rows; give a file of motes track that has some.")
        identities = sorted({*table["id"].tolist()})
        if identities[0] < -1:
            raise InputError(
                f"{path} has the id {identities[0]}; identities count from 0, and -1 is none: "
                f"correct that column."
            )
        named = [each for each in identities if each >= 0]
        if identity is None and len(identities) > 1:
            raise InputError(
                f"{path} has {len(identities)} objects; choose one, as with --identity {named[0]}."
            )
        if identity not in (None, *named):
            known = ", ".join(map(str, named[:20])) or "none with an identity"
            raise InputError(f"{path} has no object {identity}; it has {known}.")
        self.identity = identities[0] if identity is None else identity
        self.several = len(identities) > 1
        mine = table["id"] == self.identity
        self._label = str(table["label"][mine][0]) or None
        self.tracks = [
            _track(path, dict(zip(self.columns, row.tolist(), strict=True))) for row in table[mine]
        ]
        try:
            check_angle(next((each.ellipse.theta for each in self.tracks if each.placed), 0.0))
        except ConfigError as error:
            raise InputError(f"{path}: {error}; correct that column.") from None
        frames = [track.frame for track in self.tracks]
        if frames != sorted(set(frames)) or frames[0] < 0:
            raise InputError(
                f"{path} has a frame twice, out of order, or below 0; correct its first column."
            )
        self._end = "\r\n" if text.partition("\n")[0].endswith("\r") else "\n"
        lines = [f"{each}\n" for each in lines_of(text)]
        self._head = lines[: self._form == "csv"]
        kept = [text for text in lines[len(self._head) :] if text.strip()]
        if len(kept) != len(table):
            raise InputError(f"{path} has a row of several lines; give its object a plain label.")
        keys = zip(table["frame"].tolist(), table["id"].tolist(), strict=True)
        self._lines = dict(zip(keys, kept, strict=True))
        if len(self._lines) != len(kept):
            raise InputError(f"{path} has an object twice in a frame; remove one of its rows.")

    @property
    def hindsight(self) -> bool:
        """Whether the rows have variances and outliers: they are smoothed or corrected.

        Of several objects, another one alone may be.
        """
        known = set(DEVIATIONS) <= set(self.columns)
        return known and not (
            self.several and all(np.isnan(track.covariance).any() for track in self.tracks)
        )

    @property
    def tracked(self) -> bool:
        """Whether a tracker has written rows: it compares with a model, and other tools do not."""
        return any(math.isfinite(each.distance) for each in self.tracks)

    @property
    def frames(self) -> list[int]:
        """The frames that have a row, in order."""
        return [track.frame for track in self.tracks]

    @property
    def first_tracked(self) -> Track:
        """The first row that has the target: where its user has marked it.

        Raises a ConfigError if there is none.
        """
        for track in self.tracks:
            if track.status is Status.TRACKING:
                return track
        raise ConfigError(
            f"{self._path} has no row in which the target is tracked; mark it anew, with motes "
            f"track --at."
        )

    def check_whole(self) -> None:
        """Raise an InputError if a frame between the first and the last row has none."""
        first, last = self.tracks[0].frame, self.tracks[-1].frame
        if last - first + 1 != len(self.tracks):
            raise InputError(
                f"{self._path} has {len(self.tracks)} rows of the frames {first} to {last}; make "
                f"rows of every frame: motes convert makes keyframes of these, and motes track "
                f"--keyframes follows between them."
            )

    def check_plain(self) -> None:
        """Raise an InputError if the rows are smoothed or corrected already."""
        if self.hindsight:
            raise InputError(
                f"{self._path} is smoothed or corrected already; give rows of a plain motes track."
            )

    def check(self, film: Film) -> None:
        """Check that these are rows of a film.

        Raises an InputError if the film is shorter, has other times, or smaller pictures.
        """
        if self.tracks and self.tracks[-1].frame >= len(film.times):
            raise InputError(
                f"{self._path} has rows up to frame {self.tracks[-1].frame}, but {film.name} has "
                f"only {len(film.times)} frames; give the film of these rows."
            )
        for track in self.tracks:
            if not abs(track.time - film.times[track.frame]) <= TIME_TOLERANCE:
                raise InputError(
                    f"{self._path} has frame {track.frame} at {track.time:g} s, but {film.name} "
                    f"at {film.times[track.frame]:g} s; give the film of these rows, or correct "
                    f"the column time, in seconds."
                )
            x, y, width, height = track.box  # a target that leaves has its center outside first
            if track.status is Status.TRACKING and not (
                -width <= x <= film.width and -height <= y <= film.height
            ):
                raise InputError(
                    f"{self._path} has the target at {x:g},{y:g} in frame {track.frame}, outside "
                    f"of {film.name}, {film.width}x{film.height}; give the film of these rows."
                )

    @property
    def metres(self) -> bool:
        """Whether the rows have places and speeds in metres."""
        return set(GROUND) <= set(self.columns)

    def row(self, track: Track, place: Columns) -> FrameRow:
        """Return a row of the target in hindsight, with its identity, its class and its metres."""
        named = replace(
            track, identity=self.identity, label=self._label, smoothed=True, further=place
        )
        return FrameRow(track.frame, track.time, (named,))

    def replace(self, tracks: Iterable[Track], units: RealUnits | None = None) -> None:
        """Replace the rows of these frames, or add them; all others stay to the byte.

        New ones end as the file's first line does, which another program may have written.

        Rows without the columns of hindsight get them: the others, and other objects, are then
        empty there. `units` is how pixels become metres, for rows that have metres.
        """
        new = {track.frame: track for track in tracks}
        known = {track.frame: track for track in self.tracks} | new
        self.tracks = [known[frame] for frame in sorted(known)]
        usual = (*COLUMNS, *HINDSIGHT)
        columns = (*usual, *(name for name in self.columns if name not in usual))
        if columns != self.columns:
            before, self.columns, new = self.columns, columns, known
            self._head = [text + self._end for text in head(self._form, columns)]
            for key, text in self._lines.items():
                if key[1] != self.identity:
                    self._lines[key] = widened(text, self._form, before, columns) + self._end
        places = motion_in_hindsight(units, map(as_read, self.tracks))
        for track, place in zip(self.tracks, places, strict=True):
            if track.frame in new:
                row = self.row(track, place)
                values = row.values(row.objects[0], columns[len(COLUMNS) :])
                made = line(self._form, columns, values)
                self._lines[track.frame, self.identity] = made + self._end

    def check_unchanged(self, path: Path) -> None:
        """Raise a FormatError if a file is that of these rows, and not as it was when it was read.

        Another of its objects may be corrected at the same time.
        """
        own = same_file(path, self._path)
        if own and _version(path) not in (None, self._version):
            raise FormatError(f"{path} has changed meanwhile, and stays so; correct it once more.")

    def write(self, path: Path) -> None:
        """Write all rows, once.

        Raises a FormatError if the file cannot be written, or has changed meanwhile; an old one
        stays.
        """
        self.check_unchanged(path)
        lines = [*self._head, *(self._lines[key] for key in sorted(self._lines))]
        with writing(path):
            write_whole(path, "".join(lines).encode())


def _version(path: Path) -> tuple[int, int, int] | None:
    """Return what differs between versions of a file; None without a file."""
    try:
        known = path.stat()
    except OSError:
        return None
    return known.st_ino, known.st_size, known.st_mtime_ns


def widened(text: str, form: Form, before: Sequence[str], columns: Sequence[str]) -> str:
    """Return the line of a row with further columns, which are empty; its fields stay as they are.

    The end of the line is left out.
    """
    if form == "jsonl":
        values = msgspec.json.decode(text, type=dict[str, msgspec.Raw])
        fields = [bytes(values.get(name, b"null")).decode() for name in columns]
        pairs = zip(columns, fields, strict=True)
        return "{" + ", ".join(f'"{name}": {field}' for name, field in pairs) + "}"
    (row,) = csv.reader([text], skipinitialspace=True)
    known = dict(zip(before, row, strict=True))
    made = io.StringIO()
    csv.writer(made, lineterminator="").writerow(known.get(name, "") for name in columns)
    return made.getvalue()


def as_read(track: Track) -> Track:
    """Return a track as it is read from its row.

    Metres are of such tracks, so that those of rows that are made anew fit the others to the digit.
    """
    if not all(map(math.isfinite, track.ellipse)):
        return track
    ellipse = [
        float(f"{value:.{digits}f}")
        for value, digits in zip(track.ellipse, (3, 3, 3, 3, 5), strict=True)
    ]
    deviations = [float(f"{math.sqrt(each):.5f}") for each in track.covariance.diagonal().tolist()]
    return replace(
        track,
        time=float(f"{track.time:.6f}"),
        ellipse=Ellipse(*ellipse),
        covariance=np.diag(np.square(deviations)),
    )


def _track(path: Path, row: dict[str, float | int | str]) -> Track:
    number = {name: float(row.get(name, math.nan)) for name in ("frame", *NUMBERS)}
    try:
        status = Status(str(row["status"]))
    except ValueError:
        raise InputError(
            f"{path} has the status {row['status']!r} in frame {row['frame']}; correct that row."
        ) from None
    huge = [name for name, value in number.items() if abs(value) > LARGEST]
    if huge:
        raise InputError(
            f"{path} has {number[huge[0]]:g} as {huge[0]} in frame {row['frame']}; correct that "
            f"row."
        )
    if number["confidence"] < 0 or number["confidence"] > 1:
        raise InputError(
            f"{path} has the confidence {number['confidence']:g} in frame {row['frame']}, which is "
            f"a probability, 0 to 1; correct that column."
        )
    ellipse = Ellipse(*(number[name] for name in ELLIPSE))
    placed = all(map(math.isfinite, ellipse)) and min(ellipse.a, ellipse.b) >= LEAST_HALF
    if status is Status.TRACKING and not placed:
        raise InputError(
            f"{path} tracks the target in frame {row['frame']}, but has no place and size of it; "
            f"correct that row."
        )
    known = row | {"occluded_by": None, "left": None}  # the box follows from the ellipse
    return replace(Track.from_dict(known), further={}, bounds=None)
