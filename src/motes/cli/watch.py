"""`motes watch`: follow and count all that moves before a fixed camera."""

from __future__ import annotations

import contextlib
from collections import Counter
from collections.abc import Generator, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter

from motes.cli.exit_codes import DONE, NOT_FOUND
from motes.cli.input_checks import (
    check_label,
    check_not_source,
    default_output,
    numbers_of,
    point_out_leftovers,
    read_text,
)
from motes.cli.load_config import as_keys, check_settings, error_context
from motes.cli.options import (
    CONFIGURATION,
    FRAMES,
    OUTPUT,
    ConfigFile,
    DumpConfig,
    Label,
    Overwrite,
    Settings,
    announce_compiling,
    log,
)
from motes.core import interrupts
from motes.core.errors import ConfigError, MotesError

if TYPE_CHECKING:
    from motes.cli.watch_outputs import Output
    from motes.core.frame import Frame
    from motes.mot.analytics.events import EventCounter, Regions
    from motes.mot.pipeline_config import WatchConfig
    from motes.mot.scene import Scene
    from motes.video.sources import Source

OBJECTS = Group("Objects", sort_key=1)
COUNTED = Group("Counting", sort_key=1)


def watch(
    source: str | None = None,
    /,
    *,
    finder: Annotated[
        str | None,
        Parameter(
            name="--detector",
            accepts_keys=False,
            group=OBJECTS,
            help="What finds objects: mog2, knn or gaussian, backgrounds before which they move; "
            "people or faces; or a file of detections as the MOTChallenge has them, a .txt. By "
            "default mog2, or gaussian where OpenCV is not installed.",
        ),
    ] = None,
    like: Annotated[
        str | None,
        Parameter(
            group=OBJECTS,
            allow_leading_hyphen=True,
            help="Instead: all that look like what is in this box of the first frame, as the "
            "players of a team: x,y,width,height. The camera may move.",
        ),
    ] = None,
    line: Annotated[
        list[str] | None,
        Parameter(
            group=COUNTED,
            negative=(),
            allow_leading_hyphen=True,
            help="Count who crosses a line: x1,y1,x2,y2. May be repeated.",
        ),
    ] = None,
    zone: Annotated[
        list[str] | None,
        Parameter(
            group=COUNTED,
            negative=(),
            allow_leading_hyphen=True,
            help="Count who enters and leaves a polygon: x1,y1,x2,y2,x3,y3,... May be repeated.",
        ),
    ] = None,
    dwell: Annotated[
        float | None,
        Parameter(
            group=COUNTED,
            help="Count who stays in a zone for so many seconds, where the zone does not say.",
        ),
    ] = None,
    places: Annotated[
        Path | None,
        Parameter(
            group=COUNTED,
            help="TOML with [[line]] and [[zone]], their points and name, a zone's dwell; and "
            "[ground], for speeds in metres: scale, homography (9 numbers), or points (four or "
            "more [x, y, X, Y]).",
        ),
    ] = None,
    scale: Annotated[
        float | None,
        Parameter(group=COUNTED, help="Pixels in a metre, for speeds in metres a second."),
    ] = None,
    start: Annotated[int, Parameter(group=FRAMES, help="First frame.")] = 0,
    end: Annotated[int | None, Parameter(group=FRAMES, help="Frame to stop before.")] = None,
    stride: Annotated[int, Parameter(group=FRAMES, help="Take every n-th frame.")] = 1,
    output: Annotated[
        str | None,
        Parameter(
            name=["--output", "-o"],
            group=OUTPUT,
            allow_leading_hyphen=True,
            help="Each object in each frame: rows as .csv, .jsonl, .txt in the form of the "
            "MOTChallenge, or - for standard output; or a document of COCO (.json) or CVAT (.xml).",
        ),
    ] = None,
    label: Label = None,
    events: Annotated[
        str | None,
        Parameter(
            group=OUTPUT,
            allow_leading_hyphen=True,
            help="Who appears, disappears, crosses, enters, stays and leaves, while it happens, as "
            "JSON Lines: a file, or - for standard output.",
        ),
    ] = None,
    overlay: Annotated[
        Path | None, Parameter(group=OUTPUT, help="Annotated video: .mp4, .mkv, .mov or .m4v.")
    ] = None,
    overwrite: Overwrite = False,
    preset: Annotated[
        str, Parameter(group=CONFIGURATION, help="The particle filter that follows each object.")
    ] = "nummiaro:adaptive",
    config: ConfigFile = None,
    seed: Annotated[int, Parameter(group=CONFIGURATION, help="Of the random numbers.")] = 0,
    dump_config: DumpConfig = False,
    **settings: Settings,
) -> int:
    """Follow all that moves before a fixed camera, and give each object an identity.

    It keeps its identity from entry to exit, also while something hides it. Without -o, --events
    and --overlay the rows go to standard output, or to a file named after the source if that is a
    terminal. The end says what was counted in each minute.

    Every key of the configuration is an option too, laid over the file of --config, as
    --initiation.min-hits 3, --tracker.particles 100, --detector.least 0.001 or
    --detector.history 200; --dump-config shows all of them, as a file for --config.

    Parameters
    ----------
    source
        A video, a folder or pattern of images, the number of a camera, or an address; or several
        cameras, in a .toml file with [[camera]], [[passage]] and [[overlap]]. Of the options it
        takes -o, --overwrite and --seed; docs/cameras.md has the rest.
    """
    if source is not None and source.endswith(".toml"):
        single = {
            "detector": finder, "like": like, "line": line, "zone": zone, "dwell": dwell,
            "places": places, "start": start, "end": end, "stride": stride != 1, "events": events,
            "overlay": overlay, "preset": preset != "nummiaro:adaptive", "scale": scale,
            "config": config, "dump-config": dump_config, "label": label, **settings,
        }  # fmt: skip
        for option, value in single.items():
            if value:
                raise ConfigError(f"--{option} is for one camera, not for a file of several.")

        from motes.cli.watch_cameras import watch_rig

        return watch_rig(source, output, overwrite, seed)
    where = _places(line or [], zone or [], dwell, places, scale)
    watching = _watch_config(preset, config, finder, like, settings)
    if dump_config:
        from motes.core.config import to_toml

        print(to_toml(watching), end="")
        return DONE
    if source is None:
        raise ConfigError("There is no source; name a video, as in motes watch street.mp4.")
    if output is None and overlay is None and events is None:
        output = default_output(source)
    if output == events == "-":
        raise ConfigError("Rows and events would mix on standard output; give one of them a file.")
    from motes.output.documents import is_document
    from motes.output.journal import journal_of

    check_label(label, output)
    files = [Path(name) for name in (output, events) if name is not None and name != "-"]
    if output is not None and is_document(output):
        files.append(journal_of(output))
    check_not_source(source, overlay, *files)
    point_out_leftovers(overlay, *files)

    from motes.cli.watch_outputs import Events, Overlay, objects_output
    from motes.mot.analytics.events import EventCounter
    from motes.mot.scene import Scene
    from motes.video.sources import open_source

    counting = EventCounter(where)
    scene = Scene(watching.detector.detector(), watching, seed)
    with open_source(source, start=start, end=end, stride=stride, on_drop=log) as film:
        outputs: list[Output] = []
        if overlay is not None:
            outputs.append(Overlay(overlay, film, stride, where, overwrite=overwrite))
        if events is not None:
            outputs.append(Events(events, overwrite))
        if output is not None:
            outputs.append(objects_output(output, film, overwrite=overwrite, label=label))
        return _run(film, scene, counting, outputs)


def _watch_config(
    preset: str,
    file: Path | None,
    detector: str | None,
    like: str | None,
    settings: dict[str, Any],
) -> WatchConfig:
    """Return the scene of a preset, with file, detector and settings laid over it in turn."""
    from msgspec.structs import asdict

    from motes.core.config import from_dict, from_toml, merge, to_dict
    from motes.mot.pipeline_config import WatchConfig, detector_values
    from motes.mot.scene_config import scene_config

    if like is not None and detector is not None:
        raise ConfigError("--like and --detector contradict each other; give one of them.")

    def laid_over(config: WatchConfig, changes: Mapping[str, Any]) -> WatchConfig:
        laid: WatchConfig = from_dict(merge(to_dict(config), changes), WatchConfig)
        return laid

    config = WatchConfig(**asdict(scene_config(preset)))
    if file is not None:
        with error_context(file):
            config = laid_over(config, from_toml(read_text(file), "this file"))
    if like is not None:
        box = numbers_of("--like", like, "x,y,width,height")
        config = laid_over(config, {"detector": {"type": "like", "box": box}})
    elif detector is not None:
        config = laid_over(config, {"detector": detector_values(detector)})
    check_settings(watch, config, settings)
    return laid_over(config, as_keys(settings))


def _places(
    lines: Sequence[str],
    zones: Sequence[str],
    dwell: float | None,
    file: Path | None,
    scale: float | None,
) -> Regions:
    """Return lines, zones and ground of the options and of the file."""
    from msgspec.structs import replace

    from motes.mot.analytics.events import Line, Regions, Zone
    from motes.mot.analytics.ground_plane import Ground

    given = Regions()
    if file is not None:
        text = read_text(file)
        with error_context(file):
            given = Regions.parse(text)
    more = Regions(
        tuple(Line(tuple(numbers_of("--line", text, "x1,y1,x2,y2"))) for text in lines),  # type: ignore[arg-type]
        tuple(Zone(tuple(_corners(text))) for text in zones),
    )
    ground = given.ground
    if scale is not None:
        if ground is not None:
            raise ConfigError(f"--scale and the [ground] of {file} contradict each other.")
        with error_context("--scale"):
            ground = Ground(scale)
    together = given.zone + more.zone
    if dwell is not None:
        if not together:
            raise ConfigError("--dwell is for zones; give one with --zone or --places.")
        with error_context("--dwell"):
            together = tuple(replace(zone, dwell=zone.dwell or dwell) for zone in together)
    return Regions(given.line + more.line, together, ground)


def _corners(text: str) -> list[float]:
    """Return the numbers of --zone, at least three corners."""
    form = ",".join("xy"[i % 2] for i in range(max(6, text.count(",") + 1)))
    return numbers_of("--zone", text, form)


def _run(film: Source, scene: Scene, counting: EventCounter, outputs: Sequence[Output]) -> int:
    """Watch the film, write all there is to write, and say how it went."""
    from motes.cli.frame_loop import run
    from motes.cli.watch_outputs import FrameResult

    announce_compiling()
    frames, said = 0, set[str]()

    def moments(pictures: Iterator[Frame]) -> Generator[FrameResult, None, None]:
        with contextlib.closing(scene.watch(pictures, ahead=not film.live)) as watched:
            for frame, tracks in watched:
                yield FrameResult(frame, tracks, counting.update(tracks))

    def note(moment: FrameResult) -> str:
        nonlocal frames
        frames += 1
        for kind, text in scene.warnings.items():
            if kind not in said:
                said.add(kind)
                log(text)
        here = scene.created - scene.terminated
        return f"{here} objects, {scene.created} came, {scene.terminated} went"

    try:
        interrupted = run(film, outputs, moments, note)
    except MotesError:
        _summarize(frames, film, scene, counting, outputs, interrupted=None)
        raise
    _summarize(frames, film, scene, counting, outputs, interrupted=interrupted)
    if interrupted:
        return interrupts.code(interrupted)
    if not scene.created:
        log("error: No object was ever found; try another --detector.")
        return NOT_FOUND
    return DONE


def _summarize(
    frames: int,
    film: Source,
    scene: Scene,
    counting: EventCounter,
    outputs: Sequence[Output],
    *,
    interrupted: KeyboardInterrupt | None,
) -> None:
    """Print one line on how a run went, and what was counted in each minute."""
    if not frames:
        return
    tracker = scene.config.tracker
    parts = [
        interrupts.word(interrupted)
        + f"{frames} frames, {scene.created} objects, {scene.terminated} of them gone",
        f"each followed by {tracker.particles} particles and {' and '.join(tracker.cues)}",
    ]
    written = [output.result for output in outputs if output.result is not None]
    if written:
        parts.append("wrote " + ", ".join(written))
    if film.report.problems:
        parts.append(f"{film.name}: {film.report.problems}")
    log("; ".join(parts) + ".")
    for text in table(counting.counts):
        log(text)


def table(counts: Counter[tuple[int, str, str, str]]) -> list[str]:
    """Return what was counted, a line for each minute in which something was."""
    minutes: dict[int, list[str]] = {}
    for (minute, event, place, direction), count in sorted(counts.items()):
        what = " ".join(part for part in (event, place, direction) if part)
        minutes.setdefault(minute, []).append(f"{what} {count}")
    return [f"minute {minute}: {', '.join(whats)}" for minute, whats in minutes.items()]
