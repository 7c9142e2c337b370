"""The experiments of Maggio et al.."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from motes.cli.input_checks import check_counts, error_context, read_text
from motes.cli.options import RUN
from motes.core.errors import ConfigError
from motes_lab.cli.dataset_options import Seeds
from motes_lab.cli.experiment_inputs import ClipRuns, Clips, films_of
from motes_lab.cli.experiment_output import ResultOptions, show


def maggio_figure3(
    *presets: str,
    film: Annotated[
        Path | None,
        Parameter(
            group=RUN, help="A sequence as for motes-lab evaluate. By default a film is rendered."
        ),
    ] = None,
    marks: Annotated[
        Path | None,
        Parameter(
            group=RUN,
            help="A TOML file with parts of --film, covered and clear: first and last frames. "
            "Without it parts are compared by --by.",
        ),
    ] = None,
    by: Annotated[
        Literal["sharpness", "size"],
        Parameter(group=RUN, help="What tells the parts of --film from each other."),
    ] = "sharpness",
    frames: Annotated[int, Parameter(group=RUN, help="Most frames of --film.")] = 1000,
    seeds: Seeds = 5,
    clips: Clips = 3,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Maggio et al., figure 3: weights of cues that fail in turn.

    Parameters
    ----------
    presets
        Presets that fuse color and orientation; by default maggio:C+O-A-SS-ROH and
        maggio:printed.
    """
    check_counts(seeds=seeds, clips=clips, frames=frames)
    if marks is not None and film is None:
        raise ConfigError("--marks belongs to a film; name it with --film, or omit --marks.")
    output = results.output("maggio-figure3", plot=film is None)

    from motes_lab.papers import maggio_figure3, maggio_figure3_film
    from motes_lab.papers.failing_cues import failing_cues

    names = presets or ("maggio:C+O-A-SS-ROH", "maggio:printed")
    if film is None:
        rendered = [failing_cues(seed) for seed in range(clips)]
        return show(maggio_figure3.figure3(names, rendered, seeds), output)
    [sequence, *_], problems = films_of(film, None)
    parts = None
    if marks is not None:
        text = read_text(marks)
        with error_context(marks):
            parts = maggio_figure3_film.parse_marks(text, str(marks))
    run = maggio_figure3_film.figure3(names, sequence, parts, by, frames, seeds)
    return show(run, output, problems)


def maggio_rotation(
    *presets: str, runs: ClipRuns = ClipRuns(), results: ResultOptions = ResultOptions()
) -> int:
    """Maggio et al., section 3.2.1: a target that turns.

    Parameters
    ----------
    presets
        Presets; by default maggio and all its variants.
    """
    from motes import synthetic
    from motes.sot.presets import PRESETS
    from motes_lab.papers import rendered_claims

    names = presets or tuple(name for name in PRESETS if name.startswith("maggio"))
    output = results.output("maggio-rotation")
    return runs.show(rendered_claims.rotation, names, synthetic.turning, output)


def maggio_growth(
    *presets: str, runs: ClipRuns = ClipRuns(), results: ResultOptions = ResultOptions()
) -> int:
    """Maggio et al., section 3.2.2: a target that grows.

    Parameters
    ----------
    presets
        Presets; by default maggio, maggio:C and the adaptive variants.
    """
    from motes import synthetic
    from motes_lab.papers import rendered_claims

    adaptive = ("maggio:C+O-A-ROH", "maggio:C+O-A-SS-FOH", "maggio:C+O-A-FOH")
    names = presets or ("maggio:C", "maggio", *adaptive)
    output = results.output("maggio-growth", "tracks", "histograms")
    return runs.show(rendered_claims.growth, names, synthetic.growing, output)
