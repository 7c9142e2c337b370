"""Trackers of many objects, runs of them, and what is made of what they say."""

import math
import re
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from arena import at_home
from crowds import TRACKERS, rows, write_crowd
from in_process import InProcess
from motes import Box, ConfigError, Detection, FormatError, Frame, MissingDependencyError
from motes_lab.adapters.mot import AssociationAdapter, FoundObject, SequenceInfo
from motes_lab.adapters.registry import mot_tracker_spec, resolve, with_detector
from motes_lab.datasets.mot import MotSequence, load_mot_dataset
from motes_lab.datasets.mot_rows import MotRows
from motes_lab.mot_scores import MotEvaluation, MotOutcome
from motes_lab.protocols.mot import MotPass, Tracks, load_tracks, save_tracks
from motes_lab.protocols.sot import Start
from motes_lab.report import mot_sections
from motes_lab.runner import Pass, plan, run, unfinished

INFO = SequenceInfo("film", 12, 25, 160, 120)


@pytest.fixture
def home(tmp_path: Path) -> Iterator[Path]:
    """Return the current folder: a sequence, and some trackers."""
    write_crowd(tmp_path / "data" / "film", shift=1)
    (tmp_path / "many.py").write_text(TRACKERS)
    with at_home(tmp_path, "many"):
        yield tmp_path


@pytest.fixture
def crowd(home: Path) -> MotSequence:
    return load_mot_dataset(home / "data")[0][0]


def frame(index: int = 0) -> Frame:
    return Frame(index, index / 25, np.zeros((120, 160, 3), np.uint8))


def followed(crowd: MotSequence, name: str, detector: str = "", seed: int = 0) -> Tracks:
    """Return what a tracker says of a sequence, in this process."""
    entries = [mot_tracker_spec(name)]
    if detector:
        entries = with_detector(entries, detector)
    running = MotPass(lambda: entries[0].begin(seed), crowd)
    for index in range(crowd.frames):
        running.feed(frame(index))
    return running.trace


@pytest.mark.slow
@pytest.mark.parametrize(("name", "late"), [("trackers:sort", 2), ("trackers:bytetrack", 1)])
def test_peers_follow_two_that_walk(crowd: MotSequence, name: str, late: int) -> None:
    pytest.importorskip("trackers")
    for _ in range(2):  # identities begin anew
        found = followed(crowd, name).rows
        assert found.ids.tolist() == [1, 2] * (12 - late)
        assert found.frames[0] == 1 + late
        assert crowd.detections is not None
        np.testing.assert_allclose(found.boxes, crowd.detections.boxes[2 * late :])


def test_our_scenes_clock_goes_by_the_frame_rate(crowd: MotSequence) -> None:
    """Who is undetected is followed by colors for 0.12 s: two frames at 25 a second, none at 5."""
    assert crowd.detections is not None
    gap = crowd.detections.where(~np.isin(crowd.detections.frames, [9]))
    fast, slow = (
        followed(replace(crowd, rate=rate, detections=gap), "motes:scene").rows for rate in (25, 5)
    )
    assert 9 in fast.frames
    assert 9 not in slow.frames


@pytest.mark.parametrize("name", ["motes:scene", "trackers:sort"])
def test_some_need_detections(home: Path, name: str) -> None:
    if name.startswith("trackers"):
        pytest.importorskip("trackers")
    (home / "data" / "film" / "det" / "det.txt").unlink()
    crowd = load_mot_dataset(home / "data")[0][0]
    with pytest.raises(ConfigError, match=r"no det/det\.txt; name a --detector"):
        followed(crowd, name)
    assert len(followed(crowd, "many:Blind").rows.ids) == 12


def test_without_trackers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "trackers", None)
    with pytest.raises(MissingDependencyError, match=r"motes-lab\[peers\]"):
        mot_tracker_spec("trackers:sort")


def test_peers_that_measure_the_camera_get_frames_in_bgr(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = []

    class Seeing:
        def __init__(self, frame_rate: float) -> None:
            pass

        def reset(self) -> None:
            pass

        def update(self, given: SimpleNamespace, picture: NDArray[np.uint8]) -> SimpleNamespace:
            seen.append(picture)
            ids = np.zeros(len(given.xyxy), np.int64)
            return SimpleNamespace(xyxy=given.xyxy, confidence=given.confidence, tracker_id=ids)

    monkeypatch.setitem(sys.modules, "trackers", SimpleNamespace(BoTSORTTracker=Seeing))
    monkeypatch.setitem(sys.modules, "supervision", SimpleNamespace(Detections=SimpleNamespace))
    adapter = AssociationAdapter("trackers:botsort")
    adapter.start(SequenceInfo("film", 1, 25.0, 64, 48))
    pixels = np.zeros((48, 64, 3), np.uint8)
    pixels[..., 0] = 200
    answer = adapter.update(Frame(0, 0.0, pixels), [Detection(Box(5, 6, 20, 30), 0.5)])
    assert answer.found == [FoundObject(1, Box(5, 6, 20, 30), 0.5)]
    assert seen[0][0, 0].tolist() == [0, 0, 200]


def test_a_detector_of_ones_own(crowd: MotSequence) -> None:
    found = followed(crowd, "many:Echo", "many:Corner").rows
    assert found.boxes.tolist() == [[index + 1, 3, 3, 4] for index in range(12)]
    entry = with_detector([mot_tracker_spec("many:Seeded")], "many:Corner")[0]
    assert entry.begin(3).update is not None
    assert followed(crowd, "many:Seeded", "many:Corner", seed=5).rows.boxes[0, 0] == 6


def test_results_are_taken_as_they_are(crowd: MotSequence, home: Path) -> None:
    (home / "r").mkdir()
    (home / "r" / "film.txt").write_text("3,7,0.1,2.7,3,0,-5,-1,-1,-1\n1,9,1,2,3,4,1,-1,-1,-1\n")
    found = followed(crowd, "results=r")
    save_tracks(home / "a.csv", found)
    read = load_tracks(home / "a.csv").rows
    assert read.boxes.tolist() == [[1, 2, 3, 4], [0.1, 2.7, 3, 0]]
    assert (read.frames.tolist(), read.ids.tolist()) == ([1, 3], [9, 7])
    assert read.scores.tolist() == [1, -5]
    assert np.isnan(found.seconds).all()
    before = mot_tracker_spec("results=r").configuration
    (home / "r" / "film.txt").write_text("1,9,1,2,3,5,1\n")
    assert mot_tracker_spec("results=r").configuration != before


def test_bad_results(crowd: MotSequence, home: Path) -> None:
    (home / "r").mkdir()
    (home / "r" / "other.txt").write_text("")
    with pytest.raises(FormatError, match=r"There is no file .*r/film\.txt"):
        followed(crowd, "results=r")
    (home / "r" / "film.txt").write_text("1,9\n")
    with pytest.raises(FormatError, match=r"r/film\.txt, line 1: 2 numbers"):
        followed(crowd, "results=r")


def say(crowd: MotSequence, value: Any) -> Any:
    mot_tracker_spec("many:Blind")
    sys.modules["many"].Blind.value = value
    contestant = mot_tracker_spec("many:Blind").begin(0)
    contestant.start(INFO)
    return contestant.update(frame(), [])


def test_what_a_callable_may_say(crowd: MotSequence) -> None:
    assert say(crowd, []).found == []
    said = say(crowd, iter([(np.int64(3), np.array([1, 2, 3, 4.5]), np.float32(0.5))]))
    assert said.found == [FoundObject(3, Box(1, 2, 3, 4.5), 0.5)]


@pytest.mark.parametrize(
    "value",
    [
        None,
        3,
        [3],
        [(1, (1, 2, 3, 4))],
        [(1.5, (1, 2, 3, 4), 1)],
        [("1", (1, 2, 3, 4), 1)],
        [(1, (1, 2, 3), 1)],
        [(1, (1, 2, 3, 0), 1)],
        [(1, (1, 2, 3, math.nan), 1)],
        [(1, (1, 2, 3, 4), math.inf)],
        [(1, (1, 2, 3, 4), math.nan)],
        [(1, (1e10, 2, 3, 4), 1)],
    ],
)
def test_what_a_callable_may_not_say(crowd: MotSequence, value: Any) -> None:
    with pytest.raises(ConfigError, match=r"update of many:Blind .*; it must return a list"):
        say(crowd, value)


def test_names(home: Path) -> None:
    entries, problems = resolve(
        ["many:Echo", "many:Seeded", "nummiaro", "trackers:sor", "no:Such", "results=no",
         "results=data"], mot_tracker_spec,
    )  # fmt: skip
    assert [(entry.name, entry.stochastic) for entry in entries] == [
        ("many:Echo", False),
        ("many:Seeded", True),
    ]
    found = [(problem.where, problem.what) for problem in problems]
    assert [where.removeprefix("tracker ") for where, _ in found] == [
        "nummiaro", "trackers:sor", "no:Such", "results=no", "results=data"
    ]  # fmt: skip
    for (_, what), expected in zip(
        found,
        [
            "no tracker of this name for many objects; known are motes:scene, trackers:so",
            "no tracker of this name for many objects; did you mean trackers:sort?",
            "nor a module no; known are",
            "no cannot be read: No such file or directory",
            "There is no text file in data; it has one for each sequence",
        ],
        strict=True,
    ):
        assert expected in what


def test_tracks_are_read_back(tmp_path: Path) -> None:
    given = Tracks(
        rows((1, 4, 1, 2, 3, 4), (3, 4, 1.25, 2, 3, 4), (3, 5, 1, 2, 3, 4)),
        np.array([0.1 + 0.2, math.nan, 1e-7]),
    )
    save_tracks(tmp_path / "new" / "a.csv", given)
    read = load_tracks(tmp_path / "new" / "a.csv")
    np.testing.assert_array_equal(read.seconds, given.seconds)
    np.testing.assert_array_equal(read.rows.boxes, given.rows.boxes)
    assert (tmp_path / "new" / "a.csv").read_text() == (
        "frame,objects,seconds\n0,1,0.30000000000000004\n1,0,\n2,2,1e-07\n"
    )


@pytest.mark.parametrize(
    ("csv", "txt", "error"),
    [
        (None, "", "a.csv cannot be read"),
        ("frame,objects,seconds\n0,0,0.1\n", None, r"a.txt cannot be read"),
        ("frame,x\n", "", "a.csv is not a track of an evaluation"),
        ("frame,objects,seconds\n0,0,x\n", "", "a.csv is not a track of an evaluation"),
        ("frame,objects,seconds\n0\n", "", "a.csv is not a track of an evaluation"),
        ("", "", "a.csv is not a track of an evaluation"),
        ("frame,objects,seconds\n0,0,0.1\n", "2,1,1,2,3,4,1\n", "line 1: there is no frame 2"),
    ],
)
def test_bad_tracks(tmp_path: Path, csv: str | None, txt: str | None, error: str) -> None:
    for name, text in (("a.csv", csv), ("a.txt", txt)):
        if text is not None:
            (tmp_path / name).write_text(text)
    with pytest.raises(FormatError, match=error):
        load_tracks(tmp_path / "a.csv")


def test_tracks_of_another_length_are_refused(tmp_path: Path) -> None:
    save_tracks(tmp_path / "a.csv", Tracks(rows(), np.zeros(2)))
    film = MotSequence("a", "nowhere", 3, 25.0, rows(), None)
    with pytest.raises(FormatError, match=r"a\.csv is for 2 frames, but the sequence has 3\."):
        MotOutcome.load(tmp_path / "a.csv", film)


@pytest.mark.slow
def test_a_run(home: Path, crowd: MotSequence) -> None:
    entries, _ = resolve(["many:Seeded", "many:Raises"], mot_tracker_spec)
    jobs, problems = plan(entries, [crowd], ["mot"], 2)
    assert problems == []
    assert [len(job.passes) for job in jobs] == [2, 1]
    errors: dict[Pass, str] = {}
    for step in run(InProcess(), jobs, home / "out", 60):
        errors |= step.errors or {}
    [(failed, why)] = errors.items()
    assert failed == Pass("many:Raises", "film", Start("mot", "", 0, None), 0)
    assert why == "At frame 6: ValueError: no more of this"
    assert unfinished(jobs[:1], home / "out") == []
    first, second = MotOutcome.of(jobs[0], home / "out", {})
    assert first.tally.motp == pytest.approx(19 / 21)  # one pixel of 20, as the detections are
    assert second.tally.motp == pytest.approx(18 / 22)
    [broken] = MotOutcome.of(jobs[1], home / "out", errors)
    assert (broken.trace, broken.error) == (None, why)
    assert set(broken.scores.values()) == {None}
    assert broken.seconds.shape == (0,)
    (home / "out" / "tracks" / "many%3ASeeded" / "film" / "mot-1.txt").write_text("x\n")
    _, damaged = MotOutcome.of(jobs[0], home / "out", {})
    assert damaged.trace is None
    assert re.search(r"line 1: 1 numbers.*Delete it and --resume\.", damaged.error)


def outcome(
    tracker: str, crowd: MotSequence, found: int | None, seed: int = 0, seconds: float = 0.002
) -> MotOutcome:
    """Return a pass that says the truth in its first frames only; None for one that failed."""
    item = Pass(tracker, crowd.name, Start("mot", "", 0, None), seed)
    if found is None:
        return MotOutcome(crowd, item, None, "It broke.")
    said = crowd.truth.where(crowd.truth.frames <= found)
    return MotOutcome(crowd, item, Tracks(said, np.full(crowd.frames, seconds)))


def film(name: str, frames: int) -> MotSequence:
    """Return a sequence with one object that stands still."""
    truth = rows(*((i, 1, 5, 6, 20, 30, 1, 1) for i in range(1, frames + 1)))
    return MotSequence(name, "nowhere", frames, 25, truth, None)


LONG, SHORT = film("long", 30), film("short", 10)
OUTCOMES = [
    outcome("good", LONG, 30),
    outcome("good", SHORT, 5),
    outcome("lucky", LONG, 15),
    outcome("lucky", SHORT, 10),
    outcome("lucky", LONG, 30, seed=1),
    outcome("lucky", SHORT, 0, seed=1),
    outcome("bad", LONG, 30),
    outcome("bad", SHORT, None),
]


def test_what_does_not_count_is_left_out() -> None:
    """A sign, and a static person that the tracker follows."""
    others = rows((1, 2, 90, 6, 20, 30, 0, 1), (1, 3, 50, 6, 20, 30, 1, 7))
    there = film("film", 1)
    columns = ("frames", "ids", "boxes", "scores", "classes", "visibilities")
    parts = [[getattr(part, name) for name in columns] for part in (there.truth, others)]
    whole = MotRows(*(np.concatenate(pair) for pair in zip(*parts, strict=True)))
    assert outcome("a", there, 1).scores["boxes"] == 1
    scores = outcome("a", replace(there, truth=whole), 1).scores
    assert (scores["boxes"], scores["false_positives"], scores["mota"]) == (1, 1, 0)


def test_sequences_are_combined_and_not_averaged() -> None:
    evaluation = MotEvaluation(OUTCOMES)
    assert evaluation.mean("good", "mot", "mota").mean == pytest.approx(35 / 40)
    assert evaluation.mean("good", "mot", "frames").mean == 40
    lucky = evaluation.mean("lucky", "mot", "mota")
    assert lucky.mean == pytest.approx((25 / 40 + 30 / 40) / 2)
    assert lucky.deviation == pytest.approx(np.std([25 / 40, 30 / 40], ddof=1))
    assert evaluation.mean("lucky", "mot", "mota", ["short"]).mean == pytest.approx(0.5)
    assert evaluation.finished("bad", "mot") == ["long"]
    assert evaluation.mean("bad", "mot", "mota").mean == 1
    assert np.isnan(evaluation.mean("bad", "mot", "mota", ["short"]).mean)


def test_what_goes_wrong_has_a_table_of_its_own() -> None:
    tables = {table.title: table for table in mot_sections.tables(MotEvaluation(OUTCOMES))}
    wrong = tables["What goes wrong on each sequence"]
    assert wrong.head[2:] == ("handed over", "exchanged", "ghosts", "doubled", "merged", "late")
    assert [[cell.text for cell in row[:2]] for row in wrong.rows][-1] == ["bad", "long"]
    assert tables["Each tracker on each sequence"].head[-1] == "mostly lost"
