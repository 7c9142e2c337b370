"""The experiments of Maggio et al.."""

from __future__ import annotations

from pathlib import Path

from motes_lab.cli.experiment_inputs import ClipRuns, FilmRuns
from motes_lab.cli.experiment_output import ResultOptions


def maggio_table1(
    dataset: Path,
    /,
    *,
    runs: FilmRuns = FilmRuns(),
    results: ResultOptions = ResultOptions(),
) -> int:
    """Maggio et al., table 1: color, orientation and both.

    Parameters
    ----------
    dataset
        A folder of sequences as for motes-lab evaluate.
    """
    from motes_lab.papers.maggio_table1_figure5 import table1

    output = results.output("maggio-table1", "sequences", "means")
    return runs.show(table1, dataset, output)


def maggio_figure5(
    dataset: Path,
    /,
    *,
    runs: FilmRuns = FilmRuns(),
    results: ResultOptions = ResultOptions(),
) -> int:
    """Maggio et al., figure 5: FOH, ROH, adaptive weights and scale.

    Parameters
    ----------
    dataset
        A folder of sequences as for motes-lab evaluate.
    """
    from motes_lab.papers.maggio_table1_figure5 import figure5

    output = results.output("maggio-figure5", plot=True)
    return runs.show(figure5, dataset, output)


def maggio_figure3(
    *presets: str, runs: ClipRuns = ClipRuns(), results: ResultOptions = ResultOptions()
) -> int:
    """Maggio et al., figure 3: weights of cues that fail in turn.

    Parameters
    ----------
    presets
        Presets that fuse color and orientation; by default maggio:C+O-A-SS-ROH and
        maggio:printed.
    """
    from motes.synthetic.failing_cues import failing_cues
    from motes_lab.papers.maggio_figure3 import figure3

    names = presets or ("maggio:C+O-A-SS-ROH", "maggio:printed")
    output = results.output("maggio-figure3", plot=True)
    return runs.show(figure3, names, failing_cues, output)


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
