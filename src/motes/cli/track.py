"""`motes track`: track one object, or several, through a video."""

from __future__ import annotations

from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import checked_output, refuse
from motes.cli.load_config import TRACKER_HELP, tracker_config
from motes.cli.option_groups import (
    CONFIGURATION,
    PRESETS,
    ConfigOptions,
    FileName,
    FrameOptions,
    Help,
    HelpAll,
    PresetName,
)
from motes.cli.track_options import KeyframeOptions, TargetOptions, TrackOutputs
from motes.cli.track_units import UnitOptions
from motes.core.errors import ConfigError

app = App(
    name="track",
    help_epilogue=TRACKER_HELP,
    help_format="plaintext",
    help_formatter=Help(
        "--init", "--at", "--keyframes", "--detect", "--start", "--end", "--scale", "--output",
        "--overlay", "--overwrite", "--resume", "--preset", "--set", "--network", "--help-all",
    ),
)  # fmt: skip


@app.default
def track(
    source: FileName | None = None,
    /,
    *,
    target: TargetOptions = TargetOptions(),
    keys: KeyframeOptions = KeyframeOptions(),
    frames: FrameOptions = FrameOptions(),
    units: UnitOptions = UnitOptions(),
    outputs: TrackOutputs = TrackOutputs(),
    preset: Annotated[PresetName, Parameter(group=CONFIGURATION, help=PRESETS)] = "default",
    values: ConfigOptions = ConfigOptions(),
    network_files: Annotated[
        FileName | None, Parameter(name="--network", group=CONFIGURATION)
    ] = None,
    help_all: HelpAll = False,
) -> int:
    """Track one object, or several, through a video.

    The result has a row for each frame: the target's position, the confidence, and the status
    (searching, tracking or lost). With several objects it has a row for each object: its box and
    its identity, from 1 in the order of --init.

    Without -o, --overlay and --figures the rows go to standard output; if that is a terminal, they
    go to a file named after the source.

    Parameters
    ----------
    source
        A video, an image, a folder or pattern of images, the number of a camera, or an address.
    network_files
        Trained network that joins the tracker: one that motes network get has downloaded, such as
        nanotrack, or its ONNX files: backbone.onnx,head.onnx.
    """
    if help_all:
        from motes.cli.app import show_all

        show_all("track")
        return DONE
    config = tracker_config(preset, values.config, values.changes or (), network_files)
    if values.dump_config:
        print(config.to_toml(), end="")
        return DONE
    if source is None:
        raise ConfigError("There is no source; name a video, as in motes track film.mp4 --init …")
    if values.seed < 0:
        raise ConfigError(f"--seed is {values.seed}; give 0 or more.")
    if (network := getattr(config, "network", None)) is not None:
        network.open()  # files that cannot be used are told before anything is written
    _check_fitting(target, keys, frames, outputs)
    begin = None if keys.given else target.begin()
    plane = units.units()
    region = target.region() if keys.given else None
    marks = keys.marks(source) if keys.given else []
    if keys.given and region is None and not any(mark for _, mark in marks):
        raise ConfigError(
            "The target is missing. Give --at FRAME=x,y,width,height, or --init x,y,width,height."
        )
    goal = checked_output(source, outputs, [] if outputs.figures is None else [outputs.figures])
    if outputs.resume and goal is None:
        raise ConfigError("--resume continues a file of rows; name it with -o.")

    from motes.cli.outputs import Request

    asked = Request(
        source=source, frames=frames, goal=goal, outputs=outputs, config=config,
        seed=values.seed, preset=preset, units=plane, resume=outputs.resume,
    )  # fmt: skip
    if begin is None:
        from motes.cli.track_between import track_between

        return track_between(asked, marks, region)

    from motes.cli.track_frames import track_one, track_several

    if len(regions := target.regions()) > 1:
        return track_several(asked, regions)
    return track_one(asked, begin, outputs.figures)


def _check_fitting(
    target: TargetOptions,
    keys: KeyframeOptions,
    frames: FrameOptions,
    outputs: TrackOutputs,
) -> None:
    """Raise a ConfigError for options that do not go with keyframes, or with several objects."""
    if keys.given:
        unfit: dict[str, object] = {
            "--stride": frames.stride != 1, "--resume": outputs.resume,
            "--figures": outputs.figures,
        }  # fmt: skip
        refuse(unfit, "not for keyframes" + ": motes refine finishes such rows" * outputs.resume)
        return
    if (count := len(target.regions())) > 1:
        if outputs.label and outputs.label.count(",") == count - 1:
            raise ConfigError(
                "--label is one class, of all objects; write those of each into the column label "
                "of the rows, and convert these."
            )
        refuse({"--figures": outputs.figures}, "for one --init")
