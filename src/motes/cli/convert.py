"""`motes convert`: tracks, annotations and truth from one format into another."""

from __future__ import annotations

import dataclasses
from collections import Counter, defaultdict
from collections.abc import Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Group, Parameter
from msgspec.structs import replace

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import (
    check_guesses,
    check_keyframe_error,
    check_label,
    check_not_source,
    check_place,
    format_of,
    point_out_leftovers,
    point_out_unfinished,
)
from motes.cli.option_groups import (
    FLAG,
    OUTPUT,
    FileName,
    KeyframeError,
    OutputFile,
    Overwrite,
    Whole,
    WithGuesses,
)
from motes.cli.streams import log
from motes.cli.track_units import UnitOptions, check_size
from motes.core.errors import ConfigError, InputError, counted
from motes.core.files import writing

if TYPE_CHECKING:
    from motes.core.track import Track
    from motes.correction.history import History
    from motes.formats.recording import FilmFacts, Recording
    from motes.mot.analytics.real_units import Columns, RealUnits
    from motes.rows.schema import FrameRow

app = App(name="convert", help_format="plaintext")
FILM = Group("Film (what the file does not contain)", sort_key=3)
FORMS = Group("Formats", sort_key=1)
SAID = 5
"""Kinds of things left out that are named; the others are counted."""


@app.default
def convert(
    rows: Path | None = None,
    target: Path | None = None,
    /,
    *,
    output: OutputFile = None,
    from_: Annotated[str | None, Parameter(name="--from", group=FORMS)] = None,
    to: Annotated[str | None, Parameter(group=FORMS)] = None,
    list_: Annotated[bool, FLAG, Parameter(name="--list", group=FORMS)] = False,
    video: Annotated[FileName | None, Parameter(group=FILM)] = None,
    size: Annotated[str | None, Parameter(group=FILM)] = None,
    fps: Annotated[float | None, Parameter(group=FILM)] = None,
    frames: Annotated[Whole | None, Parameter(group=FILM)] = None,
    units: UnitOptions = UnitOptions(),
    label: Annotated[str, Parameter(group=OUTPUT)] = "object",
    identity: Annotated[Whole | None, Parameter(group=OUTPUT)] = None,
    keyframe_error: KeyframeError = None,
    with_guesses: WithGuesses = False,
    overwrite: Overwrite = False,
) -> int:
    """Convert tracks, annotations or truth from one format into another.

    The formats are recognized, by the content of the first file and the name of the second. What
    the second format cannot hold is printed. docs/formats.md describes the formats.

    The rows that a killed run of motes track or motes watch has left, in NAME.json.rows.jsonl, are
    one of the formats: this command makes the document of them.

    Parameters
    ----------
    rows
        The file or folder to read.
    target
        The file or folder to make.
    output
        File to make; the same as TARGET.
    from_
        Format to read. [default: by content]
    to
        Format to write. [default: by name]
    list_
        List the formats and exit.
    video
        The film: for its size, its number of frames, its rate and the names of its images.
    size
        Width and height of the film, as 640x480.
    fps
        Frames per second.
    frames
        Number of frames.
    label
        Class of the objects that have none in the first file.
    identity
        Take only the object with this identity.
    """
    from motes.cli.outputs import guesses_told, say_how_to_train
    from motes.correction.history import History, check_beside, hand_on
    from motes.formats import mot, registry
    from motes.formats.recording import LABEL
    from motes.formats.visibility import SHOWN, TIMES, aspects
    from motes.video.image_files import IMAGE_ENDINGS

    if list_:
        print("\n".join(_table()))
        return DONE
    if output is not None and target not in (None, output):
        raise ConfigError(f"{target} and {output} are two files to make; give one.")
    target = output or target
    if rows is None or target is None:
        raise ConfigError("Two names are needed, as in motes convert rows.csv tracks.xml.")
    form = format_of(str(target), to)
    check_keyframe_error(keyframe_error, form)
    check_guesses(form, wanted=with_guesses)
    check_not_source(str(rows), target)
    source = from_ or registry.recognized(rows)
    check_label(None if label == LABEL else label, form)
    known = History.beside(rows) if source in ("csv", "jsonl") else None
    point_out_unfinished(rows, known)
    facts = _facts(video, size, fps, frames, label, known)
    recorded = registry.read(rows, source, facts)
    _check_times(recorded, rows, facts, fps)
    tracked = any(isfinite(each.distance) for row in recorded for each in row.objects)
    if video is not None and (known is not None or (tracked and facts.end is not None)):
        _check_run(recorded, rows, facts, video)
    if identity is not None:
        recorded = recorded.only(identity, rows)
        known = known and known.of(identity)
    if plane := units.units():
        recorded = _measured(recorded, plane, form)
        known = known and replace(known, units=plane)
    check_place(str(target), form, overwrite)
    point_out_leftovers(target)
    check_beside(target, overwrite)
    with writing(target):
        made = registry.write(target, form, recorded, keyframe_error, guesses=with_guesses)
    hand_on(known if form in ("csv", "jsonl") else None, target)
    written = registry.FORMATS.resolve(form)
    there = sum(bool(row.objects or row.searched) for row in recorded)
    part = f"{there - made.missed} of the" if made.missed else "the"
    count = counted(there, "frame")
    own = source in ("csv", "jsonl") and (known is None or known.places is None)
    reason = f"; in the others a target is {made.missed_told}" * (made.missed > 0)
    reason += ": motes refine corrects that, or marks it as absent" * (made.missed > 0 and own)
    reason += guesses_told(made)
    if empty := len(recorded.frames) - there:
        reason += f"; nothing is in {counted(empty, 'other frame')} of its film"
    log(f"wrote {target} ({written.title}) with {part} {count} in {rows}{reason}.")
    if left_out := recorded.left_out:
        more = f", and {len(left_out) - SAID} more" * (len(left_out) > SAID)
        log(f"left out of {rows}: {'; '.join(left_out[:SAID])}{more}.")
    for note in recorded.notes:
        log(f"{rows}: {note}")
    if recorded.assumed and TIMES in written.holds:
        log(
            f"{rows} has no times, 25 frames a second are assumed; give --fps, or a --video with "
            f"times."
        )
    ended = bool(recorded.length) or (known is not None and known.end is None)  # with its film
    last = (each.status in SHOWN for row in recorded.frames[-1:] for each in row.objects)
    if form == "cvat" != source and not ended and any(last):
        log(
            f"{rows} does not tell how long its film is: in CVAT an object of its last frame "
            f"stays to the end of the task; give --video or --frames."
        )
    say_how_to_train(target, form, recorded)
    film = "" if known is None or facts.files else known.film
    of_images = Path(film).suffix.lower() in {"", *IMAGE_ENDINGS}
    if form in ("coco", "yolo") and film and recorded.frames and of_images:
        first = f"frame_{recorded.frames[0].frame:06d}.png"
        log(
            f"the images of {film} are called {first} and so on in {target}; give --video "
            f"FOLDER for their own names."
        )
    if lost := registry.lost(aspects(recorded), source, form):
        log(f"{form} does not hold {', '.join(lost)}; {rows} has them.")
    names = {(each.identity, each.label) for row in recorded for each in row.objects if each.label}
    ways = Counter(identity for identity, _ in names if identity >= 0)
    changing = [identity for identity, count in ways.items() if count > 1]
    if form in ("coco", "cvat", "label-studio") and known is None and changing:
        log(
            f"{rows} has several classes for object {min(changing)}; {form} has that of its last "
            f"row."
        )
    if form in ("mot", "mot-truth") and (others := mot.numberless(recorded)):
        more = f" and {len(others) - SAID} more" * (len(others) > SAID)
        named = ", ".join(map(repr, others[:SAID]))
        log(f"{form} has no class {named}{more}; it writes -1.")
    return DONE


def _table() -> list[str]:
    """Return a line for each format."""
    from motes.formats.registry import FORMATS

    lines = [f"{'format':18}{'from':6}{'to':4}{'endings':32}content"]
    for name, each in FORMATS.usable().items():
        read, written = ("yes" if way else "" for way in (each.read, each.write))
        lines.append(f"{name:18}{read:6}{written:4}{' '.join(each.endings):32}{each.title}")
    return lines


def _facts(
    video: str | None,
    size: str | None,
    fps: float | None,
    frames: int | None,
    label: str,
    known: History | None,
) -> FilmFacts:
    """Return the facts of the film: by the options, by the film, or as known beside the rows."""
    from motes.formats.recording import UNKNOWN, FilmFacts

    if fps is not None and not 0 < fps < float("inf"):
        raise ConfigError(f"--fps is {fps:g}; give a number of frames per second.")
    if frames is not None and frames < 1:
        raise ConfigError(f"--frames is {frames}; give 1 or more.")
    width, height = given = _sides(size)
    fps = fps or (known.fps if known is not None else None)
    name, known_frames, end = UNKNOWN, None, None
    files: Sequence[str] = ()
    times: Sequence[float] = ()
    even = fps is not None  # then they follow from the rate
    rated = even or known is not None  # whose times are checked otherwise
    if video is not None:
        from motes.video.film import Film
        from motes.video.sources import is_recorded, open_source

        with open_source(video, fps=fps) as film:
            if known is not None:  # the run has said already where times leap
                known.check(film)
            elif film.report.leap is not None:
                log(f"{film.name}: {film.report.leap}")
            name, fps, known_frames = film.name, film.fps, film.frame_count
            files = film.files
            width, height = film.width, film.height
        if is_recorded(video):  # what a container tells may be an estimate
            quick = Film.quickly(video)
            known_frames = len(quick.times)
            times = () if even or quick.even_rate else quick.times
            end = quick.times[-1] if not (rated or quick.report.assumed) else None
    elif known is not None:
        name, known_frames = known.film, known.frames
        width, height = known.width, known.height
    if frames and known_frames and frames > known_frames:
        raise ConfigError(f"--frames is {frames}, and {name} has {known_frames}; omit it.")
    if size and given != (width, height):
        raise ConfigError(f"--size is {size}, and the film has {width}x{height}; omit it.")
    run = None
    if known is not None:
        told = known.last if known.places is not None else None
        run = range(known.start, 0 if told is None else told + 1, known.stride)
    return FilmFacts(
        source=name, width=width, height=height, frames=frames or known_frames, fps=fps,
        end=end, label=label, files=files, run=run, times=times,
    )  # fmt: skip


def _sides(size: str | None) -> tuple[int, int]:
    if size is None:
        return 0, 0
    width, _, height = size.lower().partition("x")
    if not (width.isdigit() and height.isdigit() and int(width) and int(height)):
        raise ConfigError(f"--size is {size!r}; give width and height as 640x480.")
    return int(width), int(height)


def _check_times(recorded: Recording, rows: Path, facts: FilmFacts, fps: float | None) -> None:
    """Raise a ConfigError if --fps is given, and the objects have other times of their own."""
    later = [row for row in recorded if row.frame]
    if fps and later and all(abs(row.time - facts.time(row.frame)) > 1e-6 for row in later):
        raise ConfigError(
            f"--fps is {fps:g}, and {rows} has times of its own, in seconds; omit it, or remove "
            f"these times from a copy."
        )


def _check_run(recorded: Recording, rows: Path, facts: FilmFacts, video: str) -> None:
    """Raise an InputError if what motes has followed has other times than the film that is given.

    What others have made may have times that are less exact.
    """
    from motes.correction.rows import TIME_TOLERANCE
    from motes.video.film import Film
    from motes.video.sources import is_recorded

    def other(film: FilmFacts) -> FrameRow | None:
        seen = (row for row in recorded if row.objects)
        return next((r for r in seen if abs(r.time - film.time(r.frame)) > TIME_TOLERANCE), None)

    row = other(facts) if is_recorded(video) else None  # what is live is another film by now
    if row is not None and facts.times:  # damage may have changed them
        facts = dataclasses.replace(facts, times=Film(video).times)
        row = other(facts)
    if row is not None:
        raise InputError(
            f"{rows} has frame {row.frame} at {row.time:g} s, but {facts.source} at "
            f"{facts.time(row.frame):g} s; give the film of these rows or its --fps."
        )


def _measured(recorded: Recording, plane: RealUnits, form: str) -> Recording:
    """Return the objects with places and speeds in metres, in hindsight; old ones go.

    Raises a ConfigError if the format holds none, or the lens is that of another film.
    """
    from motes.core.track import GROUND
    from motes.formats import registry
    from motes.formats.recording import ANONYMOUS
    from motes.formats.visibility import OTHERS
    from motes.mot.analytics.real_units import motion_in_hindsight

    if OTHERS not in registry.FORMATS.resolve(form).holds:
        raise ConfigError(f"{form} holds no metres; write .csv, .jsonl or .parquet.")
    head = recorded.head
    if head.width:
        check_size(plane, head.source, head.width, head.height)
    tracks: dict[int, dict[int, Track]] = defaultdict(dict)
    for row in recorded:
        for each in row.objects:
            tracks[each.identity][row.frame] = each
    places: dict[tuple[int, int], Columns] = {}
    for identity, seen in tracks.items():
        span = range(min(seen), max(seen) + 1, recorded.stride)
        found = motion_in_hindsight(plane, map(seen.get, span))
        places |= {(identity, n): place for n, place in zip(span, found, strict=True)}
    nowhere = dict.fromkeys(GROUND)

    def placed(each: Track) -> Track:
        if each.identity == ANONYMOUS:  # several in a frame, and none has a way
            (place,) = motion_in_hindsight(plane, [each])
        else:
            place = places[each.identity, each.frame]
        return replace(each, further={**each.further, **nowhere, **place})

    frames = [replace(row, objects=tuple(map(placed, row.objects))) for row in recorded]
    return dataclasses.replace(recorded, frames=frames)
