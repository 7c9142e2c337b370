"""The experiment that compares trackers with one other."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, worker_count
from motes.cli.options import RUN, Workers
from motes.core.errors import ConfigError
from motes_lab.cli.dataset_options import FirstPixel, Only, Seeds
from motes_lab.cli.experiment_inputs import films_of
from motes_lab.cli.experiment_output import ResultOptions, show


def pairs(
    dataset: Path,
    /,
    *tracker: str,
    sequence: Only = None,
    first_pixel: FirstPixel = None,
    measure: Annotated[
        Literal["iou", "auc", "od"], Parameter(group=RUN, help="What is compared.")
    ] = "iou",
    frames: Annotated[
        int, Parameter(group=RUN, help="Most frames of each film, from the target's first one.")
    ] = 150,
    every: Annotated[
        int, Parameter(group=RUN, help="Distance of these frames in the film; 3 is every third.")
    ] = 1,
    seeds: Seeds = 3,
    workers: Workers = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Claims of the papers on film: trackers beside one other.

    Parameters
    ----------
    dataset
        A folder of sequences or films as for motes-lab evaluate.
    tracker
        Trackers as for motes-lab evaluate; the first one is compared with the others.
    """
    check_counts(seeds=seeds, frames=frames, every=every)
    output = results.output("pairs")

    from motes_lab.adapters.registry import resolve
    from motes_lab.papers import pairs as experiment

    films, problems = films_of(dataset, first_pixel, sequence)
    trackers, unknown = resolve(tracker)
    if unknown or len(trackers) < 2:
        raise ConfigError(unknown[0].what if unknown else "Name two trackers or more to compare.")
    short = (experiment.shortened(film, frames, every) for film in films)
    tasks = [experiment.Shortened(film, trackers, seeds) for film in short if film]
    apart = f", {every} apart" if every > 1 else ""
    note = f"At most {frames} frames of each film{apart}; seeds: {seeds}."
    name, processes = dataset.resolve().name, worker_count(workers)
    return show(experiment.pairs(tasks, name, measure, note, processes), output, problems)
