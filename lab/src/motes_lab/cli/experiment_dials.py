"""The experiment on films that are hard in one respect at a time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, worker_count
from motes.cli.messages import log
from motes.cli.options import OUTPUT, REPEATED, RUN, Workers
from motes.core.errors import ConfigError, FormatError
from motes_lab.cli.dataset_options import FirstPixel
from motes_lab.cli.experiment_inputs import films_of
from motes_lab.cli.experiment_output import ResultOptions, show
from motes_lab.cli.experiment_scenes import Full

TRACKERS = ("default", "nummiaro", "cv2:csrt")
LEVELS, SCENES, FRAMES = (0.0, 0.5, 1.0), 2, 40
FULL_LEVELS, FULL_SCENES, FULL_FRAMES = (0.0, 0.25, 0.5, 0.75, 1.0), 10, 60
MIN_FRAMES = 10


def dials(
    dataset: Path | None = None,
    /,
    *,
    first_pixel: FirstPixel = None,
    tracker: Annotated[
        list[str] | None,
        REPEATED,
        Parameter(
            group=RUN,
            help="Tracker to measure, as for motes-lab evaluate; may be repeated. The default is "
            f"{', '.join(TRACKERS)}.",
        ),
    ] = None,
    dial: Annotated[
        list[str] | None,
        REPEATED,
        Parameter(group=RUN, help="Dial to turn; may be repeated. The default is all of them."),
    ] = None,
    full: Full = False,
    scenes: Annotated[
        int | None, Parameter(group=RUN, help="Number of scenes for each dial and level.")
    ] = None,
    frames: Annotated[
        int | None,
        Parameter(group=RUN, help="Length of each film; in a shorter one, changes are faster."),
    ] = None,
    workers: Workers = None,
    films: Annotated[
        Path | None,
        Parameter(group=OUTPUT, help="Keep the films in this folder, as sequences."),
    ] = None,
    evaluated: Annotated[
        Path | None,
        Parameter(
            help="Folder of a motes-lab evaluate over films that were kept; its results are shown, "
            "and nothing is measured."
        ),
    ] = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Hard films: success against motion, light and others.

    With --full: five levels, 10 scenes and 60 frames; without: three, 2 and 40.

    Parameters
    ----------
    dataset
        A folder of sequences as for motes-lab evaluate, whose objects are cut out and put before
        frames of other sequences. By default scenes are rendered.
    """
    count = scenes if scenes is not None else FULL_SCENES if full else SCENES
    length = frames if frames is not None else FULL_FRAMES if full else FRAMES
    check_counts(scenes=count, frames=length)
    if length < MIN_FRAMES:
        raise ConfigError(f"--frames is {length}; give {MIN_FRAMES} or more.")
    output = results.output("dials", "means", "levels", plot=True)

    from motes_lab.dials import report
    from motes_lab.dials.measure import Grid, measured, of_evaluation
    from motes_lab.saved_scores import SavedScores

    if evaluated is not None:
        return show(report.results([of_evaluation(SavedScores.load(evaluated))]), output)
    if films is not None and films.is_dir() and any(films.iterdir()) and not results.overwrite:
        raise FormatError(f"The folder {films} is not empty; choose another, or give --overwrite.")

    from motes_lab.adapters.registry import resolve
    from motes_lab.datasets.film_cutouts import cut_out
    from motes_lab.dials.dials import DIALS, Dials
    from motes_lab.dials.scenes import Garden, Material

    chosen = tuple(dict.fromkeys(dial or DIALS))
    for name in chosen:
        Dials.at(name, 0.0)
    entries, problems = resolve(tracker or TRACKERS)
    if not entries:
        raise ConfigError("There is no tracker to run. " + problems[0].what)
    material: Material = Garden()
    if dataset is not None:
        sequences, unreadable = films_of(dataset, first_pixel)
        cutouts = cut_out(sequences)
        log(
            f"{len(cutouts.objects)} objects cut out, to be put before {len(cutouts.frames)} films."
        )
        material, problems = cutouts, [*problems, *unreadable]
    grid = Grid(chosen, FULL_LEVELS if full else LEVELS, count)
    steps = measured(entries, grid, material, length, worker_count(workers), films)
    return show(report.results(steps), output, problems)
