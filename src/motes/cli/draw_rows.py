"""What `motes draw` draws: rows of one target or of several objects, frame by frame."""

from __future__ import annotations

import itertools
import math
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from msgspec.structs import replace

from motes.cli.frame_loop import Sink, exit_code, run, summarize
from motes.cli.messages import counted
from motes.cli.track_keyframes import Hindsight
from motes.cli.track_loop import Step
from motes.cli.track_outputs import TrackOverlay
from motes.cli.track_units import MOTION, MotionFigures
from motes.cli.watch_outputs import FrameResult, SceneOverlay
from motes.cli.watch_pictures import Heatmap, Paths, Slits
from motes.core.errors import ConfigError, InputError
from motes.core.frame import Frame
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.correction.history import History
from motes.correction.rows import TIME_TOLERANCE, KnownRows
from motes.formats import registry
from motes.formats.recording import ANONYMOUS, FilmFacts, Recorded
from motes.mot.analytics.events import EventCounter
from motes.mot.analytics.real_units import PIXELS, GroundMotion, GroundPlace, RealUnits
from motes.mot.analytics.regions import Regions
from motes.mot.tracked_object import SceneTrack
from motes.output.journal import ObjectRow
from motes.output.read_rows import read_track
from motes.output.track_rows import GROUND

if TYPE_CHECKING:
    from motes.video.sources import Source

T = TypeVar("T")


@dataclass(frozen=True)
class Given:
    """Rows that are drawn.

    Attributes
    ----------
    path
        Their file.
    tracks
        Those of one target, by frame; None for several objects.
    objects
        Several objects in each frame.
    times
        The times of frames, where the file has them.
    places
        Places on the ground, where the file has them.
    """

    path: Path
    tracks: Mapping[int, Track] | None
    objects: Mapping[int, Sequence[ObjectRow]]
    times: Mapping[int, float]
    places: Mapping[int, GroundPlace]

    @property
    def last(self) -> int:
        """The last frame of the rows; -1 without any."""
        return max(self.tracks if self.tracks is not None else self.objects, default=-1)


def rows_in(path: Path, form: str | None, film: Source) -> Given:
    """Return the rows in a file of any format.

    Raises
    ------
    MotesError
        If it cannot be read.
    """
    form = form or registry.recognized(path)
    if form in ("csv", "jsonl"):
        names = read_track(path).dtype.names or ()
        if "identity" not in names and "theta" in names:
            return _target(path)
    facts = FilmFacts(
        source=film.name, width=film.width, height=film.height, frames=None, fps=film.fps
    )
    recorded = registry.read(path, form, facts)
    timed = form in ("csv", "jsonl", "parquet", "journal")
    times = {row.frame: row.time for row in recorded} if timed else {}
    objects = {row.frame: row.objects for row in recorded if row.objects}
    tracks = _single(recorded) if _is_target(form, recorded) else None
    return Given(path, tracks, objects, times, {})


def _target(path: Path) -> Given:
    """Return the rows of one target that motes has written."""
    table = KnownRows(path)
    tracks = {track.frame: track for track in table.tracks}
    places = {}
    if table.metres:
        for row in read_track(path):
            if math.isfinite(row["x_m"]):
                places[int(row["frame"])] = GroundPlace(*(float(row[name]) for name in GROUND))
    return Given(path, tracks, {}, {each.frame: each.time for each in table.tracks}, places)


def _is_target(form: str, recorded: Recorded) -> bool:
    """Return whether rows of another tool are of one target, whose ellipse is drawn."""
    objects = itertools.chain.from_iterable(row.objects for row in recorded)
    if registry.FORMATS.resolve(form).single:
        return True
    found = list(objects)
    return len({each.identity for each in found}) == 1 and any(each.ellipse.theta for each in found)


def _single(recorded: Recorded) -> dict[int, Track]:
    unknown = np.full((5, 5), np.nan)
    return {
        row.frame: _track(row.frame, row.time, each, unknown)
        for row in recorded
        for each in row.objects[:1]
    }


def _track(frame: int, time: float, each: ObjectRow, covariance: Floats) -> Track:
    return Track(
        frame, time, each.ellipse, covariance, each.confidence, each.status, math.nan, math.nan
    )


def draw_target(
    film: Source,
    given: Given,
    units: RealUnits | None,
    output: Path | None,
    figures: Path | None,
    *,
    overwrite: bool,
) -> int:
    """Draw one target; return the exit code."""
    assert given.tracks is not None
    tracks, motion = given.tracks, _Motion(units or PIXELS)
    unit = "pixels" if units is None and not given.places else "m"
    outputs: list[Sink[Step]] = []
    if output is not None:
        shown = None if unit == "pixels" else unit
        outputs.append(TrackOverlay(output, film, 1, unit=shown, overwrite=overwrite))
    if figures is not None:
        outputs.append(MotionFigures(figures / given.path.stem, MOTION, unit, overwrite=overwrite))

    def steps(frames: Iterator[Frame]) -> Generator[Step, None, None]:
        for frame in _checked(frames, given, film):
            track = tracks.get(frame.index)
            if track is None or not all(map(math.isfinite, track.ellipse)):
                track = track if track is not None and track.status is Status.ABSENT else None
            place = given.places.get(frame.index) if given.places else motion.update(track)
            info = None if track is None else Hindsight(track)
            yield Step(frame, info, 0.0, place)

    return _run(film, outputs, steps)


class _Motion(GroundMotion):
    """Places and speeds of tracks whose covariances may be unknown; then so are deviations."""

    def update(self, track: Track | None) -> GroundPlace | None:
        """Return the place in a frame."""
        if track is None or np.isfinite(track.covariance).all():
            return super().update(track)
        place = super().update(replace(track, covariance=np.eye(5)))
        nothing = {"x_m_std": math.nan, "y_m_std": math.nan, "speed_std": math.nan}
        return None if place is None else place._replace(**nothing)


def draw_objects(
    film: Source,
    given: Given,
    units: RealUnits | None,
    known: History | None,
    output: Path | None,
    figures: Path | None,
    *,
    overwrite: bool,
) -> int:
    """Draw several objects, with what they do at lines and in zones; return the exit code."""
    if units is not None and units.lens is not None:
        raise ConfigError("A lens is for rows of one target; omit --lens.")
    regions = Regions() if known is None else known.regions
    regions = replace(regions, ground=None if units is None else units.ground)
    counter = EventCounter(regions)
    outputs: list[Sink[FrameResult]] = []
    if output is not None:
        outputs.append(SceneOverlay(output, film, 1, regions, overwrite=overwrite))
    if figures is not None:
        stem = figures / given.path.stem
        outputs.append(Heatmap(_named(stem, "heatmap"), overwrite=overwrite))
        outputs.append(Paths(_named(stem, "paths"), overwrite=overwrite))
        if regions.line:
            outputs.append(Slits(_named(stem, "slit"), regions, overwrite=overwrite))
    unknown = np.full((5, 5), np.nan)

    def moments(frames: Iterator[Frame]) -> Generator[FrameResult, None, None]:
        for frame, following in _paired(_checked(frames, given, film)):
            tracks = [
                SceneTrack(
                    each.identity,
                    _track(frame.index, frame.time, each, unknown),
                    each.occluded_by,
                    label=each.label,
                )
                for each in given.objects.get(frame.index, ())
            ]
            events = counter.update([each for each in tracks if each.identity != ANONYMOUS])
            yield FrameResult(frame, tracks, events if following else events + counter.finish())

    return _run(film, outputs, moments)


def _named(stem: Path, what: str) -> Path:
    return stem.with_name(f"{stem.name}.{what}.png")


def _paired(frames: Iterable[Frame]) -> Iterator[tuple[Frame, bool]]:
    """Yield each frame, and whether another one follows."""
    last: Frame | None = None
    for frame in frames:
        if last is not None:
            yield last, True
        last = frame
    if last is not None:
        yield last, False


def _checked(frames: Iterator[Frame], given: Given, film: Source) -> Iterator[Frame]:
    """Yield the frames; raise an InputError if the rows are not of this film."""
    last = -1
    for frame in frames:
        last, time = frame.index, given.times.get(frame.index, frame.time)
        if not abs(time - frame.time) <= TIME_TOLERANCE:
            raise InputError(
                f"{given.path} has frame {last} at {time:g} s, but {film.name} at {frame.time:g} "
                f"s; give the film of these rows, or its --fps."
            )
        yield frame
    if last < given.last:
        raise InputError(
            f"{given.path} has rows up to frame {given.last}, but {film.name} ends with frame "
            f"{last}; give the film of these rows."
        )


def _run(film: Source, outputs: Sequence[Sink[T]], steps: object) -> int:
    count = 0

    def note(_: T) -> str:
        nonlocal count
        count += 1
        return "drawn"

    def report(interrupted: KeyboardInterrupt | None) -> None:
        if count:
            summarize([counted(count, "frame")], film, outputs, interrupted)

    interrupted = run(film, outputs, steps, note, report)  # type: ignore[arg-type]
    return exit_code(interrupted, True, "")
