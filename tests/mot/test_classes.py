"""Classes of objects: votes, selections, and detectors that look at some frames only."""

import json
from collections.abc import Sequence
from pathlib import Path

import pytest
from msgspec.structs import replace

from motes import Box, Detection, EventCounter, Frame, Line, Regions, Scene, Status, Track
from motes.cli.watch_loop import table
from motes.formats.registry import format_for, write as write_format
from motes.formats.rows import recording_of_journal
from motes.mot.scene_config import DetectionSelection, SceneConfig
from motes.mot.stages.suppress_duplicates import suppress_duplicates
from motes.rows.schema import FrameRow, Header
from motes.rows.writer import JournalWriter
from scene_objects import RED, config, picture
from sightings import seen

BOX = Box(60, 40, 20, 30)


def moving(index: int) -> tuple[Frame, Box]:
    """Return a frame with a red box that moves by 2 pixels a frame, and the box."""
    box = Box(40 + 2 * index, 40, 20, 30)
    return picture(index, (box, RED)), box


def scene_of(labels: Sequence[str | None], settings: SceneConfig) -> list[list[str | None]]:
    """Return the classes of the objects in each frame, of an object detected as these labels."""
    found = iter(labels)
    scene = Scene(lambda frame: [Detection(moving(frame.index)[1], 0.9, next(found))], settings)
    return [[each.label for each in scene.update(moving(n)[0])] for n in range(len(labels))]


def test_a_class_is_a_vote_over_the_life() -> None:
    labels = ["car", "car", "car", "bus", "bus", "car", "bus", "bus", "bus"]
    (*_, last) = answers = scene_of(labels, config())
    assert answers[2] == ["car"]
    assert answers[4] == ["bus"]  # born as a car in the third frame: one vote for it, two against
    assert last == ["bus"]
    assert scene_of([None] * 4, config())[-1] == [None]


def test_other_classes_and_low_scores_are_left_out() -> None:
    frame = picture(0)
    given = [
        Detection(Box(20 * n, 10, 10, 20), score, label)
        for n, (score, label) in enumerate([(0.9, "car"), (0.3, "car"), (0.9, "bus"), (0.9, None)])
    ]
    rule = DetectionSelection(classes=("car",), least=0.5)
    found, _ = suppress_duplicates(given, frame, rule)
    assert found == given[:1]
    assert len(suppress_duplicates(given, frame, DetectionSelection())[0]) == 4


def test_objects_are_followed_between_the_frames_of_a_slow_detector() -> None:
    looks = []

    def detector(frame: Frame) -> list[Detection]:
        looks.append(frame.index)
        return [Detection(moving(frame.index)[1])]

    settings = replace(config(), detections=DetectionSelection(every=5))
    scene = Scene(detector, settings, seed=0)
    frames = [moving(n)[0] for n in range(31)]
    tracks = [list(found) for _, found in scene.watch(frames)]
    assert looks == [0, 5, 10, 15, 20, 25, 30]
    assert [len(found) for found in tracks] == [0] * 10 + [1] * 21  # the third look is at frame 10
    assert {found[0].identity for found in tracks[10:]} == {1}
    assert {found[0].status for found in tracks[10:]} == {Status.TRACKING}
    assert [found[0].detected for found in tracks[10:15]] == [True, False, False, False, False]
    for index, (each,) in enumerate(tracks[10:], start=10):
        assert each.box.x == pytest.approx(40 + 2 * index, abs=5)


def test_without_a_look_nothing_is_overdue() -> None:
    """With a detector that looks and finds nothing, the object is lost after 0.12 s."""
    for every, status in ((1, Status.LOST), (8, Status.TRACKING)):
        there = [True]
        settings = replace(config(), detections=DetectionSelection(every=every))
        scene = Scene(lambda _, there=there: [Detection(BOX)] if there else [], settings)
        for index in range(3 * every + 6):
            if index == 2 * every + 1:
                there.clear()
            last = scene.update(picture(index, (BOX, RED)))
        assert [each.status for each in last] == [status]


@pytest.mark.parametrize("stands", [False, True])
def test_what_is_not_detected_is_kept_as_long_with_a_slow_detector(stands: bool) -> None:
    """Also if it still looks as it did, as what a detector has mistaken for an object does."""
    for every in (1, 4):
        settings = replace(config(), detections=DetectionSelection(every=every))
        scene = Scene(lambda frame: [Detection(BOX)] if frame.index < 100 else [], settings)
        frames = [picture(n, *[(BOX, RED)] * (stands or n < 100)) for n in range(200)]
        (*_, last) = [each for _, tracks in scene.watch(frames) for each in tracks]
        assert last.gone
        assert last.time - frames[99].time == pytest.approx(3, abs=0.3)


def test_events_and_counts_have_classes() -> None:
    counting = EventCounter(Regions((Line((50, 0, 50, 99), "gate"),)))
    events = []
    for label, identity in (("car", 1), ("bus", 2), ("car", 3)):
        for frame, x in enumerate((42.0, 47.0, 52.0, 57.0, 62.0)):
            track = replace(seen(frame, (x, 40), identity=identity), label=label)
            events += counting.update([track])
    assert json.loads(events[-1].json())["label"] == "car"
    assert "class" not in events[-1].json()
    assert counting.counts[0, "crosses", "gate", "in", "car"] == 2
    assert table(counting.counts)[-1] == (
        "minute 0: appears bus 1, appears car 2, crosses gate in bus 1, crosses gate in car 2"
    )


def objects_of_two_classes() -> list[list[Track]]:
    """Return the objects of two frames; the second one's class changes."""
    frames = []
    for frame, name in enumerate(("van, old", "car")):
        first, second = seen(frame, (40, 60), identity=1), seen(frame, (90, 60), identity=2)
        frames.append([first, replace(second, label=name)])
    return frames


def test_documents_have_the_last_class_of_each_object(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    writer = JournalWriter(path, Header("film", 200, 100, "thing"))
    for index, tracks in enumerate(objects_of_two_classes()):
        writer.add(FrameRow(index, index / 4, tuple(tracks)))
    writer.close()
    document = tmp_path / "out.json"
    write_format(document, format_for(document.name), recording_of_journal(path))
    found = json.loads(document.read_text())
    assert [each["name"] for each in found["categories"]] == ["thing", "car"]
    assert [each["category_id"] for each in found["annotations"]] == [1, 2, 1, 2]
