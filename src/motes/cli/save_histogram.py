"""`motes track --save-histogram`: the colors of a target, to search for it later."""

from __future__ import annotations

from pathlib import Path

from motes.cli.exit_codes import DONE
from motes.cli.input_checks import (
    check_not_source,
    point_out_corners,
    point_out_leftovers,
    refuse,
)
from motes.cli.messages import log
from motes.cli.option_groups import FrameOptions
from motes.cli.track_options import TargetOptions, TrackOutputs
from motes.core.errors import ConfigError
from motes.core.geometry import region_within
from motes.cues.color import Color
from motes.rows.writer import check_writable
from motes.sot.known_target import KnownTarget
from motes.sot.presets import TrackerConfig
from motes.video.sources import open_source


def save_histogram(
    source: str,
    output: Path,
    target: TargetOptions,
    frames: FrameOptions,
    outputs: TrackOutputs,
    config: TrackerConfig,
    preset: str,
) -> int:
    """Save the colors of the target in the first frame, without tracking; return the exit code.

    Raises
    ------
    ConfigError
        If the tracker does not compare colors alone, the target is not one region, or another
        output is given.
    SourceError
        If there is no such frame.
    FormatError
        If the file exists and must not be overwritten, or cannot be written.
    """
    color = config.cues.get("color")
    if not isinstance(color, Color) or len(config.cues) > 1:
        raise ConfigError(
            f"Preset {preset} cannot search by color alone; choose another, such as nummiaro."
        )
    refuse(
        {
            "-o": outputs.output, "--overlay": outputs.overlay, "--figures": outputs.figures,
            "--show": outputs.show, "--resume": outputs.resume,
        },
        "for tracks, and --save-histogram tracks nothing",
    )  # fmt: skip
    refuse(
        {"--histogram": target.histogram, "--detect": target.detect, "--places": target.places},
        "for a search, and --save-histogram tracks nothing",
    )
    regions = target.regions()
    if len(regions) != 1:
        raise ConfigError("--save-histogram is of one target; give one --init x,y,width,height.")
    check_not_source(source, output)
    point_out_leftovers(output)
    check_writable(output, outputs.overwrite)
    with open_source(source, start=frames.start, end=frames.start + 1) as film:
        picture = next(film)
    region = region_within(regions[0], picture.width, picture.height)
    point_out_corners(regions[0], picture.width, picture.height)
    known = KnownTarget.learn(color, picture, region)
    known.save(output)
    histogram = known.model.histogram
    log(f"wrote {output}: {(histogram > 0).sum()} of {histogram.size} bins of color are occupied.")
    return DONE
