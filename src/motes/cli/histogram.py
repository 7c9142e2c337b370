"""`motes histogram`: save the histograms of a target, to search for it later."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_not_source, point_out_leftovers, region_of
from motes.cli.load_config import tracker_config
from motes.cli.messages import log
from motes.cli.options import (
    FRAMES,
    HYPHEN,
    OUTPUT,
    TARGET,
    ConfigFile,
    Ellipse,
    Overwrite,
    Preset,
)
from motes.cli.settings import HELP, Settings
from motes.core.errors import ConfigError

app = App(
    name="histogram",
    help_epilogue=HELP.format(example="--color.bins 8,8,8", command="motes config PRESET"),
    help_format="plaintext",
)


@app.default
def histogram(
    source: str,
    /,
    *,
    output: Annotated[
        Path, Parameter(name=["--output", "-o"], group=OUTPUT, help="JSON file of the histogram.")
    ],
    init: Annotated[
        str | None, HYPHEN, Parameter(group=TARGET, help="Box: x,y,width,height.")
    ] = None,
    ellipse: Ellipse = None,
    start: Annotated[int, Parameter(group=FRAMES, help="Frame of the target.")] = 0,
    overwrite: Overwrite = False,
    preset: Preset = "nummiaro",
    config: ConfigFile = None,
    **settings: Settings,
) -> int:
    """Save the histograms of a region, for `motes track --histogram` with the same preset.

    Parameters
    ----------
    source
        A video, an image, a folder or pattern of images, the number of a camera, or an address.
    """
    from motes.sot.discriminative.tracker import Discriminative

    learning = tracker_config(app, preset, config, settings)
    if isinstance(learning, Discriminative):
        raise ConfigError(
            f"Preset {preset} cannot search for a known target; choose another, such as nummiaro."
        )
    region = region_of(init, ellipse)
    if region is None or (init and ellipse):
        raise ConfigError(
            "The target is missing. Give either --init x,y,width,height or --ellipse."
        )
    check_not_source(source, output)
    point_out_leftovers(output)

    from motes.core.geometry import region_within
    from motes.output.track_rows import check_writable
    from motes.sot.known_target import Target
    from motes.video.sources import open_source

    check_writable(output, overwrite)
    with open_source(source, start=start, end=start + 1) as film:
        picture = next(film)
    place = region_within(region, picture.width, picture.height)
    target = Target.learn(learning.cues, picture, place)
    target.save(output)
    occupied = (
        f"{(model.histogram > 0).sum()} of {model.histogram.size} bins of {name}"
        for name, model in target.models.items()
    )
    log(f"wrote {output}: {' and '.join(occupied)} are occupied.")
    return DONE
