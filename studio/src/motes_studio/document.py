"""The document of a session: all that a person has drawn. Every change makes a new document."""

from __future__ import annotations

import bisect
from collections.abc import Callable, Container, Iterable, Sequence
from typing import Any

import msgspec
from msgspec import UNSET
from msgspec.structs import replace

from motes import Box, ConfigError, Ellipse, Regions, TrackerConfig, configure, preset
from motes.core import as_region, from_toml, region_within
from motes_studio import commands, messages
from motes_studio.commands import Places, Region
from motes_studio.messages import OpenFilm

MAX_OBJECTS = 50


class DrawnTarget(messages.Subject, frozen=True, kw_only=True):
    """An object."""

    keys: dict[int, Region]
    """The drawn regions, by frame."""
    imported: str = ""
    """The name of the rows that a file has brought, which no object drawn alike has; else empty."""

    @property
    def tracker(self) -> TrackerConfig:
        """The configuration of the tracker."""
        return tracker_of(self.preset, self.config)

    @property
    def made_by(self) -> tuple[str, str | None, int]:
        """What its rows depend on beside its marks: the tracker and the seed."""
        return self.preset, self.config, self.seed

    @property
    def boxed(self) -> bool:
        """Whether all drawn regions are boxes."""
        return all(len(region) == 4 for region in self.keys.values())

    @property
    def frames(self) -> range:
        """The frames of the object."""
        return range(self.first, self.last + 1)

    @property
    def marks(self) -> dict[int, Box | Ellipse | None]:
        """The keyframes, as the library takes them."""
        drawn = {frame: as_region(region) for frame, region in self.keys.items()}
        return dict(sorted({**drawn, **dict.fromkeys(self.absences)}.items()))

    @property
    def absences(self) -> set[int]:
        """The frames of absences."""
        return {frame for first, last in self.absent for frame in range(first, last + 1)}


class Document(msgspec.Struct, frozen=True):
    """What a person has drawn in a film."""

    targets: tuple[DrawnTarget, ...] = ()
    """The objects."""
    places: Places = Places()
    """Lines, zones and the ground."""
    following: int = 1
    """The number of the next object."""

    def target(self, number: int) -> DrawnTarget:
        """Return an object; raise a ConfigError if there is none of this number."""
        for each in self.targets:
            if each.object == number:
                return each
        raise ConfigError(f"There is no object {number}; it may have been removed.")

    @property
    def effort(self) -> float:
        """Corrections for each 100 frames of objects."""
        frames = sum(len(each.frames) for each in self.targets)
        return 100 * sum(each.corrections for each in self.targets) / frames if frames else 0.0


RowAt = Callable[[int, int], Region | None]
"""The place of an object in a frame, from its rows; None where there is none."""


def tracker_of(name: str, toml: str | None) -> TrackerConfig:
    """Return the configuration of a preset, changed by the text of a file.

    Raises
    ------
    ConfigError
        For an unknown preset or key, or a value that does not fit.
    """
    base = preset(name)
    return base if toml is None else configure(base, from_toml(toml, "the configuration"))


def regions_of(places: Places) -> Regions:
    """Return places as the library takes them; raise a ConfigError if they make no sense."""
    return Regions.parse(places_toml(places))


def places_toml(places: Places) -> str:
    """Return places as the TOML of `motes watch --places`."""
    values: dict[str, Any] = {"line": places.lines, "zone": places.zones}
    if places.ground is not None:
        values["ground"] = {"points": places.ground}
    values = msgspec.to_builtins(values)
    for zone in values["zone"]:
        if zone["dwell"] is None:  # TOML has no null
            del zone["dwell"]
    return msgspec.toml.encode(values).decode()


def changed(
    document: Document,
    command: commands.Command,
    film: OpenFilm,
    row_at: RowAt,
    networks: Container[str] = (),
) -> tuple[Document, int | None]:
    """Return the document after a command, and the number of an object that is new or changed.

    A configuration may name the files `networks` and no others: a page is not to learn which files
    this computer has, nor to choose what is read.

    Raises
    ------
    ConfigError
        If the command makes no sense here.
    """
    match command:
        case commands.AddObject():
            return _added(document, command, film, networks)
        case commands.ChangeObject():
            names = ("name", "color", "preset", "config", "seed")
            given = {name: getattr(command, name) for name in names}
            given = {name: value for name, value in given.items() if value is not UNSET}
            target = replace(document.target(command.object), **given)
            _check_tracker(target, networks)
            if not target.name.strip():
                raise ConfigError("An object needs a name; give it one.")
            return _with(document, target), target.object
        case commands.RemoveObject():
            return _without(document, document.target(command.object)), None
        case commands.SetKeyframe():
            return _marked(document, command, film)
        case commands.RemoveKeyframe():
            return _unmarked(document, command)
        case commands.SetAbsent():
            return _absent(document, command)
        case commands.Split():
            return _split(document, command, row_at)
        case commands.Join():
            return _joined(document, command)
        case commands.SetPlaces():
            regions_of(command.places)
            return replace(document, places=command.places), None
        case _:
            raise ConfigError("This command changes nothing.")


def asks_no_tracker(document: Document, command: commands.Command) -> bool:
    """Return whether an object has the same places after a command, as far as it is there."""
    if isinstance(command, commands.RemoveKeyframe):  # of an absence
        return command.frame not in document.target(command.object).keys
    return isinstance(command, commands.Split | commands.Join | commands.SetAbsent)


def _with(document: Document, target: DrawnTarget) -> Document:
    targets = (target if each.object == target.object else each for each in document.targets)
    return replace(document, targets=tuple(targets))


def _without(document: Document, target: DrawnTarget) -> Document:
    left = (each for each in document.targets if each.object != target.object)
    return replace(document, targets=tuple(left))


def appended(document: Document, target: DrawnTarget) -> Document:
    """Return the document with a further object; raise a ConfigError if there are too many."""
    if len(document.targets) >= MAX_OBJECTS:
        raise ConfigError(f"A session has {MAX_OBJECTS} objects at most; open another one.")
    return replace(document, targets=(*document.targets, target), following=document.following + 1)


def _check_tracker(target: DrawnTarget, networks: Container[str]) -> None:
    network = getattr(target.tracker, "network", None)
    if network is not None and not all(file in networks for file in network.files):
        raise ConfigError(
            "The configuration names a network that this studio was not started with; its owner "
            "names files with motes studio --network."
        )


def _added(
    document: Document, command: commands.AddObject, film: OpenFilm, networks: Container[str]
) -> tuple[Document, int]:
    check_frame(command.frame, range(film.frames))
    region_within(command.region, film.width, film.height)
    number = document.following
    target = DrawnTarget(
        number, command.name.strip() or f"Object {number}", command.color, command.preset,
        command.config, command.seed, 0, film.frames - 1, keys={command.frame: command.region},
    )  # fmt: skip
    _check_tracker(target, networks)
    return appended(document, target), number


def check_frame(frame: int, frames: range) -> None:
    """Raise a ConfigError unless a frame is among those of an object."""
    if frame not in frames:
        raise ConfigError(
            f"Frame {frame} is not of the object, which has {frames.start} to {frames.stop - 1}."
        )


def _marked(
    document: Document, command: commands.SetKeyframe, film: OpenFilm
) -> tuple[Document, int]:
    target = document.target(command.object)
    check_frame(command.frame, target.frames)
    region_within(command.region, film.width, film.height)
    target = replace(
        target,
        keys=dict(sorted({**target.keys, command.frame: command.region}.items())),
        absent=ranges(target.absences - {command.frame}),
        corrections=target.corrections + 1,
    )
    return _with(document, target), target.object


def _unmarked(document: Document, command: commands.RemoveKeyframe) -> tuple[Document, int]:
    target = document.target(command.object)
    if command.frame not in target.keys.keys() | target.absences:
        raise ConfigError(f"Frame {command.frame} is not marked.")
    keys = {frame: region for frame, region in target.keys.items() if frame != command.frame}
    if not keys:
        raise ConfigError("An object needs a keyframe; remove the object instead.")
    absent = ranges(target.absences - {command.frame})
    return _with(document, replace(target, keys=keys, absent=absent)), target.object


def _absent(document: Document, command: commands.SetAbsent) -> tuple[Document, int]:
    target, first, last = document.target(command.object), command.first, command.last
    if last < first:
        raise ConfigError(f"The frames {first} to {last} are no range; the first one comes first.")
    check_frame(first, target.frames)
    check_frame(last, target.frames)
    keys = {frame: each for frame, each in target.keys.items() if not first <= frame <= last}
    if not keys:
        raise ConfigError("The object would have no keyframe; draw it in another frame first.")
    absent = ranges(target.absences | {*range(first, last + 1)})
    target = replace(target, keys=keys, absent=absent, corrections=target.corrections + 1)
    return _with(document, target), target.object


def ranges(frames: Iterable[int]) -> tuple[tuple[int, int], ...]:
    """Return the first and last frames of runs of frames, in order."""
    found: list[tuple[int, int]] = []
    for frame in sorted(frames):
        if found and frame == found[-1][1] + 1:
            found[-1] = found[-1][0], frame
        else:
            found.append((frame, frame))
    return tuple(found)


def _part(target: DrawnTarget, first: int, last: int) -> DrawnTarget:
    """Return an object with a part of its frames, and the marks in them."""
    keys = {frame: each for frame, each in target.keys.items() if first <= frame <= last}
    absent = ranges(target.absences & {*range(first, last + 1)})
    return replace(target, first=first, last=last, keys=keys, absent=absent)


def _with_keyframe(target: DrawnTarget, frame: int, row_at: RowAt) -> DrawnTarget:
    """Return an object with a keyframe: if it has none, its place in a frame."""
    if target.keys:
        return target
    region = row_at(target.object, frame)
    if region is None:
        raise ConfigError(
            f"{target.name} has no place in frame {frame}; draw it there, or track it first."
        )
    return replace(target, keys={frame: region})


def _split(document: Document, command: commands.Split, row_at: RowAt) -> tuple[Document, int]:
    target, frame = document.target(command.object), command.frame
    if frame not in target.frames[1:]:
        raise ConfigError(f"{target.name} cannot be split at frame {frame}; choose a later one.")
    after = _with_keyframe(_part(target, frame, target.last), frame, row_at)
    before = _with_keyframe(_part(target, target.first, frame - 1), frame - 1, row_at)
    number = document.following
    before = replace(before, corrections=before.corrections + 1)
    after = replace(after, object=number, name=f"{target.name} (2)", corrections=0)
    return appended(_with(document, before), after), number


def _joined(document: Document, command: commands.Join) -> tuple[Document, int]:
    one, other = document.target(command.object), document.target(command.other)
    if one.object == other.object:
        raise ConfigError("An object cannot be joined with itself; choose another one.")
    both = set(one.keys) & set(other.keys)
    if clash := [frame for frame in both if one.keys[frame] != other.keys[frame]]:
        raise ConfigError(
            f"{one.name} and {other.name} differ in frame {min(clash)}; remove a keyframe there."
        )
    keys = dict(sorted({**one.keys, **other.keys}.items()))
    target = replace(
        one,
        first=min(one.first, other.first),
        last=max(one.last, other.last),
        keys=keys,
        absent=ranges((one.absences | other.absences) - keys.keys()),
        corrections=one.corrections + other.corrections + 1,
    )
    return _with(_without(document, other), target), one.object


def renumbered(document: Document, before: Sequence[float], times: Sequence[float]) -> Document:
    """Return a document for a film that is read otherwise: each frame is the one nearest in time.

    The times of the frames were `before`, and are now `times`.
    """

    def nearest(frame: int) -> int:
        after = bisect.bisect_left(times, before[frame], hi=len(times) - 1)
        earlier = after > 0 and before[frame] - times[after - 1] < times[after] - before[frame]
        return after - earlier

    targets = (
        replace(
            each,
            first=nearest(each.first),
            last=nearest(each.last),
            keys={nearest(frame): region for frame, region in each.keys.items()},
            absent=tuple((nearest(first), nearest(last)) for first, last in each.absent),
        )
        for each in document.targets
    )
    return replace(document, targets=tuple(targets))
