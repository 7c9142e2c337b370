"""The experiments of overlapping cameras: their scores, and one short film."""

from __future__ import annotations

import numpy as np
import pytest

from motes.core.geometry import Box
from motes_lab.papers import handover, known_person
from motes_lab.papers.handover import Entry, Found, entries, part, score

VIEWS = range(60), range(40, 100)


def test_an_entry_is_a_quarter_of_somebody_known() -> None:
    truths = [{1: Box(x, 0, 8, 20)} for x in range(10, 80)]
    (entry,) = entries(truths, VIEWS)
    assert entry == Entry(1, 1, 40 - 6 - 10)
    assert part(truths[entry.frame][1], VIEWS[1]) == (0, 0, 2, 20)
    assert entries(truths[22:], VIEWS) == []  # was not in the other picture for long enough


def test_scores_count_frames_until_there_and_until_known() -> None:
    before = [{(1, 0): Found(7, 0.9)}] * 10
    after = [{}, {}, {(1, 1): Found(8, 0.5)}, *[{(1, 1): Found(7, 1.0)}] * 30]
    found = score([*before, *after], Entry(1, 1, 10))
    assert found is not None
    assert (found.any, found.same, found.later) == (2, 3, True)
    assert found.overlap == pytest.approx(0.75)
    assert score([*({} for _ in range(10)), *after], Entry(1, 1, 10)) is None


@pytest.mark.slow
def test_samples_are_there_before_a_birth() -> None:
    film = handover.rendered_film(6, frames=150, people=1)
    moments = list(film.moments())
    views = handover.views_of(moments[0].frame.width)
    (entry,) = entries([moment.truth for moment in moments], views)
    rigs = handover.rigs(views)
    found = {
        name: score(handover.run(moments, *rigs[name], 0), entry) for name in ("names", "samples")
    }
    assert found["samples"] is not None
    assert found["names"] is not None
    assert found["samples"].same < found["names"].same
    assert found["samples"].overlap > found["names"].overlap


@pytest.mark.slow
def test_a_known_person_is_found_sooner_with_samples() -> None:
    film = handover.rendered_film(6, frames=150, people=1)
    moments = list(film.moments())
    views = handover.views_of(moments[0].frame.width)
    (entry,) = entries([moment.truth for moment in moments], views)
    alone = known_person.wait(moments, entry, doors=True, exchange=False, seed=0)
    given = known_person.wait(moments, entry, doors=True, exchange=True, seed=0)
    assert alone is not None
    assert given is not None
    assert np.array(given)[0] < np.array(alone)[0]
