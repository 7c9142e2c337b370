"""The experiment on the effort of correcting tracks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from motes.cli.input_checks import worker_count
from motes.cli.options import RUN, Preset, Seed, Workers
from motes_lab.cli.dataset_options import FirstPixel
from motes_lab.cli.experiment_inputs import films_of
from motes_lab.cli.experiment_output import ResultOptions, show


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
