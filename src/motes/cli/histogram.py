"""`motes histogram`: save what a target looks like, to look for it later."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import check_not_source, point_out_leftovers, region_of
from motes.cli.load_config import tracker_config
from motes.cli.options import (
    CONFIG_HELP,
    FRAMES,
    OUTPUT,
    ConfigFile,
    Ellipse,
    Init,
    Overwrite,
    Preset,
    Settings,
    log,
)
from motes.core.errors import ConfigError

app = App(name="histogram", help_epilogue=CONFIG_HELP, help_format="plaintext")


@app.default
def histogram(
    source: str,
    /,
    *,
    output: Annotated[
        Path, Parameter(name=["--output", "-o"], group=OUTPUT, help="The file, as JSON.")
    ],
    init: Init = None,
    ellipse: Ellipse = None,
    frame: Annotated[int, Parameter(group=FRAMES, help="Frame to learn from.")] = 0,
    overwrite: Overwrite = False,
    preset: Preset = "nummiaro",
    config: ConfigFile = None,
    **settings: Settings,
) -> int:
    """Save the color histogram of a region, for `motes track --histogram`.

    Parameters
    ----------
    source
        A video, an image, a folder or pattern of images, the number of a camera, or an address.
    """
    from motes.sot.discriminative.tracker import Discriminative

    learning = tracker_config(histogram, preset, config, settings)
    color = None if isinstance(learning, Discriminative) else learning.color
    if color is None:
        raise ConfigError(f"Preset {preset} reads no colors; choose one that does, as nummiaro.")
    region = region_of(init, ellipse)
    if region is None or (init and ellipse):
        raise ConfigError("Where is the target? Give either --init x,y,width,height or --ellipse.")
    check_not_source(source, output)
    point_out_leftovers(output)

    from motes.core.geometry import region_within
    from motes.output.track_rows import check_writable
    from motes.sot.known_target import Target
    from motes.video.sources import open_source

    check_writable(output, overwrite)
    with open_source(source, start=frame, end=frame + 1) as film:
        picture = next(film)
    place = region_within(region, picture.width, picture.height)
    target = Target.learn(color, picture, place)
    target.save(output)
    log(
        f"wrote {output}: {(target.model.histogram > 0).sum()} of {target.model.histogram.size} "
        f"bins are occupied."
    )
    return DONE
