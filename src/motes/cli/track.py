"""`motes track`: track one object, or several, through a video."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE, NOT_FOUND
from motes.cli.input_checks import (
    check_keyframe_error,
    check_label,
    check_not_source,
    default_output,
    point_out_leftovers,
    stem_of,
)
from motes.cli.keyframe_options import KeyframeOptions
from motes.cli.load_config import tracker_config
from motes.cli.messages import log
from motes.cli.options import (
    CONFIGURATION,
    FLAG,
    OUTPUT,
    ConfigOptions,
    FrameOptions,
    OutputOptions,
    TrackPreset,
)
from motes.cli.settings import HELP, Settings, default_preset
from motes.cli.track_target import TargetOptions
from motes.cli.track_units import UnitOptions, motion_names
from motes.core import interrupts
from motes.core.errors import ConfigError, MotesError

if TYPE_CHECKING:
    from motes.cli.track_loop import Begin, Steps
    from motes.cli.track_outputs import Output
    from motes.cli.watch_outputs import Output as ObjectsOutput
    from motes.mot.analytics.real_units import RealUnits
    from motes.sot.presets import TrackerConfig
    from motes.sot.tracker import Tracker
    from motes.video.sources import Source

app = App(
    name="track",
    help_epilogue=HELP.format(
        example="--motion.noise.size 0.1 of preset nummiaro", command="motes config PRESET"
    ),
    help_format="plaintext",
)


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class TrackOutputs(OutputOptions):
    """The outputs of `motes track`."""

    figures: Annotated[
        str | None,
        Parameter(
            help="Folder for the figures of the papers; or the names of figures of the motion, "
            "path,speed,size, which become NAME.path.pdf and so on, beside the rows NAME.csv."
        ),
    ] = None
    masks: Annotated[
        Path | None,
        Parameter(
            help="Pixels of the target, as far as its colors differ from those around it: a folder "
            "for PNG files, or a .json document of COCO."
        ),
    ] = None
    resume: Annotated[
        bool,
        FLAG,
        Parameter(
            help="Continue the rows of an interrupted run. Give the same source, options and seed. "
            "The run is repeated at its usual speed: existing rows are kept, overlay and figures "
            "are made anew."
        ),
    ] = False


@app.default
def track(
    *sources: str,
    target: TargetOptions = TargetOptions(),
    keys: KeyframeOptions = KeyframeOptions(),
    frames: FrameOptions = FrameOptions(),
    units: UnitOptions = UnitOptions(),
    outputs: TrackOutputs = TrackOutputs(),
    preset: TrackPreset = None,
    values: ConfigOptions = ConfigOptions(),
    fps_target: Annotated[
        float | None,
        Parameter(
            group=CONFIGURATION,
            help="Frames per second to reach: the tracker chooses its number of particles, from "
            "--budget.min 50 to --budget.max 500.",
        ),
    ] = None,
    **settings: Settings,
) -> int:
    """Track one object, or several, through a video; or one through each of several videos.

    The result has a row for each frame: the target's position, the confidence, and the status
    (searching, tracking or lost). With several objects it has a row for each object: its box and
    its identity, from 1 in the order of --init.

    Without -o, --overlay and --figures the rows go to standard output; if that is a terminal, they
    go to a file named after the source.

    With several videos and --keyframes, -o is a folder, which gets the rows of each video.

    Parameters
    ----------
    sources
        A video, an image, a folder or pattern of images, the number of a camera, or an address. Or
        several of them, or a pattern of videos, with --keyframes.
    """
    known = target.known()
    preset = preset or default_preset(known is not None or fps_target is not None)
    config = tracker_config(app, preset, values.config, settings, known)
    if values.dump_config:
        from motes.core.config import to_toml

        print(to_toml(config), end="")
        return DONE
    if not sources:
        raise ConfigError("There is no source; name a video, as in motes track film.mp4 --init …")
    if values.seed < 0:
        raise ConfigError(f"--seed is {values.seed}; give 0 or more.")
    if keys.given:
        others = (outputs.figures, outputs.masks, outputs.show, outputs.resume, fps_target)
        if frames.stride != 1 or any(others) or units.units() is not None:
            raise ConfigError(
                "--stride, --scale, --ground, --figures, --masks, --show, --resume and "
                "--fps-target are not for keyframes; omit them."
            )
        check_keyframe_error(outputs.keyframe_error)
        return _track_keyframes(sources, keys, target, frames, outputs, config, values.seed)
    if len(sources) > 1:
        raise ConfigError(
            f"No option takes {' '.join(sources[1:])}; numbers of one option need commas, and "
            f"several videos --keyframes."
        )
    (source,) = sources
    if outputs.resume and fps_target is not None:
        raise ConfigError("With --fps-target no run repeats itself; omit it or --resume.")
    boxes = target.boxes()
    begin = target.begin(known)
    single = (outputs.figures, outputs.masks, outputs.resume, fps_target)
    if len(boxes) > 1 and any(single):
        raise ConfigError(
            "--figures, --masks, --resume and --fps-target are for one --init; omit them."
        )
    plane = units.units()
    if plane is not None and len(boxes) > 1:
        raise ConfigError("--scale, --ground and --lens are for one --init; omit them.")
    output = outputs.output
    besides = (outputs.overlay, outputs.figures, outputs.masks, outputs.show)
    if output is None and not any(besides):
        output = default_output(source)
    if outputs.masks is None or outputs.masks.suffix != ".json":
        check_label(outputs.label, output, outputs.format)
    check_keyframe_error(outputs.keyframe_error)
    where = Path(output) if output else None
    folder = None if motion_names(outputs.figures) else outputs.figures
    check_not_source(
        source, where, outputs.overlay, outputs.masks, Path(folder) if folder else None
    )
    point_out_leftovers(where, outputs.overlay)
    if outputs.resume and output is None:
        raise ConfigError("--resume continues a file of rows; name it with -o.")
    if len(boxes) > 1:
        if output is not None:
            from motes.cli.watch_outputs import check_several

            check_several(output, outputs.format)
        return _track_several(source, boxes, frames, output, outputs, config, values.seed)

    from motes.sot.tracker import Tracker

    tracker = Tracker(config, values.seed, fps_target)
    return _track_one(source, tracker, begin, frames, output, outputs, plane)


def _track_keyframes(
    sources: Sequence[str],
    keys: KeyframeOptions,
    target: TargetOptions,
    frames: FrameOptions,
    outputs: TrackOutputs,
    config: TrackerConfig,
    seed: int,
) -> int:
    """Track an object between keyframes, or backward; or one in each of several films."""
    from motes.cli.track_films import films_of, marks_of_films, track_films
    from motes.cli.track_keyframes import open_film, track_keyframes

    films = films_of(sources)
    region = target.region()
    if len(films) > 1:
        if keys.keyframes is None or keys.in_one_film or region is not None:
            raise ConfigError(
                "The targets of several films are in the file of --keyframes; omit other targets."
            )
        check_label(outputs.label, outputs.output and "rows.csv", outputs.format)
        each = marks_of_films(films, keys.keyframes)
        return track_films(each, frames, outputs, config, seed)
    (source,) = films
    marks = keys.marks(source)
    if region is None and not any(mark for _, mark in marks):
        raise ConfigError(
            "The target is missing. Give --at N=x,y,width,height, or --init x,y,width,height."
        )
    output = outputs.output
    if output is None and outputs.overlay is None:
        output = default_output(source)
    check_label(outputs.label, output, outputs.format)
    where = Path(output) if output else None
    check_not_source(source, where, outputs.overlay)
    point_out_leftovers(where, outputs.overlay)
    film = open_film(source, frames.start, frames.end, keys)
    return track_keyframes(film, keys, region, marks, config, seed, output, outputs)


def _track_several(
    source: str,
    boxes: Sequence[Sequence[float]],
    frames: FrameOptions,
    output: str | None,
    outputs: TrackOutputs,
    config: TrackerConfig,
    seed: int,
) -> int:
    """Track the objects in several boxes of the first frame."""
    from motes.cli.show import show_scene
    from motes.cli.track_batch import track_several
    from motes.cli.watch_outputs import Overlay, objects_output
    from motes.mot.analytics.events import Regions
    from motes.sot.batch import Trackers

    overwrite = outputs.overwrite
    with frames.open(source) as film:
        opened: list[ObjectsOutput] = []
        if outputs.overlay is not None:
            stride = frames.stride
            opened.append(Overlay(outputs.overlay, film, stride, Regions(), overwrite=overwrite))
        if outputs.show:
            opened.append(show_scene(Regions()))
        if output is not None:
            opened.append(
                objects_output(
                    output, film, overwrite=overwrite, form=outputs.format, label=outputs.label,
                    keyframe_error=outputs.keyframe_error,
                )
            )  # fmt: skip
        return track_several(film, Trackers(config, seed), boxes, opened)


def _track_one(
    source: str,
    tracker: Tracker,
    begin: Begin,
    frames: FrameOptions,
    output: str | None,
    outputs: TrackOutputs,
    units: RealUnits | None,
) -> int:
    """Track one object."""
    from motes.cli.track_loop import follow
    from motes.cli.track_outputs import AsObjects, Figures, Overlay, Rows
    from motes.cli.track_units import MotionFigures, check_size, measured
    from motes.cli.watch_outputs import format_of, objects_output, row_form
    from motes.mot.analytics.real_units import PIXELS
    from motes.output.track_rows import COLUMNS, GROUND

    resume = outputs.resume
    form = None if output is None else format_of(output, outputs.format)
    rows = row_form(form)
    if resume and not rows:
        raise ConfigError(f"--resume continues rows; {output} holds none, make it anew.")
    anew = outputs.overwrite or resume
    with frames.open(source) as film:
        if resume and film.live:
            raise ConfigError(f"{film.name} is live and will not repeat itself; omit --resume.")
        opened: list[Output] = []
        if outputs.overlay is not None:
            opened.append(Overlay(outputs.overlay, film, frames.stride, overwrite=anew))
        check_size(units, film)
        steps: Steps = partial(follow, tracker, begin)
        if names := motion_names(outputs.figures):
            stem = Path(stem_of(source) if output in (None, "-") else str(output))
            unit = "pixels" if units is None else "m"
            opened.append(MotionFigures(stem.with_suffix(""), names, unit, overwrite=anew))
        elif outputs.figures is not None:
            opened.append(Figures(Path(outputs.figures), tracker.config, overwrite=anew))
        if outputs.masks is not None:
            from motes.cli.track_masks import masks_output

            opened.append(masks_output(outputs.masks, film, outputs.label, overwrite=anew))
        if names or units is not None:
            steps = measured(units or PIXELS, steps)
        if outputs.show:
            from motes.cli.show import show_track

            opened.append(show_track())
        if output is not None and rows:
            opened.append(
                Rows(
                    output, rows, overwrite=outputs.overwrite, resume=resume,
                    columns=COLUMNS if units is None else (*COLUMNS, *GROUND),
                )
            )  # fmt: skip
        elif output is not None:
            inner = objects_output(
                output, film, overwrite=outputs.overwrite, form=form, label=outputs.label,
                keyframe_error=outputs.keyframe_error,
            )  # fmt: skip
            opened.append(AsObjects(inner))
        return _run(film, tracker, steps, opened, quiet=output == "-")


def _run(
    film: Source, tracker: Tracker, steps: Steps, outputs: Sequence[Output], *, quiet: bool
) -> int:
    """Track the target through the film, write the outputs and print a summary."""
    from motes.cli.frame_loop import run, summarize
    from motes.cli.progress import RunStatistics
    from motes.sot.particle_filter import ParticleFilter

    chooses = isinstance(tracker.config, ParticleFilter) and tracker.config.budget is not None
    tally = RunStatistics(budget=chooses)

    def finish(interrupted: KeyboardInterrupt | None = None) -> None:
        if tally.frames:
            summarize([str(tally)], film, outputs, interrupted)

    try:
        interrupted = run(film, outputs, steps, tally.add, quiet=quiet and sys.stdout.isatty())
    except MotesError:
        finish()
        raise
    finish(interrupted)
    if interrupted:
        return interrupts.code(interrupted)
    if not tally.found:
        log("error: The target was never found; look for another one, or elsewhere.")
        return NOT_FOUND
    return DONE
