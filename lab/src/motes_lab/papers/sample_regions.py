"""Pictures with a region, for experiments on histograms."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from pathlib import Path
from typing import NamedTuple

from motes import synthetic
from motes.core.frame import Frame
from motes.core.geometry import Ellipse, region_within
from motes.core.track import Status
from motes.sot.presets import preset
from motes.sot.tracker import Tracker
from motes.video.sources import open_source


class View(NamedTuple):
    """A picture and a region in it.

    Attributes
    ----------
    frame
        The picture.
    region
        The target; None if its tracker has lost it.
    still
        Whether this is a single picture, not a frame of a video.
    """

    frame: Frame
    region: Ellipse | None
    still: bool


def rendered(count: int) -> Generator[View, None, None]:
    """Yield a rendered target of 60x100 pixels in `count` sceneries."""
    for seed in range(count):
        frame, (target,) = synthetic.still((640, 480), target=(60, 100), frames=1, seed=seed)[0]
        yield View(frame, target.ellipse, still=True)


def followed(
    source: str | Path, region: Sequence[float], name: str, seeds: int
) -> Generator[View, None, None]:
    """Yield the frames of a source, with the target where a tracker follows it.

    The first region is the given one. A video is followed once with each seed; a single picture
    needs no tracker and is given once.

    Parameters
    ----------
    source
        The source, as for `open_source`.
    region
        The target in the first frame, as box or ellipse.
    name
        The tracker's preset.
    seeds
        Number of runs.

    Raises
    ------
    ConfigError
        If there is no such preset, or the region does not fit the first frame.
    SourceError
        If the source cannot be read.
    """
    config = preset(name)
    for seed in range(seeds):
        with open_source(source) as film:
            first, still = next(film), film.frame_count == 1
            ellipse = region_within(region, first.width, first.height)
            yield View(first, ellipse, still)
            if still:
                return
            tracker = Tracker(config, seed)
            tracker.init(first, ellipse)
            for frame in film:
                track = tracker.update(frame)
                found = track.status is Status.TRACKING
                yield View(frame, track.ellipse if found else None, still)
