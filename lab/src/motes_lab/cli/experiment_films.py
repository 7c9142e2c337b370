"""The experiments on films of one's own: trackers in pairs, moving cameras, masks, corrections."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, worker_count
from motes.cli.options import RUN, ObjectPreset, Preset, Seed, Workers
from motes.core.errors import ConfigError
from motes_lab.cli.dataset_options import FirstPixel, Only, Seeds
from motes_lab.cli.experiment_inputs import crowds_of, films_of
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


def masks(
    dataset: Path,
    /,
    *,
    first_pixel: FirstPixel = None,
    sequences: Only = None,
    preset: Annotated[str, Parameter(group=RUN, help="Preset of the tracker.")] = "default",
    seed: Annotated[int, Parameter(group=RUN, help="Seed of the random numbers.")] = 0,
    every: Annotated[
        int, Parameter(group=RUN, help="Compare every n-th frame; GrabCut takes long.")
    ] = 5,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Masks of motes track, and of GrabCut on the same ellipses.

    Parameters
    ----------
    dataset
        A folder of sequences, as for motes-lab evaluate. Where a sequence has no folder masks, the
        box around each mask is compared with the box of the truth.
    """
    check_counts(every=every)
    output = results.output("masks", "masks", "boxes")
    films, problems = films_of(dataset, first_pixel, sequences)

    from motes_lab.mask_overlap import masks

    return show(masks(films, preset, seed, every), output, problems)


def moving_camera(
    dataset: Path,
    /,
    *drones: Path,
    preset: ObjectPreset = "nummiaro:adaptive",
    seeds: Seeds = 1,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Hard films: identities before a camera that moves.

    Parameters
    ----------
    dataset
        A folder of sequences of many objects, as for motes-lab evaluate, from still cameras. They
        are seen by a camera that pans, turns, zooms and shakes.
    drones
        Folders of sequences of one object, from cameras that move.
    """
    check_counts(seeds=seeds)
    output = results.output("moving-camera", "motion", "identities", "drones")

    from motes.mot.scene_config import scene_config
    from motes_lab.papers import moving_camera as experiment

    config = scene_config(preset)
    crowds, problems = crowds_of(dataset)
    films = []
    for folder in drones:
        found, failed = films_of(folder, ["0"])
        films += found
        problems += failed
    return show(experiment.moving_camera(crowds, films, config, seeds), output, problems)


def effort(
    dataset: Path,
    /,
    *,
    first_pixel: FirstPixel = None,
    preset: Preset = "default",
    seed: Seed = 0,
    rule: Annotated[
        Literal["check", "worst"],
        Parameter(
            group=RUN,
            help="The next keyframe: the frame of the largest expected gain, as in motes check, or "
            "the worst one.",
        ),
    ] = "check",
    workers: Workers = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Effort of annotation: keyframes until 95 % is right.

    A simulated annotator marks the first frame, and then one frame after the other with its true
    box, until 95 % of the frames have an IoU of 0.7 or more. Between the keyframes are tracks in
    both directions, a track that is started anew at each keyframe, or linear interpolation.

    Parameters
    ----------
    dataset
        A folder of sequences as for motes-lab evaluate.
    """
    output = results.output("effort", "means", "sequences", plot=True)

    from motes.sot.presets import preset as named
    from motes_lab.effort import report
    from motes_lab.effort.measure import measured

    films, problems = films_of(dataset, first_pixel)
    steps = measured(films, named(preset), rule, seed, worker_count(workers))
    return show(report.results(steps, rule), output, problems)
