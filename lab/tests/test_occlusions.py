"""Full occlusions: rendered as asked for, and counted as kept or not."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest

from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.cues.color import Color
from motes.cues.hog import Hog
from motes.mot.detection.background import BackgroundDetector
from motes.mot.scene import Scene
from motes.mot.tracked_object import SceneTrack
from motes.synthetic.beetle import Target
from motes.synthetic.clips import Clip
from motes_lab.papers import expected_time, occlusions
from motes_lab.papers.occlusion_clips import (
    EMPTY,
    OcclusionClip,
    Way,
    full_occlusions,
    occlusion_clip,
)
from motes_lab.papers.result import wilson_interval


class Told:
    """A scene that says where the first target is, under given identities; hidden, nothing."""

    def __init__(self, clip: Clip, before: int, after: int) -> None:
        self._truths = [truth for _, (truth, *_) in clip]
        self._identities, self._hidden = (before, after), False

    def update(self, frame: Frame) -> list[SceneTrack]:
        """Say where it is."""
        truth = self._truths[frame.index]
        self._hidden |= frame.index > EMPTY + 40 and truth.visible < 0.02
        if truth.visible < 0.5:
            return []
        track = Track(
            frame.index, frame.time, truth.ellipse, np.eye(4), 1.0, Status.TRACKING, 0.0, 1.0
        )
        return [SceneTrack(self._identities[self._hidden], track, None, True)]


@pytest.mark.slow
@pytest.mark.parametrize(("before", "after", "kept"), [(1, 1, True), (1, 2, False), (0, 0, False)])
@pytest.mark.parametrize("way", ["crossing", "turning back"])
def test_an_identity_is_kept(way: Way, before: int, after: int, kept: bool) -> None:
    met = occlusion_clip(way, 5)
    told: Any = Told(met.clip, before, after)
    assert occlusions.keeps(met, told) == [kept]


@pytest.mark.parametrize("way", get_args(Way))
def test_who_meets_is_hidden_whole_for_as_long_as_is_said(way: Way) -> None:
    met = occlusion_clip(way, 8, same_colors=True)
    truths = [met.clip[index][1] for index in range(EMPTY + 60, len(met.clip))]
    visible = np.array([[truth.visible for truth in each] for each in truths])
    ((target, first, last),) = full_occlusions(visible, np.ones(visible.shape, bool), 0.02)
    assert target == 0
    assert last - first + 1 == pytest.approx(8, abs=2)
    assert first + EMPTY + 60 >= met.since
    behind, before = met.clip.targets
    assert behind.colors == before.colors
    assert before.crosswise
    assert (behind.states[-1, 0] < behind.states[-20, 0]) == (way == "turning back")
    assert (
        occlusion_clip(way, 8).clip.targets[0].colors
        != occlusion_clip(way, 8).clip.targets[1].colors
    )


@pytest.mark.parametrize("way", get_args(Way))
def test_the_first_meets_the_last_of_its_lane(way: Way) -> None:
    clip = occlusion_clip(way, 8, 20).clip
    states = np.array([target.states for target in clip.targets])
    assert states.shape == (20, len(clip), 5)
    behind, before = states[:2], states[10:12]
    np.testing.assert_array_equal(behind[:, :, 1], before[:, :, 1])  # the same lane
    apart = np.abs(behind[:, None, :, 0] - before[None, :, :, 0])
    np.testing.assert_array_equal(apart.min(axis=2) < 2, [[True, True], [True, False]])
    lanes = states[:10:2, 0, 1]
    assert np.diff(lanes) == pytest.approx([96] * 4, abs=8)


def test_a_skin_across_has_the_same_colors_and_other_edges() -> None:
    states = np.array([[40.0, 40.0, 30.0, 30.0, 0.0]])
    color, hog = Color(), Hog(rotation_normalized=False)
    models = []
    for crosswise in (False, True):
        frame = Clip((80, 80), (Target(states, crosswise=crosswise),))[0][0]
        ellipse = Ellipse(40, 40, 27, 27, 0)
        models.append([cue.learn(frame, ellipse).histogram for cue in (color, hog)])
    (colors, edges), (other_colors, other_edges) = models
    assert np.sqrt(colors * other_colors).sum() > 0.97
    assert np.sqrt(edges * other_edges).sum() < 0.9


def test_short_occlusions_are_also_counted_together(monkeypatch: pytest.MonkeyPatch) -> None:
    met: list[OcclusionClip] = []

    def keeps(each: OcclusionClip, _: object) -> list[bool]:
        met.append(each)
        return [True, len(each.clip.targets) > 2]

    monkeypatch.setattr(occlusions, "keeps", keeps)
    kinds = occlusions.kinds_of([5, 45], [2, 10])
    results = list(occlusions.occlusions(kinds, 3, lambda _: Scene(BackgroundDetector())))
    assert len(results) == len(met)  # a result after each clip
    shares = [each.share for each in results]
    assert shares == sorted(shares)
    assert shares[-1] == 1
    result = results[-1]
    lengths, short = result.tables["lengths"], result.tables["short"]
    assert len(met) == 2 * 2 * 2 * 6  # two clips give the three that are wanted
    assert len(lengths.rows) == 12
    assert {tuple(c.text for c in row[2:]) for row in lengths.rows} == {
        ("5", "2 of 4", "4 of 4"),
        ("45", "2 of 4", "4 of 4"),
    }
    assert len(short.rows) == 12
    ((all_, *_, kept, share, between),) = short.foot
    low, high = wilson_interval(36, 48)
    assert (all_.text, kept.text, share.text) == ("all", "36 of 48", "75%")
    assert between.text == f"{100 * low:.1f} to {100 * high:.1f} %"


@pytest.mark.parametrize("objects", [2, 10, 20])
def test_as_many_occlusions_are_expected_as_clips_have(objects: int) -> None:
    kind = occlusions.Kind("crossing", "different", objects, 5)
    clip = kind.clip(0).clip
    states = np.array([target.states[:, :2] for target in clip.targets])
    behind, before = states[: objects // 2], states[objects // 2 :]
    meets = np.abs(behind[:, None] - before[None]).max(axis=3).min(axis=2) < 2
    assert meets.sum() == kind.per_clip
    assert kind.clips(kind.per_clip) == 1
    assert kind.clips(kind.per_clip + 1) == 2


def test_the_expected_time_is_that_of_the_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(occlusions, "seconds_per_frame", lambda scene, frames: 0.5)
    kinds = occlusions.kinds_of([5], [2])
    frames = sum(3 * len(kind.clip(0).clip) for kind in kinds)
    found = occlusions.expected(kinds, 3, lambda _: Scene(BackgroundDetector()))
    assert found == (f"18 clips, {frames} frames", frames / 2)


def test_the_first_frame_is_not_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([10.0, 13.0])  # after the first frame, and after the last one
    monkeypatch.setattr("motes_lab.papers.expected_time.time.perf_counter", lambda: next(now))
    frames = (Frame(i, i / 25, np.zeros((64, 64, 3), np.uint8)) for i in range(4))
    assert expected_time.seconds_per_frame(Scene(lambda _: []), frames) == 1


def test_durations_are_in_the_unit_that_fits() -> None:
    found = [expected_time.duration(seconds) for seconds in (0.2, 47.3, 130, 4000, 9000)]
    assert found == ["1 s", "47 s", "2 min", "67 min", "2.5 h"]


def test_wilsons_interval() -> None:
    assert wilson_interval(10, 10) == pytest.approx((0.7225, 1), abs=1e-4)
    assert wilson_interval(0, 10) == pytest.approx((0, 0.2775), abs=1e-4)
    assert wilson_interval(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)
    # Its bounds x are the roots of |p - x| = z sqrt(x (1 - x) / n).
    for successes, total in ((89, 89), (0, 10), (7, 20)):
        for bound in wilson_interval(successes, total):
            off = abs(successes / total - bound)
            assert off == pytest.approx(1.96 * np.sqrt(bound * (1 - bound) / total), abs=2e-5)
