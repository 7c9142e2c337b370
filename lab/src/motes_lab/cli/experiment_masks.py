"""The experiment on masks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from motes.cli.input_checks import check_counts
from motes.cli.options import RUN
from motes_lab.cli.dataset_options import FirstPixel, Only
from motes_lab.cli.experiment_inputs import films_of
from motes_lab.cli.experiment_output import ResultOptions, show


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
