"""The experiments of Maggio et al.."""

from __future__ import annotations

from motes.cli.input_checks import check_counts
from motes.cli.options import Seeds
from motes_lab.cli.experiment_inputs import ClipRuns, Clips
from motes_lab.cli.experiment_output import ResultOptions, show


def maggio_figure3(
    *presets: str,
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
    check_counts(seeds=seeds, clips=clips)
    output = results.output("maggio-figure3", plot=True)

    from motes.synthetic.failing_cues import failing_cues
    from motes_lab.papers import maggio_figure3 as experiment

    names = presets or ("maggio:C+O-A-SS-ROH", "maggio:printed")
    films = [failing_cues(seed) for seed in range(clips)]
    return show(experiment.figure3(names, films, seeds), output)


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
