"""The experiment of cameras that move."""

from __future__ import annotations

from pathlib import Path

from motes.cli.input_checks import check_counts
from motes.cli.options import ObjectPreset
from motes_lab.cli.dataset_options import Seeds
from motes_lab.cli.experiment_inputs import crowds_of, films_of
from motes_lab.cli.experiment_output import ResultOptions, show


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
