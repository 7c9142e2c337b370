"""`motes track` frame by frame: one object, or several, from the first frame on."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Generator, Iterable, Sequence
from functools import partial
from pathlib import Path

from motes.cli.annotated_video import Painter, ScenePainter, TargetPainter
from motes.cli.app import part
from motes.cli.frame_loop import Moment, Tally, run
from motes.cli.input_checks import check_several, point_out_meant
from motes.cli.option_groups import say_rate
from motes.cli.outputs import Request
from motes.cli.streams import log
from motes.cli.track_options import Begin
from motes.cli.track_units import check_size, placed_by
from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.track import Status, Track
from motes.mot.analytics.real_units import GroundMotion
from motes.mot.analytics.regions import Regions
from motes.rows.schema import FORMS
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import TrackerConfig
from motes.sot.tracker import Tracker
from motes.sot.trackers import Trackers
from motes.video.cuts import PictureChanges
from motes.video.sources import Source

LISTED = 6
"""Most losses and recoveries that are listed."""


def track_one(asked: Request[TrackerConfig], begin: Begin, figures: Path | None) -> int:
    """Track one object, with the figures of the papers in a folder; return the exit code."""
    tracker = Tracker(asked.config, asked.seed)
    chooses = isinstance(tracker.config, ParticleFilter) and tracker.config.budget is not None
    moments, tally = partial(follow, tracker, begin), TargetTally(budget=chooses)
    return _tracked(asked, moments, TargetPainter(metres=asked.units is not None), tally, figures)


def track_several(asked: Request[TrackerConfig], regions: Sequence[Sequence[float]]) -> int:
    """Track the objects in regions of the first frame; their identities count from 1."""
    if asked.goal is not None:
        check_several(asked.goal.form)
    moments = partial(_follow_several, Trackers(asked.config, asked.seed), regions)
    return _tracked(asked, moments, ScenePainter(Regions()), ObjectsTally(len(regions)))


def _tracked(
    asked: Request[TrackerConfig],
    moments: Callable[..., Generator[Moment, None, None]],
    painter: Painter,
    tally: Tally,
    figures: Path | None = None,
) -> int:
    """Write the outputs of a run, with metres if there are units; return the exit code.

    `moments` takes the frames, and the `motion` that is measured, or None.
    Raises a ConfigError if an option makes no sense with the source or the output.
    """
    goal, units = asked.goal, asked.units
    if asked.resume and goal is not None and goal.form not in FORMS.values():
        raise ConfigError(f"--resume continues rows; {goal.name} holds none, make it anew.")
    with asked.frames.open(asked.source) as film:
        if asked.resume and film.live:
            raise ConfigError(f"{film.name} is live and cannot be read again; omit --resume.")
        check_size(units, film.name, film.width, film.height)
        say_rate(film)
        say_alone(film)
        opened = asked.pictures(film, painter)
        if figures is not None:
            drawn = part("figures", "--figures", "lab")
            opened.append(drawn(figures, asked.config, overwrite=asked.overwrite))
        opened += asked.rows_and_history(film)
        motion = None if units is None else GroundMotion(units)
        quiet = goal is not None and goal.name == "-" and sys.stdout.isatty()
        return run(
            film, opened, partial(moments, motion=motion), tally, label=asked.outputs.label,
            quiet=quiet,
        )  # fmt: skip


def follow(
    tracker: Tracker, begin: Begin, frames: Iterable[Frame], motion: GroundMotion | None
) -> Generator[Moment, None, None]:
    """Yield a moment for each frame, with the place on the ground where motion is measured."""
    begun = False
    for frame in frames:
        clock = time.perf_counter()
        if begun:
            tracker.update(frame)
        else:
            begun = begin(tracker, frame) is not None
        info, seconds = tracker.info if begun else None, time.perf_counter() - clock
        tracks: Sequence[Track] = [info.track if info else Track.nowhere(frame.index, frame.time)]
        yield Moment(frame, placed_by(motion, tracks) if motion else tracks, info, seconds)


def _follow_several(
    trackers: Trackers,
    regions: Sequence[Sequence[float]],
    frames: Iterable[Frame],
    motion: GroundMotion | None,
) -> Generator[Moment, None, None]:
    """Yield a moment for each frame, as `follow`."""
    for frame in frames:
        clock = time.perf_counter()
        begun = bool(trackers.each)
        tracks: Sequence[Track] = trackers.update(frame) if begun else trackers.init(frame, regions)
        seconds = time.perf_counter() - clock
        for region, tracker in () if begun else zip(regions, trackers.each, strict=True):
            point_out_meant(region, frame.width, frame.height)
            if tracker.info.note is not None:
                log(tracker.info.note)
        yield Moment(frame, placed_by(motion, tracks) if motion else tracks, None, seconds)


def say_alone(film: Source) -> None:
    """Print that nothing is followed in a frame alone, such as a photo."""
    if film.frame_count == 1:
        log(
            f"{film.name}: One frame is read, in which nothing is followed; give a film, or a "
            f"folder or pattern of images."
        )


class Losses:
    """In how many frames an object was tracked, and when it was lost and found again."""

    def __init__(self) -> None:
        self.tracked = 0
        self._told: list[str] = []
        self._last: Status | None = None
        self._lost_since: float | None = None
        self._away = 0.0

    def add(self, track: Track) -> None:
        """Count a frame."""
        last, self._last = self._last, track.status
        self.tracked += track.status is Status.TRACKING
        if last is None:
            return
        if track.status is Status.LOST:
            self._told.append(f"lost at frame {track.frame}")
            self._lost_since = track.time
        elif track.status is Status.TRACKING and last is not Status.TRACKING:
            self._told.append(f"found at frame {track.frame}")
            if self._lost_since is not None:
                self._away = max(self._away, track.time - self._lost_since)

    def told(self) -> list[str]:
        """Return the changes that the summary names."""
        told = self._told[:LISTED]
        if len(self._told) > LISTED:
            told.append(f"{len(self._told) - LISTED} more changes")
        if self._away > 1:
            told.append("found after more than a second, look whether it is the same one")
        return told


class TargetTally(Tally):
    """Statistics of a run with one object.

    `budget` is whether the tracker chooses its number of particles.
    """

    def __init__(self, *, budget: bool = False) -> None:
        super().__init__()
        self._budget = budget
        self._updates = self._particles = 0
        self._seconds = 0.0
        self._range = (sys.maxsize, 0)
        self._before: Moment | None = None
        self._target = Losses()
        self._pictures, self._cuts = PictureChanges(), list[str]()

    @property
    def missing(self) -> str | None:
        """What to say if the target was never tracked."""
        if self._target.tracked:
            return None
        return "The target was never found; look for another one, or elsewhere."

    def add(self, moment: Moment) -> str:
        """Count a frame; return the state of the target."""
        super().add(moment)
        status = moment.target.status
        self._target.add(moment.target)
        if self._pictures.update(moment.frame) == "cut":
            self._cuts.append(str(moment.frame.index))
        if self._before is not None and self._before.info is not None:
            self._updates += 1  # the first frame includes the start
            self._seconds += moment.seconds
            count = len((moment.info or self._before.info).weights)
            self._particles += count
            self._range = min(self._range[0], count), max(self._range[1], count)
        self._before = moment
        return f"{status} {moment.target.confidence:.2f}" if moment.info else status

    def __str__(self) -> str:
        parts = [super().__str__(), f"tracked in {100 * self._target.tracked / self.frames:.1f} %"]
        if self._updates:
            parts.append(f"tracker {1000 * self._seconds / self._updates:.2f} ms a frame")
        if self._updates and self._budget:
            (least, most), mean = self._range, self._particles / self._updates
            varied = f"{least} to {most} particles, {mean:.0f} on average"
            parts.append(varied if least < most else f"{most} particles")
        if self._cuts:
            parts.append(f"in doubt from the film's cut at frame {' and '.join(self._cuts)} on")
        return ", ".join(parts + self._target.told())


class ObjectsTally(Tally):
    """Statistics of a run with several objects."""

    def __init__(self, objects: int) -> None:
        super().__init__()
        self._each = [Losses() for _ in range(objects)]
        self._seconds = 0.0

    def add(self, moment: Moment) -> str:
        """Count a frame; return how many objects are tracked."""
        if self.frames:  # the first frame includes the start
            self._seconds += moment.seconds
        super().add(moment)
        for each, track in zip(self._each, moment.tracks, strict=True):
            each.add(track)
        seen = [each.status is Status.TRACKING for each in moment.tracks]
        return f"{sum(seen)} of {len(seen)} tracked"

    def __str__(self) -> str:
        parts = [super().__str__()]
        for i, each in enumerate(self._each, start=1):
            parts.append(f"object {i} tracked in {100 * each.tracked / self.frames:.1f} %")
            if told := each.told():
                parts[-1] += f" ({', '.join(told)})"
        if self.frames > 1:
            parts.append(f"trackers {1000 * self._seconds / (self.frames - 1):.2f} ms a frame")
        return ", ".join(parts)
