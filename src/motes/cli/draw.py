"""`motes draw`: overlay, figures and masks of any rows, whatever has made or changed them."""

from __future__ import annotations

import dataclasses
import math
from collections import defaultdict
from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import App, Parameter
from msgspec.structs import replace

from motes.cli.annotated_video import AnnotatedVideo, ScenePainter, TargetPainter
from motes.cli.frame_loop import Moment, Sink, Tally, run
from motes.cli.input_checks import (
    check_not_source,
    check_order,
    point_out_leftovers,
    point_out_unfinished,
    prepared_folder,
    refuse,
)
from motes.cli.known_run import beside
from motes.cli.option_groups import (
    OUTPUT,
    FileName,
    Fps,
    Identity,
    OutputFile,
    Overwrite,
    options,
    say_rate,
)
from motes.cli.pictures import Heatmap, Masks, MotionFigures, Paths, Slits
from motes.cli.track_units import UnitOptions, check_size
from motes.cli.watch_loop import counted_moments
from motes.core.errors import ConfigError, InputError
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
from motes.video.sources import Source, is_recorded, open_source

app = App(name="draw", help_format="plaintext")


@options(OUTPUT)
class DrawOutputs:
    """The pictures that are made."""

    output: OutputFile = None
    """Video with the tracks drawn: .mp4, .mkv, .mov or .m4v."""
    figures: Path | None = None
    """Folder for figures. Of one target: its path, speed and size, .pdf. Of several objects: a
    heatmap, their paths, and a slit scan of each line, .png."""
    masks: Path | None = None
    """Masks of one target: its pixels, where their colors differ from those around it. A folder for
    PNG files, or a .json document of COCO."""
    label: str | None = None
    """Class of the target in a document of masks. [default: object]"""
    overwrite: Overwrite = False

    def of_target(self, film: Source, name: str, *, metres: bool) -> list[Sink]:
        """Return the outputs of rows of one target; `name` begins those of its figures."""
        opened, anew = list[Sink](), self.overwrite
        if self.output is not None:
            painter = TargetPainter(metres=metres)
            opened.append(AnnotatedVideo(self.output, film, painter, 1, overwrite=anew))
        if self.figures is not None:
            unit = "m" if metres else "pixels"
            opened.append(MotionFigures(self.figures / name, unit, overwrite=anew))
        if self.masks is not None:
            opened.append(Masks(self.masks, film, self.label, overwrite=anew))
        return opened

    def of_objects(self, film: Source, name: str, regions: Regions) -> list[Sink]:
        """Return the outputs of rows of several objects."""
        if self.masks is not None:
            raise ConfigError("--masks is for rows of one target; choose one with --identity N.")
        opened, anew = list[Sink](), self.overwrite
        if self.output is not None:
            painter = ScenePainter(regions)
            opened.append(AnnotatedVideo(self.output, film, painter, 1, overwrite=anew))
        if self.figures is not None:
            opened.append(Heatmap(self.figures / f"{name}.heatmap.png", overwrite=anew))
            opened.append(Paths(self.figures / f"{name}.paths.png", overwrite=anew))
            if regions.line:
                opened.append(Slits(self.figures / f"{name}.slit.png", regions, overwrite=anew))
        return opened


@app.default
def draw(
    source: FileName,
    rows: Path,
    /,
    *,
    identity: Identity = None,
    outputs: DrawOutputs = DrawOutputs(),
    from_: Annotated[str | None, Parameter(name="--from")] = None,
    fps: Fps = None,
    units: UnitOptions = UnitOptions(),
) -> int:
    """Draw rows on their film, and make figures and masks of them.

    The rows may be of any format that motes convert reads. What the file beside rows of motes
    remembers is used: frames, frame rate, scale, lens and ground, lines and zones. Otherwise it may
    be given.

    Parameters
    ----------
    source
        The video or images of the rows.
    rows
        The rows: of motes track, refine, smooth or watch, or another tool's.
    from_
        Format of the rows. [default: by content]
    """
    output, figures, masks = outputs.output, outputs.figures, outputs.masks
    if output is None and figures is None and masks is None:
        raise ConfigError("Nothing is to be made; give -o film.mp4, --figures or --masks FOLDER.")
    check_order(source, rows)
    for name in (source, str(rows)):
        check_not_source(name, output, figures, masks)
    if outputs.label is not None and (masks is None or masks.suffix.lower() != ".json"):
        raise ConfigError("--label is for masks in a document, as .json; omit it.")
    point_out_leftovers(output, masks)
    known = History.beside(rows)
    point_out_unfinished(rows, known)
    if fps is not None and known is not None and known.fps not in (None, fps):
        raise ConfigError(f"--fps is {fps:g}, and the rows are of {known.fps:g}; omit it.")
    with (
        _opened(source, fps, known) as film,
        prepared_folder(figures, [], outputs.overwrite),
        prepared_folder(masks and masks.parent, [], outputs.overwrite),
    ):
        say_rate(film)
        given = rows_in(rows, from_, film, source, known, identity)
        plane = _units(rows, units, known)
        if given.metres and known is None:
            refuse(units.given, f"for rows without metres, and {rows} has them")
        if output is None and not given.single:
            refuse(units.given, "for rows of one target, and for the speeds in a video, -o")
        check_size(plane, film.name, film.width, film.height)
        if given.single:
            opened = outputs.of_target(film, rows.stem, metres=plane is not None or given.metres)
            return run(film, opened, partial(target_moments, film, given, plane), Tally())
        regions = (known and known.places) or Regions()
        opened = outputs.of_objects(film, rows.stem, regions)
        counter = EventCounter(regions, (film.width, film.height))
        return run(film, opened, partial(object_moments, film, given, counter, plane), Tally())


def _units(rows: Path, options: UnitOptions, known: History | None) -> RealUnits | None:
    """Return how pixels become metres; None if they do not.

    Raises a ConfigError if another way is given than is remembered.
    """
    plane = options.units()
    if known is None or known.units is None:
        return plane
    if plane not in (None, known.units):
        refuse(options.given, beside(rows))
    return known.units


def _opened(source: str, fps: float | None, known: History | None) -> Source:
    """Return the film of rows, with the frames of their run.

    Raises an InputError if it is another film.
    """
    if not is_recorded(source):
        raise ConfigError(f"{source} is read once, as it comes; give the recording of these rows.")
    if known is None:
        return open_source(source, fps=fps)
    film = open_source(
        source, start=known.start, end=known.end, stride=known.stride, fps=known.fps or fps
    )
    try:
        known.check(film)
    except BaseException:
        film.close()
        raise
    return film


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
    path: Path,
    form: str | None,
    film: Source,
    source: str,
    known: History | None,
    identity: int | None,
) -> Given:
    """Return the rows in a file of any format, or those of one object with an identity.

    A single object is a target, unless a scene was watched and none was chosen. Raises a MotesError
    if the file cannot be read, has no such object, or is of another film than that of `source`,
    which is open.
    """
    form = form or registry.recognized(path)
    read = None if film.even_rate else Film.quickly(source)
    facts = FilmFacts(
        source=film.name, width=film.width, height=film.height, fps=film.fps, files=film.files,
        times=() if read is None else read.times,
    )  # fmt: skip
    recorded = registry.read(path, form, facts)
    if identity is not None:
        recorded = recorded.only(identity, path)
    rows = {row.frame: row for row in recorded}
    identities = {each.identity for row in rows.values() for each in row.objects}
    alone = len(identities) == 1 and ANONYMOUS not in identities
    watched = known is not None and known.places is not None and identity is None
    single = registry.FORMATS.resolve(form).single or (alone and not watched)
    timed = form in ("csv", "jsonl", "parquet", "journal")
    given = Given(path, rows, single, timed, recorded.stride)
    try:
        _check_rows(given, film, facts)
    except InputError:
        if read is None or not read.quick:
            raise
        # Times are those of its packets, which damage may have changed; they are decoded now.
        _check_rows(given, film, dataclasses.replace(facts, times=Film(source).times))
    return given


def _check_rows(given: Given, film: Source, facts: FilmFacts) -> None:
    """Raise an InputError if rows are of another film, by its times or, if known, its end."""
    end = len(facts.times) or math.inf
    for frame in given.rows:
        if frame < end:
            _check_time(given, film, frame, facts.time(frame))
    if facts.times:
        _check_end(given, film, len(facts.times) - 1)


def target_moments(
    film: Source, given: Given, units: RealUnits | None, frames: Iterator[Frame]
) -> Generator[Moment, None, None]:
    """Yield the moments of rows of one target."""
    places = _measured(given, units or PIXELS)
    for frame in _checked(frames, given, film):
        each = next(iter(given.objects(frame)), None)
        if each is None:
            yield Moment(frame, [Track.nowhere(frame.index, frame.time)])
        else:
            more = {**each.further, **places.get((each.identity, frame.index), {})}
            track = replace(each, time=frame.time, further=more)
            yield Moment(frame, [track], StepInfo(track))


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
    film: Source,
    given: Given,
    counter: EventCounter,
    units: RealUnits | None,
    frames: Iterator[Frame],
) -> Generator[Moment, None, None]:
    """Return the moments of several objects, with what they do at lines and in zones."""
    ends = {each.identity: row.frame for row in given.rows.values() for each in row.objects}

    def objects() -> Iterator[tuple[Frame, list[Track]]]:
        places = _measured(given, units, (film.width, film.height))
        later = _checked(frames, given, film)
        following = next(later, None)
        while following is not None:
            frame, following = following, next(later, None)
            tracks = []
            for each in given.objects(frame):
                if not each.placed:  # one that is marked as absent
                    continue
                more = {**each.further, **places.get((each.identity, frame.index), {})}
                # The box has all digits of the file; those of an ellipse are half as exact.
                ellipse = Ellipse.from_box(each.box)
                sought = following is None or frame.index < ends[each.identity]  # not gone yet
                tracks.append(
                    replace(each, time=frame.time, ellipse=ellipse, sought=sought, further=more)
                )
            yield frame, tracks

    return counted_moments(objects(), counter)


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
