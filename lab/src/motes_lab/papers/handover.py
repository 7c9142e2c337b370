"""Nummiaro et al., section VII: what a tracker gains from the samples that another one gives it.

A film is cut in two pictures that overlap, as of two cameras. People who walk from one into the
other are known in the first. The second camera has them after some frames: as births, as births
that get the names of the first camera's objects, or from that camera's samples.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
from cyclopts import Parameter

from motes import ConfigError
from motes_fleet.cameras.rig_config import Camera, Overlap, Rig
from motes_lab.datasets.mot import MotSequence
from motes_lab.experiment import Experiment, Result, ResultOptions
from motes_lab.inputs import FLAG, crowds_of
from motes_lab.metrics.statistics import over, wilson_interval
from motes_lab.papers.cut_films import (
    KNOWN,
    NAMES,
    WINDOW,
    Entry,
    Found,
    entries,
    moments_of,
    overlap_of,
    run,
    views_of,
)
from motes_lab.papers.known_person import known_person
from motes_lab.papers.rooms_on_film import rooms_on_film
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number

LATER = 50
"""Frames after which the identity is read again; the first `WINDOW` after an entry are measured."""


def handover(
    dataset: Path,
    /,
    *,
    known: Annotated[
        bool, FLAG, Parameter(help="Both cameras wait for one person whose histogram is known.")
    ] = False,
    apart: Annotated[
        bool, FLAG, Parameter(help="The pictures do not overlap, as of two rooms.")
    ] = False,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Nummiaro et al., section VII: cameras hand over.

    Parameters
    ----------
    dataset
        A folder of sequences with people, as for motes-lab evaluate. Each film is cut in two
        pictures.
    """
    if apart and known:
        raise ConfigError("--apart goes without --known; give one of them.")
    crowds, problems = crowds_of(dataset)
    run = known_person if known else rooms_on_film if apart else overlapping
    return results.show("handover", run(crowds), problems)


def rigs(views: Sequence[range]) -> dict[str, tuple[Rig, bool]]:
    """Return the rigs that are compared, and whether their cameras give each other samples."""
    cameras = tuple(Camera(name, "") for name in NAMES)
    given, learned = overlap_of(views), Overlap(NAMES)
    return {
        "births alone": (Rig(cameras), False),
        "names": (Rig(cameras, overlap=(given,)), False),
        "samples": (Rig(cameras, overlap=(given,)), True),
        "samples, ground learned": (Rig(cameras, overlap=(learned,)), True),
    }


class Score(NamedTuple):
    """What became of an entry."""

    any: int
    same: int
    """Frames until the second camera has the person, and until with the first one's identity;
    `WINDOW` if not within that time."""
    overlap: float
    """Mean overlap with the truth over `WINDOW` frames; 0 in frames without the person."""
    later: bool
    """Whether the identity is the first camera's in the last of `LATER` frames."""


def score(answers: Sequence[Mapping[tuple[int, int], Found]], entry: Entry) -> Score | None:
    """Return what became of an entry; None if the first camera did not have the person."""
    person, view, first = entry
    before = [
        answers[index][person, 1 - view].identity
        for index in range(first - KNOWN, first)
        if (person, 1 - view) in answers[index]
    ]
    if not before:
        return None
    after = [answers[first + n].get((person, view)) for n in range(WINDOW)]
    has = [n for n, each in enumerate(after) if each is not None]
    right = [n for n in has if (each := after[n]) is not None and each.identity == before[-1]]
    overlap = float(np.mean([0.0 if each is None else each.overlap for each in after]))
    names = [
        answers[index][person, view].identity
        for index in range(first, min(first + LATER, len(answers)))
        if (person, view) in answers[index]
    ]
    later = bool(names) and names[-1] == before[-1]
    return Score(min([*has, WINDOW]), min([*right, WINDOW]), overlap, later)


def overlapping(films: Sequence[MotSequence]) -> Experiment:
    """Yield what the second camera gains from samples, over all entries of all films."""
    scores: dict[str, list[Score]] = {}
    for done, film in enumerate(films, start=1):
        moments = moments_of(film)
        views = views_of(moments[0].frame.width)
        entered = entries([moment.truth for moment in moments], views)
        for name, (rig, exchange) in rigs(views).items():
            answers = run(moments, rig, exchange)
            found = (score(answers, entry) for entry in entered)
            scores.setdefault(name, []).extend(each for each in found if each is not None)
        yield Result({"": _table(scores)}, progress=f"{done} of {len(films)} films")


def _table(scores: Mapping[str, Sequence[Score]]) -> Table:
    rows: list[Row] = []
    for name, results in scores.items():
        kept = [sum(each.same < WINDOW for each in results), sum(each.later for each in results)]
        rows.append(
            (
                Cell(name),
                number(len(results), 0),
                number(over(each.any for each in results), 1),
                number(over(each.same for each in results), 1),
                number(over(each.overlap for each in results), 3),
                *(_share(count, len(results)) for count in kept),
            )
        )
    head = (
        "cameras exchange", "entries", "frames until there", "frames until known",
        f"IoU over {WINDOW} frames", f"known after {WINDOW} frames", f"after {LATER} frames",
    )  # fmt: skip
    note = (
        f"Frames from when a quarter of the person is in the second picture; {WINDOW} if it is "
        f"not there by then. Known: with the identity of the first camera; with 95 % intervals."
    )
    return Table("Handing over between overlapping cameras", head, rows, note=note)


def _share(count: int, total: int) -> Cell:
    """Return a share with its interval."""
    if not total:
        return Cell(NO_VALUE)
    share, (low, high) = count / total, wilson_interval(count, total)
    text = f"{share:.0%} ({low:.0%} to {high:.0%})"
    return Cell(text, share, {"lower end": low, "upper end": high})
