"""`motes track`: follow an object, or several, through a video."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE, NOT_FOUND
from motes.cli.input_checks import (
    check_label,
    check_not_source,
    default_output,
    numbers_of,
    point_out_leftovers,
    read_text,
)
from motes.cli.load_config import error_context, load_target, tracker_config
from motes.cli.options import (
    CONFIG_HELP,
    CONFIGURATION,
    FRAMES,
    OUTPUT,
    TARGET,
    ConfigFile,
    DumpConfig,
    Ellipse,
    Label,
    Overwrite,
    Preset,
    Settings,
    log,
)
from motes.core import interrupts
from motes.core.errors import ConfigError, MotesError

if TYPE_CHECKING:
    from motes.cli.progress import RunStatistics
    from motes.cli.track_loop import Begin
    from motes.cli.track_outputs import Output
    from motes.sot.known_target import Place, Target
    from motes.sot.tracker import Tracker
    from motes.video.sources import Source

app = App(name="track", help_epilogue=CONFIG_HELP, help_format="plaintext")


@app.default
def track(
    source: str | None = None,
    /,
    *,
    init: Annotated[
        list[str] | None,
        Parameter(
            group=TARGET,
            negative=(),
            allow_leading_hyphen=True,
            help="Box: x,y,width,height. Again for each of several objects.",
        ),
    ] = None,
    ellipse: Ellipse = None,
    histogram: Annotated[
        Path | None, Parameter(group=TARGET, help="What to look for: a file of motes histogram.")
    ] = None,
    detect: Annotated[
        Literal["face"] | None, Parameter(group=TARGET, help="Wait for a face and follow it.")
    ] = None,
    at: Annotated[
        Path | None,
        Parameter(
            group=TARGET, help="Where --histogram may appear: TOML, [[place]] with box or border."
        ),
    ] = None,
    background: Annotated[
        Path | None, Parameter(group=TARGET, help="For --histogram: a picture without the target.")
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
            help="Rows, one for each frame: a .csv or .jsonl file, or - for standard output; or "
            "in the form of the MOTChallenge (.txt), COCO (.json) or CVAT (.xml).",
        ),
    ] = None,
    format: Annotated[  # noqa: A002
        Literal["csv", "jsonl"] | None,
        Parameter(group=OUTPUT, help="Form of the rows, whatever the file's ending."),
    ] = None,
    label: Label = None,
    overlay: Annotated[
        Path | None, Parameter(group=OUTPUT, help="Annotated video: .mp4, .mkv, .mov or .m4v.")
    ] = None,
    figures: Annotated[
        Path | None, Parameter(group=OUTPUT, help="Folder for the figures of the papers.")
    ] = None,
    overwrite: Overwrite = False,
    resume: Annotated[
        bool,
        Parameter(
            group=OUTPUT,
            negative=(),
            show_default=False,
            help="Continue the rows of an interrupted run. Give the same source, options and seed: "
            "the run is repeated, at its usual speed; rows that are there are kept, overlay and "
            "figures are made anew.",
        ),
    ] = False,
    preset: Preset = "default",
    config: ConfigFile = None,
    seed: Annotated[int, Parameter(group=CONFIGURATION, help="Of the random numbers.")] = 0,
    fps_target: Annotated[
        float | None,
        Parameter(
            group=CONFIGURATION,
            help="Frames a second that the tracker shall manage: it chooses its number of "
            "particles, from --budget.min 50 to --budget.max 500.",
        ),
    ] = None,
    dump_config: DumpConfig = False,
    **settings: Settings,
) -> int:
    """Follow an object, or several, through a video.

    Writes where it is in every frame, how sure that is, and whether it is searched, tracked or
    lost; of several, their boxes with identities from 1, in the order of --init. Without -o,
    --overlay and --figures the rows go to standard output, or to a file named after the source if
    that is a terminal. With --histogram and --fps-target, the preset is
    nummiaro if no other is named.

    Parameters
    ----------
    source
        A video, an image, a folder or pattern of images, the number of a camera, or an address.
    """
    known = None if histogram is None else load_target(histogram)
    if preset == "default" and (known is not None or fps_target is not None):
        preset = "nummiaro"  # which alone can search for a histogram and choose its particles
    tracking = tracker_config(track, preset, config, settings, known)
    if dump_config:
        from motes.core.config import to_toml

        print(to_toml(tracking), end="")
        return DONE
    if source is None:
        raise ConfigError("There is no source; name a video, as in motes track film.mp4 --init …")
    if seed < 0:
        raise ConfigError(f"--seed is {seed}; give 0 or more.")
    if resume and fps_target is not None:
        raise ConfigError("With --fps-target no run repeats itself; omit it or --resume.")
    boxes = [numbers_of("--init", text, "x,y,width,height") for text in init or []]
    begin = _begin(boxes, ellipse, known, detect, at, background)
    several = len(boxes) > 1
    if several and (figures is not None or resume or fps_target is not None):
        raise ConfigError("--figures, --resume and --fps-target are for one --init; omit them.")
    if output is None and overlay is None and figures is None:
        output = default_output(source)
    check_label(label, output if format is None else None)
    where = Path(output) if output else None
    check_not_source(source, where, overlay, figures)
    point_out_leftovers(where, overlay)
    if resume and output is None:
        raise ConfigError("--resume continues a file of rows; name it with -o.")

    from motes.video.sources import open_source

    if several:
        from motes.cli.track_batch import open_outputs, track_several
        from motes.sot.batch import Trackers

        with open_source(source, start=start, end=end, stride=stride, on_drop=log) as film:
            files = open_outputs(film, stride, output, format, label, overlay, overwrite=overwrite)
            return track_several(film, Trackers(tracking, seed), boxes, files)

    from motes.cli.track_outputs import AsObjects, Figures, Overlay, Rows
    from motes.output.track_rows import FORMS
    from motes.sot.tracker import Tracker

    tracker = Tracker(tracking, seed, fps_target)
    rows = output == "-" or format is not None or Path(output or "").suffix.lower() in FORMS
    if resume and not rows:
        raise ConfigError(f"--resume continues rows; {output} holds none, make it anew.")

    with open_source(source, start=start, end=end, stride=stride, on_drop=log) as film:
        if resume and film.live:
            raise ConfigError(f"{film.name} is live and will not repeat itself; omit --resume.")
        outputs: list[Output] = []
        if overlay is not None:
            outputs.append(Overlay(overlay, film, stride, overwrite=overwrite or resume))
        if figures is not None:
            outputs.append(Figures(figures, tracker.config, overwrite=overwrite or resume))
        if output is not None and rows:
            outputs.append(Rows(output, format, overwrite=overwrite, resume=resume))
        elif output is not None:
            outputs.append(AsObjects(output, film, label, overwrite=overwrite))
        return _run(film, tracker, begin, outputs, quiet=output == "-")


def _begin(
    boxes: Sequence[Sequence[float]],
    ellipse: str | None,
    known: Target | None,
    detect: str | None,
    at: Path | None,
    background: Path | None,
) -> Begin:
    """Return how tracking begins; it must be told in exactly one way."""
    ways = {"--init": boxes or None, "--ellipse": ellipse, "--histogram": known, "--detect": detect}
    given = [flag for flag, value in ways.items() if value is not None]
    if not given:
        raise ConfigError(
            f"What shall be followed? Give one of {', '.join(ways)}, "
            f"for example --init 300,200,60,80 (x, y, width, height in the first frame)."
        )
    if len(given) > 1:
        raise ConfigError(f"{' and '.join(given)} contradict each other; give one of them.")
    if known is None and (at or background):
        raise ConfigError("--at and --background belong to --histogram; give it, or omit them.")

    from motes.cli import track_loop

    if boxes:
        return track_loop.on_region(boxes[0])
    if ellipse is not None:
        return track_loop.on_region(numbers_of("--ellipse", ellipse, "x,y,a,b,theta"))
    if known is None:
        from motes.mot.detection.pretrained import FaceDetector

        return track_loop.on_detection(FaceDetector())

    from motes.sot.known_target import load_places
    from motes.video.sources import read_image

    places: tuple[Place, ...] = ()
    if at is not None:
        read_text(at)  # tells a file that is not there from one that makes no sense
        with error_context(at):
            places = load_places(at)
    return track_loop.on_target(
        known, places, None if background is None else read_image(background)
    )


def _run(
    film: Source,
    tracker: Tracker,
    begin: Begin,
    outputs: Sequence[Output],
    *,
    quiet: bool,
) -> int:
    """Follow the target through the film, write all there is to write, and say how it went."""
    from motes.cli.frame_loop import run
    from motes.cli.progress import RunStatistics
    from motes.cli.track_loop import follow
    from motes.sot.particle_filter import ParticleFilter

    chooses = isinstance(tracker.config, ParticleFilter) and tracker.config.budget is not None
    tally = RunStatistics(budget=chooses)
    steps = partial(follow, tracker, begin)
    try:
        interrupted = run(film, outputs, steps, tally.add, quiet=quiet and sys.stdout.isatty())
    except MotesError:
        _summarize(tally, film, outputs, interrupted=None)
        raise
    _summarize(tally, film, outputs, interrupted=interrupted)
    if interrupted:
        return interrupts.code(interrupted)
    if not tally.found:
        log("error: The target was never found; look for another one, or elsewhere.")
        return NOT_FOUND
    return DONE


def _summarize(
    tally: RunStatistics,
    film: Source,
    outputs: Sequence[Output],
    *,
    interrupted: KeyboardInterrupt | None,
) -> None:
    """Print one line on how a run went."""
    if not tally.frames:
        return
    written = [output.result for output in outputs if output.result is not None]
    parts = [interrupts.word(interrupted) + str(tally)]
    if written:
        parts.append("wrote " + ", ".join(written))
    if film.report.problems:
        parts.append(f"{film.name}: {film.report.problems}")
    log("; ".join(parts) + ".")
