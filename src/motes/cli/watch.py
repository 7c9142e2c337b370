"""`motes watch`: track and count all that moves before a fixed camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from functools import partial
from typing import TYPE_CHECKING, Any

from cyclopts import App

from motes.cli.app import part
from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_several, checked_output, numbers_of, point_out_meant
from motes.cli.load_config import HELP, load_watch_config
from motes.cli.option_groups import (
    ConfigOptions,
    FileName,
    FrameOptions,
    Help,
    HelpAll,
    ObjectPreset,
    OwnCode,
    say_rate,
)
from motes.cli.track_units import check_size
from motes.cli.watch_options import CountingOptions, ObjectOptions, WatchOutputs
from motes.core import interrupts
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.cli.frame_loop import Sink
    from motes.cli.input_checks import RowsGoal
    from motes.core.detection import Detector
    from motes.mot.scene_config import WatchConfig

app = App(
    name="watch",
    help_epilogue=HELP.format(
        example="--set initiation.min_hits=3 or --set detector.history=200",
        command="motes config --watch",
    ),
    help_format="plaintext",
    help_formatter=Help(
        "--detector", "--classes", "--camera", "--line", "--zone", "--places", "--end", "--output",
        "--events", "--overlay", "--overwrite", "--set", "--help-all", "--reconnect",
    ),
)  # fmt: skip
PRESET = "nummiaro:adaptive"


@app.default
def watch(
    source: FileName | None = None,
    /,
    *,
    objects: ObjectOptions = ObjectOptions(),
    counting: CountingOptions = CountingOptions(),
    frames: FrameOptions = FrameOptions(),
    outputs: WatchOutputs = WatchOutputs(),
    preset: ObjectPreset = PRESET,
    values: ConfigOptions = ConfigOptions(),
    own_code: OwnCode = False,
    help_all: HelpAll = False,
) -> int:
    """Track all that moves before a fixed camera, and give each object an identity.

    An object keeps its identity from entry to exit, unless it is not recognized after an occlusion.
    Without any output the rows go to standard output; if that is a terminal, they go to a file
    named after the source. At the end the events of each minute are printed.

    Parameters
    ----------
    source
        A video, a folder or pattern of images, the number of a camera, or an address. Or a .toml
        file of several cameras with [[camera]], [[passage]] and [[overlap]] (docs/cameras.md); then
        only -o (.csv or .jsonl), --overwrite, --seed, --histogram and --own-code may be given.
    """
    if help_all:
        from motes.cli.app import show_all

        show_all("watch")
        return DONE
    if source is not None and source.endswith(".toml"):
        _check_no_single((objects, counting, frames, outputs, values), preset)

        watch_rig = part("rig", "A file of several cameras")
        code: int = watch_rig(
            source, outputs.output, outputs.overwrite, values.seed, objects.histogram,
            own_code=own_code,
        )  # fmt: skip
        return code
    if objects.histogram is not None:
        raise ConfigError(
            "--histogram is for a file of several cameras; for one, see Tracker.search of Python."
        )
    where = counting.regions()
    config = load_watch_config(preset, objects, values, own_code=own_code)
    if values.dump_config:
        print(config.to_toml(), end="")
        return DONE
    if source is None:
        raise ConfigError("There is no source; name a video, as in motes watch street.mp4.")
    goal, events, addresses = _checked_names(source, outputs)

    from msgspec.structs import replace

    from motes.cli.annotated_video import ScenePainter
    from motes.cli.frame_loop import Tally, run, summarize
    from motes.cli.outputs import EventsOutput, Request
    from motes.cli.pictures import Heatmap, Paths, Slits
    from motes.cli.watch_loop import SceneTally, scene_moments
    from motes.mot.analytics.event_counter import EventCounter
    from motes.mot.analytics.real_units import RealUnits
    from motes.mot.scene import Scene
    from motes.video.sources import is_recorded

    sending: list[Sink] = []
    if addresses:
        sending.append(
            part("senders", "--events ADDRESS")(addresses, outputs.queue_file, source, where)
        )
    asked = Request(
        source=source, frames=frames, goal=goal, outputs=outputs, config=config,
        seed=values.seed, preset=preset, places=replace(where, ground=None),
        units=None if where.ground is None else RealUnits(where.ground),
    )  # fmt: skip
    scene = Scene(_detector(objects, config, frames.end), config, values.seed)
    if is_recorded(source):
        with frames.open(source, whole=True) as film:  # the rows are the same for every --end
            try:
                scene.prepare(film)
            except KeyboardInterrupt as interrupt:
                summarize(Tally(), film, [], interrupt)
                return interrupts.code(interrupt)
    with frames.open(source) as film:
        counter = EventCounter(where, (film.width, film.height))
        say_rate(film)
        check_size(asked.units, film.name, film.width, film.height)
        if objects.like is not None:
            region = numbers_of("--like", objects.like, "x,y,width,height")
            point_out_meant(region, film.width, film.height)
        opened = asked.pictures(film, ScenePainter(where))
        opened += [EventsOutput(name, outputs.overwrite) for name in events]
        opened += sending
        if outputs.slit is not None:
            opened.append(Slits(outputs.slit, where, overwrite=outputs.overwrite))
        if outputs.heatmap is not None:
            opened.append(Heatmap(outputs.heatmap, overwrite=outputs.overwrite))
        if outputs.paths is not None:
            opened.append(Paths(outputs.paths, overwrite=outputs.overwrite))
        opened += asked.rows_and_history(film)
        moments = partial(scene_moments, film, scene, counter, asked.units)
        tally = SceneTally(scene, counter, turns=counting.turns)
        return run(film, opened, moments, tally, label=outputs.label)


def _checked_names(
    source: str, outputs: WatchOutputs
) -> tuple[RowsGoal | None, list[str], list[str]]:
    """Return where a run writes its rows and events, checked, and where it sends events.

    The rows have a name of their own if nothing else has.
    """
    written, sent = outputs.destinations()
    if outputs.output == "-" and "-" in written:
        raise ConfigError("Rows and events would mix on standard output; give one of them a file.")
    pictures = [path for path in (outputs.slit, outputs.heatmap, outputs.paths) if path is not None]
    queues = [outputs.queue_file] if sent else []
    goal = checked_output(source, outputs, [*written, *pictures, *queues])
    if goal is not None:
        check_several(goal.form)
    return goal, written, sent


def _detector(objects: ObjectOptions, config: WatchConfig, end: int | None) -> Detector:
    """Return the detector for the frames before `end`."""
    from motes.mot.detection.lookalike import LookalikeConfig, LookalikeDetector
    from motes.mot.detection.pretrained import RecordedConfig, RecordedDetections
    from motes.mot.scene_config import named_detector

    if objects.like is not None and objects.detector is not None:
        assert isinstance(config.detector, LookalikeConfig)
        candidates = named_detector(objects.detector)
        detector: Detector = LookalikeDetector(config.detector, candidates)
    elif isinstance(config.detector, RecordedConfig):
        detector = RecordedDetections(config.detector.file, end)
    else:
        detector = config.detector.detector()
    _check_selection(detector, config)
    return detector


def _check_selection(detector: Detector, config: WatchConfig) -> None:
    """Check that a detector can find the wanted classes, and have the least score.

    A callable may find any class, and has scores of its own. Else raises a ConfigError.
    """
    from motes.core.detection import class_names
    from motes.mot.detection.background import BackgroundConfig
    from motes.mot.detection.onnx_detector import OnnxConfig
    from motes.mot.detection.pretrained import FacesConfig, PeopleConfig, RecordedConfig

    kind, wanted, least = config.detector, config.detections.classes, config.detections.least
    if wanted and isinstance(kind, BackgroundConfig | FacesConfig | PeopleConfig | RecordedConfig):
        raise ConfigError("--classes: This detector knows no classes; give a trained one.")
    known = class_names(detector)
    for name in wanted:
        if known and name not in known:
            raise ConfigError(
                f"--classes: The detector has no class {name!r}; it has {', '.join(known)[:200]}."
            )
        if not known and isinstance(kind, OnnxConfig) and not name.isdecimal():
            raise ConfigError(
                f"--classes: {kind.file} does not name its classes; give their numbers, or their "
                f"names as classes in a TOML file beside it."
            )
    shares = isinstance(kind, BackgroundConfig | OnnxConfig)
    if shares and least is not None and not 0 <= least <= 1:
        raise ConfigError(f"--least is {least:g}; this detector has scores from 0 to 1.")


def _check_no_single(groups: Sequence[Any], preset: str) -> None:
    """Raise a ConfigError for an option that is for one camera.

    Several cameras take some options of these groups, and have presets of their own.
    """
    several = ("output", "overwrite", "seed", "histogram")
    names = [
        field.name
        for group in groups
        for field in fields(group)
        if field.name not in several and getattr(group, field.name) not in (field.default, [])
    ]
    for name in [*names, *["preset"] * (preset != PRESET)]:
        option = {"changes": "set"}.get(name, name).replace("_", "-")
        raise ConfigError(f"--{option} is for one camera, not for a file of several.")
