"""The experiments of Nummiaro et al.."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from motes.cli.input_checks import check_counts
from motes.cli.options import FLAG, RUN, ObjectPreset
from motes.core.errors import ConfigError
from motes_lab.cli.dataset_options import Region, Seeds
from motes_lab.cli.experiment_inputs import ClipRuns, Clips, crowds_of, views_of
from motes_lab.cli.experiment_output import ResultOptions, show
from motes_lab.cli.experiment_scenes import Full, RenderedDetector, rendered_scene_factory

if TYPE_CHECKING:
    from motes_lab.datasets.sot import Problem


def nummiaro_leaps(
    *presets: str, runs: ClipRuns = ClipRuns(), results: ResultOptions = ResultOptions()
) -> int:
    """Nummiaro et al., section VI: regions that do not overlap.

    Parameters
    ----------
    presets
        Presets; by default nummiaro, nummiaro:adaptive, mean_shift and mean_shift:kalman.
    """
    from motes import synthetic
    from motes_lab.papers import rendered_claims

    names = presets or ("nummiaro", "nummiaro:adaptive", "mean_shift", "mean_shift:kalman")
    output = results.output("nummiaro-leaps")
    return runs.show(rendered_claims.leaps, names, synthetic.jumping, output)


def two_rooms(
    *,
    seeds: Annotated[
        int | None,
        Parameter(
            group=RUN,
            help="Number of pairs of rooms, with one run in each. The default is 1; with --full, "
            "it is 5.",
        ),
    ] = None,
    frames: Annotated[int, Parameter(group=RUN, help="Length of each run in frames.")] = 1500,
    detector: RenderedDetector = "gaussian",
    preset: ObjectPreset = "nummiaro:adaptive",
    full: Full = False,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Nummiaro et al., section VII: from room to room."""
    seeds = (5 if full else 1) if seeds is None else seeds
    check_counts(seeds=seeds, frames=frames)
    output = results.output("two-rooms")
    scene = rendered_scene_factory(detector, preset)

    from motes_lab.papers import two_rooms as rooms

    expected = rooms.expected(seeds, frames, scene)
    return show(rooms.two_rooms(seeds, frames, scene), output, (), expected, full=full)


def handover(
    dataset: Path | None = None,
    /,
    *,
    known: Annotated[
        bool, FLAG, Parameter(help="Both cameras wait for one person whose histogram is known.")
    ] = False,
    apart: Annotated[
        bool,
        FLAG,
        Parameter(help="The pictures of a dataset's films do not overlap, as of two rooms."),
    ] = False,
    seeds: Seeds = 1,
    clips: Clips = 3,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Nummiaro et al., section VII: overlapping cameras hand over.

    Parameters
    ----------
    dataset
        A folder of sequences with people, as for motes-lab evaluate. Each film is cut in two
        pictures. By default films are rendered.
    """
    check_counts(seeds=seeds, clips=clips)
    if apart and (known or dataset is None):
        raise ConfigError("--apart needs a dataset and goes without --known; see two-rooms.")
    output = results.output("handover")

    from motes_lab.papers import handover as experiment
    from motes_lab.papers.known_person import known_person
    from motes_lab.papers.rooms_on_film import rooms_on_film

    problems: list[Problem] = []
    if dataset is None:
        films = [experiment.rendered_film(seed) for seed in range(clips)]
    else:
        crowds, problems = crowds_of(dataset)
        films = [experiment.real_film(each) for each in crowds]
    run = known_person if known else rooms_on_film if apart else experiment.handover
    return show(run(films, seeds), output, problems)


def nummiaro_figure9(
    source: str | None = None,
    /,
    *,
    init: Region = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Nummiaro et al., figure 9: the color histogram of a target.

    Parameters
    ----------
    source
        A picture or a video, with --init. By default a rendered target is used.
    """
    with contextlib.closing(views_of(source, init, "nummiaro", 1)) as views:
        output = results.output("nummiaro-figure9", plot=True)

        from motes_lab.papers import nummiaro_figure9

        return show(nummiaro_figure9.figure9(next(views)), output)
