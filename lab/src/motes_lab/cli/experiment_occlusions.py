"""The experiments on occlusions, rendered and on film."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, worker_count
from motes.cli.options import REPEATED, RUN, ObjectPreset, Workers
from motes.core.errors import ConfigError
from motes_lab.cli.dataset_options import Seeds
from motes_lab.cli.experiment_inputs import crowds_of
from motes_lab.cli.experiment_output import ResultOptions, show
from motes_lab.cli.experiment_scenes import Full, RenderedDetector, rendered_scene_factory

TRACKERS = ("motes:scene", "trackers:sort", "trackers:bytetrack")
"""Trackers that are compared on film by default."""


def occlusions(
    *,
    hidden: Annotated[
        list[int] | None,
        REPEATED,
        Parameter(
            help="Length of an occlusion in frames; may be repeated. The default is 15; with "
            "--full, it is 5, 15, 30, 45 and 60."
        ),
    ] = None,
    objects: Annotated[
        list[int] | None,
        REPEATED,
        Parameter(
            help="Number of objects; may be repeated. The default is 2 and 10; with --full, it is "
            "2, 10 and 50."
        ),
    ] = None,
    least: Annotated[
        int | None,
        Parameter(
            group=RUN,
            help="Least number of occlusions of each kind. The default is 2; with --full, it is "
            "10.",
        ),
    ] = None,
    detector: RenderedDetector = None,
    preset: ObjectPreset = "nummiaro:adaptive",
    full: Full = False,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Zhao and Pei, section 3: identities through full occlusions."""
    lengths = hidden or ([5, 15, 30, 45, 60] if full else [15])
    counts = objects or ([2, 10, 50] if full else [2, 10])
    least = (10 if full else 2) if least is None else least
    check_counts(least=least)
    if min(lengths) < 5:
        raise ConfigError(f"--hidden is {min(lengths)}; give 5 or more.")
    for count in counts:
        if count != 2 and (count < 10 or count % 10):
            raise ConfigError(f"--objects is {count}; give 2 or a multiple of 10.")
    output = results.output("occlusions", "lengths", "short")
    scene = rendered_scene_factory(detector, preset)

    from motes_lab.papers import occlusions as experiment

    kinds = experiment.kinds_of(lengths, counts)
    expected = experiment.expected(kinds, least, scene)
    return show(experiment.occlusions(kinds, least, scene), output, (), expected, full=full)


def real_occlusions(
    dataset: Path,
    /,
    *,
    tracker: Annotated[
        list[str] | None,
        REPEATED,
        Parameter(
            group=RUN,
            help="Tracker of many objects, as for motes-lab evaluate; may be repeated. The default "
            "is motes:scene, trackers:sort and trackers:bytetrack.",
        ),
    ] = None,
    detector: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="Detector, as for motes-lab evaluate. The default is each sequence's det/det.txt.",
        ),
    ] = None,
    seeds: Seeds = 5,
    workers: Workers = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Zhao and Pei, section 3: occlusions on film.

    Parameters
    ----------
    dataset
        A folder of sequences of many objects, as for motes-lab evaluate.
    """
    check_counts(seeds=seeds)
    output = results.output("real-occlusions")

    from motes_lab.adapters.registry import mot_tracker_spec, resolve, with_detector
    from motes_lab.papers import real_occlusions as experiment

    specs, unusable = resolve(tracker or TRACKERS, mot_tracker_spec)
    if not specs:
        raise ConfigError(f"No tracker can be used. {unusable[0].where}: {unusable[0].what}")
    if detector is not None:
        specs = with_detector(specs, detector)
    crowds, problems = crowds_of(dataset)
    steps = experiment.real_occlusions(crowds, specs, seeds, worker_count(workers))
    return show(steps, output, [*unusable, *problems])
