"""Nummiaro et al., section VII, on film: identities of people who pass between two pictures.

A film is cut in two pictures with a strip between them that neither camera sees, as of two rooms.
The door of each is its border at the strip.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from motes import Box, Place
from motes_fleet.cameras.rig_config import Camera, CameraLink, Rig
from motes_lab.datasets.mot import MotSequence
from motes_lab.experiment import Experiment, Result
from motes_lab.metrics.statistics import over, wilson_interval
from motes_lab.papers.cut_films import NAMES, Found, moments_of, part, run, views_of
from motes_lab.papers.known_person import BORDER
from motes_lab.report.tables import Cell, Row, Table, interval, number, percent

UNSEEN = 0.1
"""Width of the strip, as a share of the film's."""
SECONDS = 0.0, 5.0
"""Least and most time of a passage."""


class Way(NamedTuple):
    """Whether the doors of two cameras are linked, and whether people are expected there."""

    linked: bool
    expects: bool


WAYS = {
    "with handover": Way(True, True),
    "names alone": Way(True, False),
    "without": Way(False, False),
}


class Passage(NamedTuple):
    """A person, the picture that is left, the last frame in it, the first in the other one."""

    person: int
    view: int
    out: int
    into: int


def passages_of(truths: Sequence[Mapping[int, Box]], views: Sequence[range]) -> list[Passage]:
    """Return the passages of people who leave one picture for the other."""
    last: dict[int, tuple[int, int]] = {}
    passages = []
    for index, boxes in enumerate(truths):
        for person, box in boxes.items():
            here = [view for view in range(2) if part(box, views[view])]
            if len(here) != 1:
                continue
            view, out = last.get(person, (here[0], index))
            if view != here[0]:
                passages.append(Passage(person, view, out, index))
            last[person] = here[0], index
    return passages


def rig(views: Sequence[range], height: int, linked: bool) -> Rig:
    """Return two cameras, whose doors are linked or not."""
    cameras = []
    for name, columns in zip(NAMES, views, strict=True):
        width = BORDER * len(columns)
        left = len(columns) - width if name == NAMES[0] else 0.0
        cameras.append(Camera(name, "", place=(Place("door", (left, 0.0, width, float(height))),)))
    passage = CameraLink(("left/door", "right/door"), SECONDS)
    return Rig(tuple(cameras), (passage,) * linked)


def rooms_on_film(films: Sequence[MotSequence]) -> Experiment:
    """Yield how often an identity is kept through the unseen strip, with handover and without."""
    runs: dict[str, list[list[int | None]]] = {name: [] for name in WAYS}
    for done, film in enumerate(films, start=1):
        moments = moments_of(film)
        frame = moments[0].frame
        views = views_of(frame.width, -UNSEEN)
        passages = passages_of([moment.truth for moment in moments], views)
        for name, way in WAYS.items():
            cameras = rig(views, frame.height, way.linked)
            answers = run(moments, cameras, way.expects, -UNSEEN)
            runs[name].append([until_known(answers, passage) for passage in passages])
        yield Result({"": compared(runs)}, progress=f"{done} of {len(films)} films")


def until_known(answers: Sequence[Mapping[tuple[int, int], Found]], passage: Passage) -> int | None:
    """Return how many frames it takes until the identity is known; None if it is not kept.

    It is kept if the last identity before the passage equals the first one after it.
    """
    person, view, out, into = passage
    before = [found for found in _of(person, view, answers[: out + 1]) if found is not None]
    after = _of(person, 1 - view, answers[into:])
    frames = next((i for i, found in enumerate(after) if found is not None), None)
    kept = frames is not None and before and before[-1] == after[frames]
    return frames if kept else None


def _of(
    person: int, view: int, answers: Sequence[Mapping[tuple[int, int], Found]]
) -> list[int | None]:
    """Return the identities of a person in a picture, by frame; None where there is none."""
    found = (answer.get((person, view)) for answer in answers)
    return [None if each is None else each.identity for each in found]


def compared(runs: Mapping[str, Sequence[Sequence[int | None]]]) -> Table:
    """Return how often the identity was kept, of passages by film, and how soon it was known."""
    rows: list[Row] = []
    for name, films in runs.items():
        waits = [frames for film in films for frames in film if frames is not None]
        total, good = sum(map(len, films)), len(waits)
        between = interval(*wilson_interval(good, total), ".1%")
        shares = (np.mean([each is not None for each in film]) for film in films if film)
        rows.append(
            (
                *(Cell(name), number(total, 0), number(good, 0)),
                *(percent(over(map(float, shares))), between, number(over(waits), 1)),
            )
        )
    head = (
        *("cameras", "passages", "identity kept", "share over runs", "95 % interval"),
        "frames until known",
    )
    note = (
        "Wilson's interval over all passages. Frames from when a quarter of the person is in "
        "the other room's picture, where the identity is kept."
    )
    return Table("From room to room", head, rows, note=note)
