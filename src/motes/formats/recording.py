"""The objects in all frames of a film, as every format is read into and written from."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Self

import numpy as np
from msgspec import structs

from motes.core.errors import ConfigError, FormatError
from motes.core.frame import FRAME_INTERVAL
from motes.core.geometry import FARTHEST
from motes.core.labels import check_label
from motes.core.track import Track
from motes.rows.schema import FrameRow, Header, text_name

MAX_FRAME = 10_000_000
"""Largest frame index that is accepted; about four days of video."""
MOST_FRAMES = 1_000_000
"""Frames in a row that a file may leave out at most; more than nine hours of film."""
LABEL = "object"
"""Default class of the objects."""
UNKNOWN = "unknown"
"""The name of a film that is not given."""
ANONYMOUS = -1
"""Identity of a detection: which object it shows is not known."""
UNTIMED = math.nan
"""The time of an object until `Recording.of` gives it that of its frame."""


@dataclass(frozen=True, slots=True)
class Recording:
    """The objects of a film, in memory."""

    head: Header
    frames: Sequence[FrameRow]
    """In order."""
    left_out: Sequence[str] = ()
    notes: Sequence[str] = ()
    """What of the file is not here, and how the rest was understood, each in a few words."""
    assumed: bool = False
    """Whether times are those of 25 frames a second, as no rate is known."""
    timed: bool = True
    """Whether the file has times of its own."""
    length: int = 0
    """The film's number of frames; 0 if unknown."""
    told: bool = False
    """Whether a frame that the file does not name is known to have no objects."""
    stride: int = 1
    """That of the run or task, which skips the frames in between."""
    listed: bool = False
    """Whether nobody has looked at other frames, as between keyframes: objects go on there."""
    ellipses: Collection[int] = ()
    """Identities of objects that were drawn as ellipses: these tell an angle, also one of 0."""

    @classmethod
    def of(
        cls,
        facts: FilmFacts,
        objects: Iterable[Track],
        times: Mapping[int, float | None] = {},
        size: tuple[int, int] | None = None,
        files: Mapping[int, str] = {},
        left_out: Sequence[str] = (),
        searched: Iterable[tuple[int, int]] = (),
        told: range = range(0),
    ) -> Self:
        """Return a recording of objects in frames, in any order; they get the times of these.

        A row without a class has the last one that another row names for its object.

        Raises a FormatError if a frame is negative, or larger than any film's, its time is none or
        before that of an earlier frame, or an object is there twice in a frame.

        Parameters
        ----------
        facts
            What is known of the film.
        objects
            The objects. Frames without any are there if `times` or `told` has them.
        times
            The times of frames in seconds; None, as far as the file does not hold them: then they
            follow from the frame rate, and from the times of the frames around.
        size
            Width and height in the file; else those of `facts`.
        files
            The names of the images of frames in the file; else those of `facts`.
        left_out
            What of the file is not here, in a few words each.
        searched
            Pairs of a frame and of the identity of an object that is searched for there, and has no
            place.
        told
            The frames of which the file tells all: nothing is in those that it does not name.
        """
        if told.stop > MAX_FRAME:
            raise FormatError(f"no film has {told.stop} frames")
        frames: dict[int, list[Track]] = {frame: [] for frame in (*times, *told)}
        there = set[tuple[int, int]]()
        objects = list(objects)
        named = {each.identity: each.label for each in objects if each.label}
        named.pop(ANONYMOUS, None)
        usual = None if facts.label == LABEL else facts.label
        for each in objects:
            frame = each.frame
            if each.identity != ANONYMOUS and (frame, each.identity) in there:
                raise FormatError(f"frame {frame} has the object {each.identity} twice")
            there.add((frame, each.identity))
            if each.label:
                check_label(each.label)
            if each.label is None and (label := named.get(each.identity) or usual):
                each = structs.replace(each, label=label)
            frames.setdefault(frame, []).append(each)
        missed: dict[int, list[int]] = {}
        for frame, identity in searched:
            missed.setdefault(frame, []).append(identity)
        for frame in frames:
            if not 0 <= frame <= MAX_FRAME:
                raise FormatError(f"no film has a frame {frame}")
        known = {frame: time for frame, time in times.items() if time is not None}
        for frame, time in known.items():
            if not abs(time) <= FARTHEST:
                raise FormatError(f"frame {frame} has the time {time:g}")
        for (one, before), (two, after) in pairwise(sorted(known.items())):
            if after < before:  # times that are rounded may be equal
                raise FormatError(f"frame {one} has the time {before:g}, and {two} {after:g}")
        if len(known) > 2 and len(same := {*known.values()}) == 1:
            raise FormatError(f"all frames have the time {same.pop():g}")
        if not facts.fps:
            facts = replace(facts, fps=rate_of(known))
        seconds = known | _between(known, [frame for frame in frames if frame not in known], facts)
        width, height = size or (facts.width, facts.height)
        return cls(
            Header(text_name(facts.source), width, height, facts.label),
            [
                FrameRow(
                    frame,
                    seconds[frame],
                    tuple(structs.replace(each, time=seconds[frame]) for each in frames[frame]),
                    files.get(frame) or facts.file(frame),
                    tuple(missed.get(frame, ())),
                )
                for frame in sorted(frames)
            ],
            left_out,
            assumed=not facts.fps and len(known) < len(frames),
            timed=bool(known),
            length=facts.frames or 0,
            told=bool(told),
        )

    def __iter__(self) -> Iterator[FrameRow]:
        return iter(self.frames)

    def only(self, identity: int, path: Path) -> Recording:
        """Return only the object with an identity; raise a ConfigError if `path` has none."""
        kept = [
            structs.replace(
                row,
                objects=tuple(each for each in row.objects if each.identity == identity),
                searched=tuple(each for each in row.searched if each == identity),
            )
            for row in self
        ]
        if not any(row.objects for row in kept):
            known = sorted({each.identity for row in self for each in row.objects})
            raise ConfigError(f"{path} has no object {identity}; it has {str(known[:20])[1:-1]}.")
        return replace(self, frames=kept)

    def only_object(self, what: str) -> dict[int, Track]:
        """Return the one object by frame, where it is visible.

        Raises a FormatError if there are several objects; `what` names the format.
        """
        found: dict[int, Track] = {}
        identity: int | None = None
        for row in self:
            for each in row.objects:
                if not each.visible:
                    continue
                identity = each.identity if identity is None else identity
                if each.identity != identity or row.frame in found:
                    raise FormatError(
                        f"{what} holds one object, and there are several; choose one with "
                        f"--identity N."
                    )
                found[row.frame] = each
        return found

    def following(self) -> dict[int, int]:
        """Return for each frame the next one; an object that is not there does not go on.

        It may be one that `frames` lacks, but none at which nobody has looked.
        """
        frames = [row.frame for row in self]
        ahead = MAX_FRAME if self.listed else self.stride
        after = {one: min(two, one + ahead) for one, two in pairwise(frames)}
        return after | {frame: frame + self.stride for frame in frames[-1:]}


@dataclass(frozen=True, slots=True, kw_only=True)
class FilmFacts:
    """What is known of the film that a file belongs to, as most formats do not hold it."""

    source: str = UNKNOWN
    """The film's name."""
    width: int = 0
    height: int = 0
    """Its size in pixels; 0 if unknown."""
    frames: int | None = None
    """Its number of frames; None if unknown."""
    fps: float | None = None
    """Its frames per second; None if unknown."""
    times: Sequence[float] = ()
    """The times of its frames in seconds; none where they follow from `fps`."""
    end: float | None = None
    """The time of its last frame in seconds; None if unknown, as where its rate is assumed."""
    label: str = LABEL
    """The class of objects without one."""
    files: Sequence[str] = ()
    """The paths of its images, by frame, as `Source.files`; none of a video."""
    run: range | None = None
    """The frames that a scene's run has seen; none of a target's run, or of one that was killed;
    None without a run."""

    def seen(self, last: int) -> range:
        """Return the frames that somebody has looked at, of a file that tells all it has seen.

        They are those of its run, or all up to the last frame that the file names; that the film
        is longer does not say that nothing is in the rest.
        """
        if self.run is not None:
            return self.run
        return range(last + 1 if self.frames else 0)

    def file(self, frame: int) -> str | None:
        """Return the path of a frame's image; None for a video."""
        return text_name(self.files[frame]) if frame < len(self.files) else None

    def time(self, frame: int) -> float:
        """Return the time of a frame in seconds; after the known ones, by the frame rate."""
        if frame < len(self.times):
            return self.times[frame]
        last = max(len(self.times) - 1, 0)
        further = (frame - last) / self.fps if self.fps else (frame - last) * FRAME_INTERVAL
        return self.times[last] + further if self.times else further


def stride_of(frames: Sequence[int]) -> int:
    """Return the stride of frames in order, which three of them tell at least."""
    return math.gcd(*(two - one for one, two in pairwise(frames))) if len(frames) > 2 else 1


def searched_in(frames: Iterable[int], objects: Iterable[Track]) -> list[tuple[int, int]]:
    """Return what `Recording.of` takes as `searched` for frames that show objects without a place.

    Only frames without any of the `objects` need it, which would else be taken for empty ones.
    """
    return [(frame, ANONYMOUS) for frame in {*frames} - {each.frame for each in objects}]


def are_samples(frames: Sequence[int]) -> bool:
    """Return whether frames in order are picked from a film one by one.

    The smallest distance between two is then more than their stride: nobody has looked in between.
    """
    apart = min((two - one for one, two in pairwise(frames)), default=0)
    return apart > stride_of(frames)


def rate_of(known: Mapping[int, float]) -> float | None:
    """Return the frames per second of the times of frames; None if they do not tell it."""
    first, last = min(known, default=0), max(known, default=0)
    begin, end = known.get(first, 0.0), known.get(last, 0.0)
    if first == last:  # one time: that of the first frame is 0
        first, begin = 0, 0.0
    return (last - first) / (end - begin) if last > first and end > begin else None


def _between(
    known: Mapping[int, float], frames: Sequence[int], facts: FilmFacts
) -> dict[int, float]:
    """Return the times of frames: those of the film, as late there as the known ones around.

    Known times have six digits; what is less late is not late.
    """
    places = sorted(known)
    late = [round(known[frame] - facts.time(frame), 6) for frame in places]
    by = np.interp(frames, places, late).tolist() if places else [0.0] * len(frames)
    return {frame: facts.time(frame) + each for frame, each in zip(frames, by, strict=True)}


def sound(each: Track) -> Track:
    """Return an object of a file; raise a ValueError if it has no place, size or confidence."""
    if not all(abs(value) <= FARTHEST for value in (*each.ellipse, *each.box, each.confidence)):
        raise ValueError("a number of the object is not finite, or too large")
    if not 0 <= each.confidence <= 1:
        raise ValueError(f"confidence is {each.confidence:g}; it is a probability, 0 to 1")
    if not min(each.ellipse.a, each.ellipse.b) > 0:
        width, height = 2 * each.ellipse.a, 2 * each.ellipse.b
        raise ValueError(f"an object of {width:g}x{height:g} pixels has no area")
    return each


def frames_between(first: int, last: int) -> range:
    """Return the frames between two keyframes, which a tool interpolates.

    Raises a FormatError if no film has such a frame, or there are too many in between: a number is
    damaged.
    """
    if not 0 <= first <= last <= MAX_FRAME or last - first > MOST_FRAMES:
        raise FormatError(f"frames {first} and {last} cannot be neighboring keyframes of a film")
    return range(first + 1, last)
