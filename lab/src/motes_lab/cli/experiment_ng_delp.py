"""The experiments of Ng and Delp."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from motes.cli.input_checks import check_counts
from motes.cli.options import RUN
from motes_lab.cli.dataset_options import Region
from motes_lab.cli.experiment_inputs import views_of
from motes_lab.cli.experiment_output import ResultOptions, show


def ng_delp_table1(
    source: str | None = None,
    /,
    *,
    init: Region = None,
    preset: Annotated[str, Parameter(help="Preset that tracks the target of a video.")] = "ng_delp",
    seeds: Annotated[
        int, Parameter(group=RUN, help="Number of runs of the tracker, or of rendered targets.")
    ] = 1,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Ng and Delp, table 1: histograms over a part of the pixels.

    Parameters
    ----------
    source
        A picture or a video, with --init. By default a rendered target is used.
    """
    check_counts(seeds=seeds)
    views = views_of(source, init, preset, seeds)
    output = results.output("ng-delp-table1", "color", "edges")

    from motes_lab.papers import ng_delp_table1

    return show(ng_delp_table1.table1(views), output)


def ng_delp_figure3(*, results: ResultOptions = ResultOptions()) -> int:
    """Ng and Delp, figure 3: likelihood against distance."""
    output = results.output("ng-delp-figure3", plot=True)

    from motes_lab.papers import ng_delp_figure3

    return show(ng_delp_figure3.figure3(), output)
