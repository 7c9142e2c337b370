"""What `motes draw` draws: rows of one target or of several objects, frame by frame."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from motes.cli.frame_loop import Moment, Moments
from motes.cli.watch_loop import counted_moments
from motes.core.errors import InputError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.track import GROUND, Track
from motes.correction.history import History
from motes.correction.rows import TIME_TOLERANCE
from motes.formats import registry
from motes.formats.recording import ANONYMOUS, FilmFacts
from motes.mot.analytics.event_counter import EventCounter
from motes.mot.analytics.real_units import (
    PIXELS,
    Columns,
    RealUnits,
    motion_in_hindsight,
    seen_live,
    with_speeds,
)
from motes.mot.analytics.regions import Regions
from motes.rows.schema import FrameRow
from motes.sot.algorithm import StepInfo
from motes.video.film import Film
from motes.video.sources import Source


@dataclass(frozen=True)
class Given:
    """Rows that are drawn."""

    path: Path
    """Their file."""
    rows: Mapping[int, FrameRow]
    """Those of each frame."""
    single: bool
    """Whether they are of one target, whose ellipse is drawn."""
    timed: bool
    """Whether the file has the times of frames."""
    stride: int
    """That of its run, which has skipped the frames in between."""

    @property
    def last(self) -> int:
        """The last frame that has a row; -1 without any."""
        rows = self.rows.values()
        return max((row.frame for row in rows if row.objects or self.timed), default=-1)

    @property
    def metres(self) -> bool:
        """Whether they have places in metres."""
        return any(GROUND[0] in each.further for row in self.rows.values() for each in row.objects)

    def objects(self, frame: Frame) -> Sequence[Track]:
        """Return the objects in a frame."""
        return self.rows[frame.index].objects if frame.index in self.rows else ()


def rows_in(
    path: Path, form: str | None, film: Source, source: str, known: History | None
) -> Given:
    """Return the rows in a file of any format; those of one object, unless a scene was watched.

    Raises a MotesError if it cannot be read, or is of another film than that of `source`, which is
    open.
    """
    form = form or registry.recognized(path)
    read = None if film.even_rate else Film.quickly(source)
    facts = FilmFacts(
        source=film.name, width=film.width, height=film.height, fps=film.fps, files=film.files,
        times=() if read is None else read.times,
    )  # fmt: skip
    recorded = registry.read(path, form, facts)
    head = recorded.head
    if (head.width, head.height) not in ((0, 0), (film.width, film.height)):
        raise InputError(
            f"{path} is of a film of {head.width}x{head.height} pixels, not of {film.width}x"
            f"{film.height}; give the film that it belongs to."
        )
    rows = {row.frame: row for row in recorded}
    identities = {each.identity for row in rows.values() for each in row.objects}
    alone = len(identities) == 1 and ANONYMOUS not in identities
    watched = known is not None and known.places is not None
    single = registry.FORMATS.resolve(form).single or (alone and not watched)
    timed = form in ("csv", "jsonl", "parquet", "journal")
    given = Given(path, rows, single, timed, recorded.stride)
    if read is None:
        for frame in rows:
            _check_time(given, film, frame, facts.time(frame))
    else:
        _check_film(given, film, source, read)
    return given


def _check_film(given: Given, film: Source, source: str, read: Film) -> None:
    """Raise an InputError if rows are not of a film with times of its own.

    They are those of its packets; where damage may have changed them, it is decoded.
    """
    try:
        _check_times(given, film, read.times)
    except InputError:
        if not read.quick:
            raise
        _check_times(given, film, Film(source).times)


def _check_times(given: Given, film: Source, times: Sequence[float]) -> None:
    for frame in given.rows:
        if frame < len(times):
            _check_time(given, film, frame, times[frame])
    _check_end(given, film, len(times) - 1)


def target_moments(film: Source, given: Given, units: RealUnits | None) -> Moments:
    """Return what makes the moments of rows of one target."""

    def moments(frames: Iterator[Frame]) -> Generator[Moment, None, None]:
        places = _measured(given, units or PIXELS)
        for frame in _checked(frames, given, film):
            each = next(iter(given.objects(frame)), None)
            if each is None:
                yield Moment(frame, [Track.nowhere(frame.index, frame.time)])
            else:
                more = {**each.further, **places.get((each.identity, frame.index), {})}
                track = replace(each, time=frame.time, further=more)
                yield Moment(frame, [track], StepInfo(track))

    return moments


def _measured(
    given: Given, units: RealUnits | None, size: tuple[int, int] | None = None
) -> dict[tuple[int, int], Columns]:
    """Return places and speeds by identity and frame.

    Where covariances are unknown, so are deviations. Rows of a live run have the speeds of a
    quarter of a second ago, which would be drawn too late: they are measured anew, now that the
    frames after each one are known. Where the edge of a picture of a size cuts a box, the speed is
    that of before, as of a live run.
    """
    ways = defaultdict[int, dict[int, Track]](dict)
    for row in given.rows.values():
        for each in row.objects:
            if each.identity != ANONYMOUS:
                ways[each.identity][row.frame] = each
    found = dict[tuple[int, int], Columns]()
    for identity, way in ways.items():
        if given.metres and any(np.isfinite(each.covariance).all() for each in way.values()):
            continue  # smoothed or corrected: they are of hindsight already
        frames = range(min(way), max(way) + 1, given.stride)
        cut = {frame for frame, each in way.items() if each.box.is_cut(size)}
        tracks = [None if frame in cut else way.get(frame) for frame in frames]
        if given.metres:
            places = with_speeds([seen_live(track) for track in tracks])
        else:
            places = motion_in_hindsight(units, tracks)
        before: Columns = {}
        for frame, place in zip(frames, places, strict=True):
            before = {"speed": before.get("speed")} if frame in cut else place
            found[identity, frame] = before
    return found


def object_moments(
    film: Source, given: Given, regions: Regions, units: RealUnits | None
) -> Moments:
    """Return what makes the moments of several objects, with what they do at lines and in zones."""
    size = film.width, film.height
    counter = EventCounter(regions, size)
    ends = {each.identity: row.frame for row in given.rows.values() for each in row.objects}

    def objects(frames: Iterator[Frame]) -> Iterator[tuple[Frame, list[Track]]]:
        places = _measured(given, units, size)
        for frame in _checked(frames, given, film):
            tracks = []
            for each in given.objects(frame):
                if not each.placed:  # one that is marked as absent
                    continue
                more = {**each.further, **places.get((each.identity, frame.index), {})}
                # The box has all digits of the file; those of an ellipse are half as exact.
                ellipse = Ellipse.from_box(each.box)
                sought = frame.index < ends[each.identity]
                tracks.append(
                    replace(each, time=frame.time, ellipse=ellipse, sought=sought, further=more)
                )
            yield frame, tracks

    return lambda frames: counted_moments(objects(frames), counter)


def _checked(frames: Iterator[Frame], given: Given, film: Source) -> Iterator[Frame]:
    """Yield the frames; raise an InputError if the rows are not of this film."""
    last = -1
    for frame in frames:
        last = frame.index
        _check_time(given, film, last, frame.time)
        yield frame
    _check_end(given, film, last)


def _check_end(given: Given, film: Source, last: int) -> None:
    if last < given.last:
        raise InputError(
            f"{given.path} has rows up to frame {given.last}, but {film.name} ends with frame "
            f"{last}; give the film of these rows."
        )


def _check_time(given: Given, film: Source, frame: int, seconds: float) -> None:
    row = given.rows.get(frame)
    time = row.time if row is not None and given.timed else seconds
    if not abs(time - seconds) <= TIME_TOLERANCE:
        raise InputError(
            f"{given.path} has frame {frame} at {time:g} s, but {film.name} at {seconds:g} "
            f"s; give the film of these rows or its --fps, or correct the column time, in seconds."
        )
