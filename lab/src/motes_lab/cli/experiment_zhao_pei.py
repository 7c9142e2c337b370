"""The experiments of Zhao and Pei."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from motes.cli.input_checks import error_context, numbers_of, read_text
from motes.cli.options import HYPHEN, RUN, ObjectPreset, Seed
from motes.core.errors import SourceError
from motes_lab.cli.dataset_options import FirstPixel
from motes_lab.cli.experiment_inputs import ClipRuns, crowds_of, films_of
from motes_lab.cli.experiment_output import ResultOptions, show
from motes_lab.cli.experiment_scenes import Full, scene_factory

FIGURE9_FRAMES = 300
"""Number of frames of figure 9 without --full."""

if TYPE_CHECKING:
    from motes.core.detection import Detector


def zhao_figure2(
    *presets: str, runs: ClipRuns = ClipRuns(), results: ResultOptions = ResultOptions()
) -> int:
    """Zhao and Pei, figure 2: a target that turns around.

    Parameters
    ----------
    presets
        Presets; by default zhao_pei:fixed, with a fixed model, and zhao_pei.
    """
    from motes import synthetic
    from motes_lab.papers import zhao_pei_figure2

    names = presets or ("zhao_pei:fixed", "zhao_pei")
    output = results.output("zhao-figure2", plot=True)
    return runs.show(zhao_pei_figure2.figure2, names, synthetic.rolling, output)


def zhao_figure9(
    sequence: Path,
    /,
    *,
    first_pixel: FirstPixel = None,
    detector: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="Detector, as for motes watch. The default is the sequence's det/det.txt, or if "
            "it is missing a background.",
        ),
    ] = None,
    like: Annotated[
        str | None,
        HYPHEN,
        Parameter(
            group=RUN,
            help="Follow all that look like the target in this box of the first frame, as for "
            "motes watch: x,y,width,height.",
        ),
    ] = None,
    preset: ObjectPreset = "zhao_pei",
    seed: Seed = 0,
    full: Full = False,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Zhao and Pei, figure 9: objects detected over objects present.

    Reads the first 300 frames; with --full, all.

    Parameters
    ----------
    sequence
        A folder with frames and ground truth as for motes-lab evaluate, of many objects or of one.
    """
    output = results.output("zhao-figure9", "", "all", plot=True)

    from motes.core.seed import checked_seed
    from motes.mot.detection.lookalike import LookalikeConfig
    from motes.mot.pipeline_config import lookalike_detector
    from motes_lab.datasets.mot import has_mot_sequences
    from motes_lab.papers import zhao_pei_figure9

    checked_seed(seed)
    finder: str | Callable[[], Detector] | None = detector
    if like is not None:
        box = numbers_of("--like", like, "x,y,width,height")
        chosen = LookalikeConfig(tuple(box))  # type: ignore[arg-type]
        finder = partial(lookalike_detector, chosen, detector)
    scene = scene_factory(finder, preset, lookalikes=like is not None)
    if has_mot_sequences(sequence):
        crowds, problems = crowds_of(sequence)
    else:
        films, problems = films_of(sequence, first_pixel)
        crowds = [zhao_pei_figure9.as_mot_sequence(film) for film in films]
    if len(crowds) > 1:
        raise SourceError(f"{sequence} has {len(crowds)} sequences; give the folder of one.")
    (crowd,) = crowds
    found_by = " ".join(text for text in (like and f"--like {like}", detector) if text)
    if not found_by:
        found_by = "background" if crowd.detections is None else "det.txt"
        scene = scene_factory(lambda: zhao_pei_figure9.default_detector(crowd), preset)
    frames = crowd.frames if full else min(crowd.frames, FIGURE9_FRAMES)
    expected = zhao_pei_figure9.expected(crowd, scene, frames)
    full = full or frames == crowd.frames
    steps = zhao_pei_figure9.figure9(crowd, scene, found_by, seed, frames)
    return show(steps, output, problems, expected, full=full)


def zhao_figure10(
    truth: Path,
    films: Path,
    /,
    *,
    detector: Annotated[str, Parameter(group=RUN, help="Detector, as for motes watch.")] = "mog2",
    preset: ObjectPreset = "nummiaro:adaptive",
    seed: Seed = 0,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Zhao and Pei, figure 10: objects that cross lines, counted.

    Parameters
    ----------
    truth
        A TOML file of true crossings: [[clip]] with file, and [[clip.line]] with points, left and
        right, the frames of the crossings to each side.
    films
        The folder of the films.
    """
    output = results.output("zhao-figure10")

    from motes.mot.pipeline_config import named_detector
    from motes_lab.datasets.crossings import parse_crossings
    from motes_lab.papers import zhao_pei_figure10

    make = partial(named_detector, detector)
    make()  # a wrong name is refused first
    text = read_text(truth)
    with error_context(truth):
        clips = parse_crossings(text, str(truth))
    return show(zhao_pei_figure10.figure10(clips, films, make, preset, seed), output)


def zhao_team(
    truth: Path,
    pictures: Path,
    /,
    *,
    preset: ObjectPreset = "nummiaro:adaptive",
    seed: Seed = 0,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Zhao and Pei, figure 8: a team, found by one of its players.

    Parameters
    ----------
    truth
        A TOML file of boxes: sequence, start (a frame), like (the chosen one's box there), and
        [[frame]] with index and boxes.
    pictures
        The film or the folder of its pictures.
    """
    output = results.output("zhao-team")

    from motes_lab.datasets.team import parse_team
    from motes_lab.papers import zhao_pei_team

    text = read_text(truth)
    with error_context(truth):
        marked = parse_team(text, str(truth))
    return show(zhao_pei_team.team(marked, pictures, preset, seed), output)


def zhao_detections(
    sequences: Path,
    /,
    *,
    detector: Annotated[str, Parameter(group=RUN, help="Detector, as for motes watch.")] = "mog2",
    results: ResultOptions = ResultOptions(),
) -> int:
    """Zhao and Pei, section 3.1: precision and recall of a detector.

    Parameters
    ----------
    sequences
        A folder of sequences of many objects, as for motes-lab evaluate.
    """
    output = results.output("zhao-detections")

    from motes.mot.pipeline_config import named_detector
    from motes_lab.papers import zhao_pei_detections

    named_detector(detector)
    crowds, problems = crowds_of(sequences)
    steps = zhao_pei_detections.detections(crowds, lambda: named_detector(detector))
    return show(steps, output, problems)
