"""Nummiaro et al., section VII, on film: identities of people who pass between two pictures.

A film is cut in two pictures with a strip between them that neither camera sees, as of two rooms.
The door of each is its border at the strip.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motes.core.geometry import Box
from motes.core.types import Floats
from motes.mot.cameras.rig_config import Camera, CameraLink, Rig
from motes.sot.places import Place
from motes_lab.papers.handover import NAMES, Film, part, run, views_of
from motes_lab.papers.known_person import BORDER
from motes_lab.papers.result import Experiment, Result
from motes_lab.papers.two_rooms import WAYS, compared, kept

UNSEEN = 0.1
"""Width of the strip, as a share of the film's."""
SECONDS = 0.0, 5.0
"""Least and most time of a passage."""

Passage = tuple[int, int, int, int]
"""Person, picture, last frame in it, first frame in the other one, as of `two_rooms`."""


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
                passages.append((person, view, out, index))
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


def rooms_on_film(films: Sequence[Film], seeds: int) -> Experiment:
    """Yield how often an identity is kept through the unseen strip, with handover and without."""
    runs: dict[str, list[list[bool]]] = {name: [] for name in WAYS}
    waits: dict[str, list[int]] = {name: [] for name in WAYS}
    for done, film in enumerate(films, start=1):
        moments = list(film.moments())
        frame = moments[0].frame
        views = views_of(frame.width, -UNSEEN)
        passages = passages_of([moment.truth for moment in moments], views)
        people = 1 + max((person for person, *_ in passages), default=0)
        for seed in range(seeds):
            for name, way in WAYS.items():
                cameras = rig(views, frame.height, way.linked)
                answers = run(moments, cameras, way.expects, seed, -UNSEEN)
                names: Floats = np.full((2, len(moments), people), np.nan)
                for index, answer in enumerate(answers):
                    for (person, view), found in answer.items():
                        if person < people:
                            names[view, index, person] = found.identity
                same = kept(names, passages)
                runs[name].append(same)
                waits[name] += [
                    int(np.isfinite(names[1 - room, into:, person]).argmax())
                    for (person, room, _, into), known in zip(passages, same, strict=True)
                    if known
                ]
        yield Result({"": compared(runs, waits)}, progress=f"{done} of {len(films)} films")
