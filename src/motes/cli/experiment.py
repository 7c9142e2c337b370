"""`motes experiment`: what the papers tabulate or plot, on this machine, beside their numbers."""

from __future__ import annotations

import contextlib
import difflib
import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.cli.experiment_output import Out, Output, show
from motes.cli.input_checks import check_counts, first_pixels, numbers_of, worker_count
from motes.cli.options import RUN, FirstPixel, Overwrite, Workers, announce_compiling
from motes.core.errors import ConfigError, SourceError

if TYPE_CHECKING:
    from motes.evaluation.datasets.sot import Problem
    from motes.evaluation.datasets.sot import Sequence as Film
    from motes.evaluation.papers.result import Experiment
    from motes.evaluation.synthetic.clips import Clip

app = App(name="experiment", help_format="plaintext")

Region = Annotated[
    str | None,
    Parameter(allow_leading_hyphen=True, help="The target in the first frame: x,y,width,height."),
]
Seeds = Annotated[int, Parameter(group=RUN, help="Runs of a tracker that draws numbers.")]
Clips = Annotated[int, Parameter(group=RUN, help="Sceneries.")]


@app.default
def experiment(
    *name: Annotated[str, Parameter(show=False, allow_leading_hyphen=True)],
    list: Annotated[  # noqa: A002
        bool, Parameter(negative=(), show_default=False, help="List the experiments.")
    ] = False,
) -> int:
    """Reproduce what the papers tabulate or plot, beside their own numbers.

    Without a name, list the experiments. What motes track --figures draws of a run is there:
    Nummiaro et al., figures 3, 7, 12 and 14, and Maggio et al., figures 1 and 3.
    """
    known = {each: app[each].default_command for each in app if not each.startswith("-")}
    if name:
        near = difflib.get_close_matches(name[0], known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}."
        raise ConfigError(f"There is no experiment {name[0]}; {hint}")
    for each, command in known.items():
        print(f"{each:<18}{(inspect.getdoc(command) or '').splitlines()[0]}")
    return DONE


@app.command(name="ng-delp-table1")
def ng_delp_table1(
    source: str | None = None,
    /,
    *,
    region: Region = None,
    preset: Annotated[str, Parameter(help="Who follows the target through a film.")] = "ng_delp",
    seeds: Annotated[
        int, Parameter(group=RUN, help="Runs of the tracker, or sceneries that are rendered.")
    ] = 1,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Ng and Delp, table 1: histograms over a part of the pixels.

    Parameters
    ----------
    source
        A picture or a film, with --region; else a rendered target is read.
    """
    check_counts(seeds=seeds)
    box = _region_of(source, region)
    output = Output("ng-delp-table1", ("color", "edges"), out, overwrite)

    from motes.evaluation.papers import ng_delp_table1, sample_regions

    announce_compiling()
    found = (
        sample_regions.followed(source, box, preset, seeds)
        if source and box
        else sample_regions.rendered(seeds)
    )
    return show(ng_delp_table1.table1(found), output)


@app.command(name="ng-delp-figure3")
def ng_delp_figure3(
    *,
    sigma: Annotated[float, Parameter(help="Of equations 22 and 23.")] = 0.15,
    epsilon: Annotated[float, Parameter(help="Of equations 23 and 24.")] = 0.1,
    nearest: Annotated[float, Parameter(help="Distance of the best particle in 24.")] = 0.4,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Ng and Delp, figure 3: likelihood against distance."""
    output = Output("ng-delp-figure3", ("",), out, overwrite, plot=True)

    from motes.evaluation.papers import ng_delp_figure3

    return show(ng_delp_figure3.figure3(sigma, epsilon, nearest), output)


@app.command(name="nummiaro-leaps")
def nummiaro_leaps(
    *presets: str,
    seeds: Seeds = 5,
    clips: Clips = 3,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Nummiaro et al., section VI: regions that do not overlap.

    Parameters
    ----------
    presets
        Trackers; nummiaro, nummiaro:adaptive, mean_shift and mean_shift:kalman if none is named.
    """
    from motes.evaluation import synthetic
    from motes.evaluation.papers import rendered_claims

    names = presets or ("nummiaro", "nummiaro:adaptive", "mean_shift", "mean_shift:kalman")
    output = Output("nummiaro-leaps", ("",), out, overwrite)
    return _on_clips(rendered_claims.leaps, names, synthetic.jumping, seeds, clips, output)


@app.command(name="two-rooms")
def two_rooms(
    *,
    seeds: Annotated[int, Parameter(group=RUN, help="Rooms and runs.")] = 5,
    frames: Annotated[int, Parameter(group=RUN, help="Length of each run.")] = 1500,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Nummiaro et al., section VII: from room to room."""
    check_counts(seeds=seeds, frames=frames)
    output = Output("two-rooms", ("",), out, overwrite)

    from motes.evaluation.papers import two_rooms as rooms

    announce_compiling()
    return show(rooms.two_rooms(seeds, frames), output)


@app.command(name="nummiaro-figure9")
def nummiaro_figure9(
    source: str | None = None,
    /,
    *,
    region: Region = None,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Nummiaro et al., figure 9: the color histogram of a target.

    Parameters
    ----------
    source
        A picture or a film, with --region; else a rendered target is read.
    """
    box = _region_of(source, region)
    output = Output("nummiaro-figure9", ("",), out, overwrite, plot=True)

    from motes.evaluation.papers import nummiaro_figure9, sample_regions

    announce_compiling()
    found = (
        sample_regions.followed(source, box, "nummiaro", 1)
        if source and box
        else sample_regions.rendered(1)
    )
    with contextlib.closing(found):
        return show(nummiaro_figure9.figure9(next(found)), output)


@app.command(name="maggio-table1")
def maggio_table1(
    dataset: Path,
    /,
    *,
    first_pixel: FirstPixel = None,
    seeds: Seeds = 5,
    workers: Workers = None,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Maggio et al., table 1: color, orientation and both.

    Parameters
    ----------
    dataset
        A folder of sequences as for motes evaluate.
    """
    check_counts(seeds=seeds)
    output = Output("maggio-table1", ("sequences", "means"), out, overwrite)
    films, problems = _films(dataset, first_pixel)

    from motes.evaluation.papers import maggio_table1_figure5

    steps = maggio_table1_figure5.table1(films, seeds, worker_count(workers))
    return show(steps, output, problems)


@app.command(name="maggio-figure5")
def maggio_figure5(
    dataset: Path,
    /,
    *,
    first_pixel: FirstPixel = None,
    seeds: Seeds = 5,
    workers: Workers = None,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Maggio et al., figure 5: FOH, ROH, adaptive weights and scale.

    Parameters
    ----------
    dataset
        A folder of sequences as for motes evaluate.
    """
    check_counts(seeds=seeds)
    output = Output("maggio-figure5", ("",), out, overwrite, plot=True)
    films, problems = _films(dataset, first_pixel)

    from motes.evaluation.papers import maggio_table1_figure5

    steps = maggio_table1_figure5.figure5(films, seeds, worker_count(workers))
    return show(steps, output, problems)


@app.command(name="maggio-rotation")
def maggio_rotation(
    *presets: str,
    seeds: Seeds = 5,
    clips: Clips = 3,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Maggio et al., section 3.2.1: a target that turns.

    Parameters
    ----------
    presets
        Trackers; maggio and all its variants if none is named.
    """
    from motes.evaluation import synthetic
    from motes.evaluation.papers import rendered_claims
    from motes.sot.presets import PRESETS

    names = presets or tuple(name for name in PRESETS if name.startswith("maggio"))
    output = Output("maggio-rotation", ("",), out, overwrite)
    return _on_clips(rendered_claims.rotation, names, synthetic.turning, seeds, clips, output)


@app.command(name="maggio-growth")
def maggio_growth(
    *presets: str,
    seeds: Seeds = 5,
    clips: Clips = 3,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Maggio et al., section 3.2.2: a target that grows.

    Parameters
    ----------
    presets
        Trackers; maggio, maggio:C and the adaptive variants if none is named.
    """
    from motes.evaluation import synthetic
    from motes.evaluation.papers import rendered_claims

    adaptive = ("maggio:C+O-A-ROH", "maggio:C+O-A&SS-FOH", "maggio:C+O-A-FOH")
    names = presets or ("maggio:C", "maggio", *adaptive)
    output = Output("maggio-growth", ("tracks", "histograms"), out, overwrite)
    return _on_clips(rendered_claims.growth, names, synthetic.growing, seeds, clips, output)


@app.command(name="zhao-figure2")
def zhao_figure2(
    *presets: str,
    seeds: Seeds = 5,
    clips: Clips = 3,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Zhao and Pei, figure 2: a target that turns around.

    Parameters
    ----------
    presets
        Trackers; zhao_pei:fixed, whose model stays, and zhao_pei if none is named.
    """
    from motes.evaluation import synthetic
    from motes.evaluation.papers import zhao_pei_figure2

    names = presets or ("zhao_pei:fixed", "zhao_pei")
    output = Output("zhao-figure2", ("",), out, overwrite, plot=True)
    return _on_clips(zhao_pei_figure2.figure2, names, synthetic.rolling, seeds, clips, output)


@app.command(name="zhao-figure9")
def zhao_figure9(
    sequence: Path,
    /,
    *,
    first_pixel: FirstPixel = None,
    detector: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="Who finds objects, as for motes watch; by default the sequence's det/det.txt, or "
            "what moves before its background.",
        ),
    ] = None,
    preset: Annotated[
        str, Parameter(group=RUN, help="The particle filter that follows each object.")
    ] = "zhao_pei",
    seed: Annotated[int, Parameter(group=RUN, help="Of the random numbers.")] = 0,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Zhao and Pei, figure 9: objects detected over objects present.

    Parameters
    ----------
    sequence
        A folder with frames and truth as for motes evaluate, with many objects or with one.
    """
    output = Output("zhao-figure9", ("",), out, overwrite, plot=True)

    from motes.evaluation.datasets.mot import has_mot_sequences, load_mot_dataset
    from motes.evaluation.papers import zhao_pei_figure9
    from motes.mot.pipeline_config import named_detector

    finder = None if detector is None else named_detector(detector)
    if has_mot_sequences(sequence):
        crowds, problems = load_mot_dataset(sequence)
        _refuse_none(sequence, crowds, problems)
        announce_compiling()
    else:
        films, problems = _films(sequence, first_pixel)
        crowds = [zhao_pei_figure9.as_mot_sequence(film) for film in films]
    if len(crowds) > 1:
        raise SourceError(f"{sequence} has {len(crowds)} sequences; give the folder of one.")
    return show(zhao_pei_figure9.figure9(crowds[0], finder, preset, seed), output, problems)


@app.command
def occlusions(
    *,
    hidden: Annotated[
        list[int] | None,
        Parameter(
            negative=(), help="Frames a target is hidden, again for each; else 5, 15, 30, 45, 60."
        ),
    ] = None,
    objects: Annotated[
        list[int] | None,
        Parameter(negative=(), help="Objects at once, again for each; else 2, 10, 50."),
    ] = None,
    least: Annotated[int, Parameter(group=RUN, help="Occlusions of each kind.")] = 10,
    out: Out = None,
    overwrite: Overwrite = False,
) -> int:
    """Zhao and Pei, section 3: identities through full occlusions."""
    check_counts(least=least)
    lengths, counts = hidden or [5, 15, 30, 45, 60], objects or [2, 10, 50]
    if min(lengths) < 5:
        raise ConfigError(f"--hidden is {min(lengths)}; give 5 or more.")
    for count in counts:
        if count != 2 and (count < 10 or count % 10):
            raise ConfigError(f"--objects is {count}; give 2 or a multiple of 10.")
    output = Output("occlusions", ("lengths", "short"), out, overwrite)

    from motes.evaluation.papers import occlusions as experiment

    announce_compiling()
    return show(experiment.occlusions(lengths, counts, least), output)


def _region_of(source: str | None, region: str | None) -> Sequence[float] | None:
    if source is None and region is not None:
        raise ConfigError("--region is in a picture or film; name it, or omit --region.")
    if source is not None and region is None:
        raise ConfigError(f"Where is the target in {source}? Give --region x,y,width,height.")
    return None if region is None else numbers_of("--region", region, "x,y,width,height")


def _on_clips(
    run: Callable[[Sequence[str], Sequence[Clip], int], Experiment],
    presets: Sequence[str],
    clip: Callable[..., Clip],
    seeds: int,
    clips: int,
    output: Output,
) -> int:
    """Do an experiment on rendered clips, one for each scenery."""
    check_counts(seeds=seeds, clips=clips)
    announce_compiling()
    return show(run(presets, [clip(seed=seed) for seed in range(clips)], seeds), output)


def _films(dataset: Path, first_pixel: Sequence[str] | None) -> tuple[list[Film], list[Problem]]:
    from motes.evaluation.datasets.sot import load_dataset

    films, problems = load_dataset(dataset, first_pixels(first_pixel or []))
    _refuse_none(dataset, films, problems)
    announce_compiling()
    return films, problems


def _refuse_none(dataset: Path, usable: Sequence[object], problems: Sequence[Problem]) -> None:
    if not usable:
        why = "; ".join(f"{problem.where}: {problem.what}" for problem in problems)
        raise SourceError(f"No sequence of {dataset} can be used. {why}")
