"""Ng and Delp, table 1: histograms of some of a region's pixels compared with those of all."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from motes import Ellipse, Frame, Status, Tracker, configure, open_source
from motes.cli import numbers_of
from motes.core import Floats, region_within
from motes.cues import HistogramCue, bhattacharyya
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import Region
from motes_lab.metrics.statistics import over
from motes_lab.report.tables import Cell, Row, Table, number, percent

ALL = "all pixels"
LATTICES = {f"lattice of {points}": points for points in (64, 128, 256, 512)}
SAMPLINGS: dict[str, dict[str, object]] = {
    ALL: {"type": "every_pixel"},
    "half": {"type": "checkerboard", "share": "half"},
    "quarter": {"type": "checkerboard", "share": "quarter"},
    **{name: {"type": "lattice", "points": points} for name, points in LATTICES.items()},
}
SIGMA = 0.15  # of the likelihood, equation 22: caption of table 1

REGIONS_PER_TIMING = 50
"""Number of regions timed together, since the call takes as long as a single histogram."""
JITTER = 2.0
"""Standard deviation of the regions' positions, in pixels.

Particles differ in the same way, and the processor cannot profit from equal ones.
"""
ROUNDS = 40
"""Number of timings of a single picture; a frame of a video is timed once."""


def ng_delp_table1(
    source: str, /, *, init: Region, results: ResultOptions = ResultOptions()
) -> int:
    """Ng and Delp, table 1: histograms over a part of the pixels.

    Parameters
    ----------
    source
        A picture or a video; ng_delp follows the target of a video.
    """
    box = numbers_of("--init", init, "x,y,width,height")
    return results.show("ng-delp-table1", table1(followed(source, box)))


class View(NamedTuple):
    """A picture and a region in it."""

    frame: Frame
    """The picture."""
    region: Ellipse | None
    """The target; None if its tracker has lost it."""
    still: bool
    """Whether this is a single picture, not a frame of a video."""


def followed(source: str, box: Sequence[float]) -> Iterator[View]:
    """Yield the frames of a source, with the target of its first frame where it is followed."""
    with open_source(source) as film:
        first, still = next(film), film.frame_count == 1
        region = region_within(box, first.width, first.height)
        yield View(first, region, still)
        tracker = Tracker("ng_delp")
        tracker.init(first, region)
        for frame in film:
            track = tracker.update(frame)
            found = track.status is Status.TRACKING
            yield View(frame, track.ellipse if found else None, still)


class Paper(NamedTuple):
    """A column of the paper's table 1, which is for color."""

    rho: float
    distance: float
    likelihood: float
    seconds: float


PAPER = {
    ALL: Paper(1, 0, 1, 0.1304),
    "half": Paper(0.9998, 0.0157, 0.9946, 0.0498),
    "quarter": Paper(0.9993, 0.0258, 0.9853, 0.0252),
}


def cue_of(preset: str, name: str, sampling: Mapping[str, object]) -> HistogramCue:
    """Return a cue of a preset that reads these pixels of a region."""
    cue = configure(preset, {name: {"sampling": sampling}}).cues[name]
    assert isinstance(cue, HistogramCue)
    return cue


class Sample(NamedTuple):
    """The results of one region, with a number for each of the `SAMPLINGS`."""

    distances: Floats
    """(S,), distances from the histogram of all pixels."""
    seconds: Floats
    """(rounds, S), processor time of a histogram."""


def sample(
    cues: Sequence[HistogramCue], frame: Frame, ellipse: Ellipse, rounds: int
) -> Sample | None:
    """Compare a region's histograms of several cues with that of the first, and time them in turn.

    Values that a cue computes for the whole picture, such as Sobel's edges, are not timed: they are
    computed once for all regions. Returns None if no part of the region is in the picture.
    """
    regions = np.tile(np.array(ellipse), (1 + REGIONS_PER_TIMING, 1))
    regions[1:, :2] += np.random.default_rng(frame.index).normal(0, JITTER, (REGIONS_PER_TIMING, 2))
    histograms = [cue.histograms(frame, regions)[0] for cue in cues]
    if not histograms[0].any():
        return None
    seconds = np.empty((rounds, len(cues)))
    for row in seconds:
        for column, cue in enumerate(cues):
            start = time.thread_time()
            cue.histograms(frame, regions)
            row[column] = time.thread_time() - start
    return Sample(bhattacharyya(np.array(histograms), histograms[0]), seconds / len(regions))


def table1(views: Iterable[View]) -> Experiment:
    """Yield table 1 for the views so far, for the color histogram and for that of edges."""
    cues = {
        name: [cue_of("ng_delp", name, each) for each in SAMPLINGS.values()]
        for name in ("color", "edges")
    }
    samples: dict[str, list[Sample]] = {name: [] for name in cues}
    sizes = []
    for seen, (frame, region, still) in enumerate(views, 1):
        if region is not None:
            sizes.append(region.box[2:])
            for name, each in cues.items():
                found = sample(each, frame, region, ROUNDS if still else 1)
                if found is not None:
                    samples[name].append(found)
        width, height = np.median(sizes, axis=0)
        where = f"ellipses of {width:.0f}x{height:.0f} pixels in {len(sizes)} of {seen} pictures"
        tables = {name: _table(name, each, where) for name, each in samples.items() if each}
        yield Result(tables, progress=f"picture {seen}")


def _table(name: str, samples: Sequence[Sample], where: str) -> Table:
    distances = np.array([sample.distances for sample in samples])
    seconds = np.concatenate([sample.seconds for sample in samples])
    likelihoods = np.exp(-(distances**2) / (2 * SIGMA**2))
    columns = zip(
        (1 - distances**2).T,
        distances.T,
        likelihoods.T,
        np.median(seconds, axis=0),
        np.median(seconds / seconds[:, :1], axis=0),
        strict=True,
    )
    rows: list[Row] = []
    for pixels, (rho, distance, likelihood, taken, share) in zip(SAMPLINGS, columns, strict=True):
        fit = [number(over(values), 4) for values in (rho, distance, likelihood)]
        rows.append((Cell(pixels), *fit, number(1e6 * taken, 1), percent(share)))
        if name == "color" and (paper := PAPER.get(pixels)):
            fit = [number(value, 4) for value in paper[:3]]
            share = paper.seconds / PAPER[ALL].seconds
            time = number(1e6 * paper.seconds, 0)
            rows.append((Cell(f"{pixels}, paper"), *fit, time, percent(share)))
    head = ("pixels read", "rho", "distance", "likelihood", "µs", "against all")
    note = (
        "Likelihood with sigma 0.15. Median processor time of a histogram, measured in turn"
        + ", without Sobel's operator, which is the same for all" * (name == "edges")
        + "."
    )
    return Table(f"Histograms of {name}: {where}", head, rows, note=note)
