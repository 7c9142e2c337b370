"""The experiments of films cut in two pictures: their scores, and one who walks through."""

from pathlib import Path

import numpy as np
import pytest

from crowds import rows, write_crowd
from motes import Box, Detection
from motes.synthetic import Clip, Target
from motes_lab.datasets.mot import MotSequence, load_mot_dataset
from motes_lab.papers import cut_films, handover, known_person, rooms_on_film
from motes_lab.papers.cut_films import Entry, Found, Moment, entries, moments_of, part
from motes_lab.papers.handover import score
from motes_lab.papers.rooms_on_film import Passage, passages_of, until_known

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


def test_a_share_has_its_interval_and_none_of_nothing() -> None:
    share = handover._share(5, 10)
    assert (share.text, share.value) == ("50% (24% to 76%)", 0.5)
    assert share.more == pytest.approx({"lower end": 0.2366, "upper end": 0.7634}, abs=1e-4)
    assert handover._share(0, 0).value is None


@pytest.fixture(name="moments", scope="module")
def _moments() -> list[Moment]:
    """Return the frames in which one walks to the right through a picture of 400x120."""
    x = 6.0 * (np.arange(65) - 5)
    states = np.stack(np.broadcast_arrays(x, 60.0, 17.0, 12.0, 0.0), axis=1)
    moments = []
    for frame, (truth,) in Clip((400, 120), (Target(states),), seed=6):
        boxes = {1: truth.ellipse.box} if truth.visible > 0 else {}
        moments.append(Moment(frame, boxes, [Detection(box, 1.0) for box in boxes.values()]))
    return moments


@pytest.fixture
def film(moments: list[Moment], monkeypatch: pytest.MonkeyPatch) -> MotSequence:
    """Return a sequence that has these frames."""
    for module in (handover, known_person, rooms_on_film):
        monkeypatch.setattr(module, "moments_of", lambda _: moments)
    return MotSequence("walk", "", len(moments), 25, rows(), None)


@pytest.mark.slow
def test_samples_are_there_before_a_birth(film: MotSequence) -> None:
    *_, result = handover.overlapping([film])
    table = result.tables[""]
    values = {row[0].text: [cell.value or 0.0 for cell in row[1:5]] for row in table.rows}
    assert {name: each[0] for name, each in values.items()} == dict.fromkeys(values, 1)
    assert values["births alone"][2] == cut_films.WINDOW
    assert values["samples"][2] < values["names"][2]
    assert values["samples"][3] > values["names"][3]


@pytest.mark.slow
def test_a_known_person_is_found_sooner_with_samples(film: MotSequence) -> None:
    *_, result = known_person.known_person([film])
    _, alone, given = ([cell.value or 0.0 for cell in row[1:3]] for row in result.tables[""].rows)
    assert alone[0] == given[0] == 1
    assert given[1] < alone[1]


@pytest.mark.slow
def test_an_identity_passes_with_the_link_alone(film: MotSequence) -> None:
    *_, result = rooms_on_film.rooms_on_film([film])
    cells = {row[0].text: [cell.text for cell in row[1:3]] for row in result.tables[""].rows}
    assert cells["with handover"] == ["1", "1"]
    assert cells["without"] == ["1", "0"]


def test_moments_have_the_truth_and_the_detections(tmp_path: Path) -> None:
    (crowd,), _ = load_mot_dataset(write_crowd(tmp_path / "film", shift=2))
    moments = moments_of(crowd)
    assert len(moments) == 12
    assert moments[2].truth == {1: Box(65, 29, 20, 40), 2: Box(105, 29, 20, 40)}
    assert moments[2].detections == [Detection(Box(x + 2, 29, 20, 40), 0.9) for x in (65, 105)]
    assert moments[2].frame.time == 2 / 25


APART = range(45), range(55, 100)


def test_a_passage_is_from_the_last_frame_here_to_the_first_there() -> None:
    truths = [{3: Box(x, 0, 8, 20)} for x in (20, 38, 43, 46, 50, 60, 70)]
    assert passages_of(truths, APART) == [(3, 0, 2, 4)]  # a quarter of 8 pixels is enough
    assert passages_of(truths[::-1], APART) == [(3, 1, 2, 4)]
    assert passages_of(truths[:4], APART) == []


def test_one_who_is_in_both_pictures_has_not_passed() -> None:
    wide = [{1: Box(x, 0, 40, 20)} for x in (0, 30, 60)]
    assert passages_of(wide, APART) == [(1, 0, 0, 2)]


def test_an_identity_is_known_if_the_last_one_here_is_the_first_there() -> None:
    def answers(*after: int) -> list[dict[tuple[int, int], Found]]:
        before = [{(0, 0): Found(name, 1.0)} for name in (4, 4, 5)]
        return [*before, {}, {}, {}, *({(0, 1): Found(name, 1.0)} for name in after)]

    passage = Passage(0, 0, 3, 5)
    assert until_known(answers(5, 6), passage) == 1
    assert until_known(answers(6, 5), passage) is None
    assert until_known(answers(), passage) is None
