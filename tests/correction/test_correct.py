"""Tracks between keyframes: both ways, over occlusions, refined, smoothed, and their doubts."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import motes
from clips import write_film
from motes import ConfigError, Frame, SourceError, Status, Track, preset
from motes.core.geometry import Ellipse, iou
from motes.correction import Course, Stretch, passes_over, ranked
from motes.correction.coordinates import overlap_probability, variances_told
from motes.correction.keyframes import keyframes_in
from motes.synthetic.clips import Clip, occluded, turning

FRAMES = 72


@pytest.fixture(scope="module")
def clip() -> Clip:
    return occluded((192, 144), frames=FRAMES, length=4)


@pytest.fixture(scope="module")
def film(clip: Clip, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a film in which a stem hides the target for a while."""
    path = tmp_path_factory.mktemp("film") / "film.mkv"
    write_film(path, clip)
    return path


def box(clip: Clip, frame: int) -> motes.Box:
    return clip[frame][1][0].ellipse.box


@pytest.fixture(scope="module")
def marks(clip: Clip) -> dict[int, motes.Box | None]:
    return {0: box(clip, 0), FRAMES - 1: box(clip, FRAMES - 1)}


@pytest.fixture(scope="module")
def tracks(film: Path, marks: dict[int, motes.Box | None]) -> list[Track]:
    return motes.correct(film, marks)


class Frames:
    """The frames of a clip, in any order; an interrupt comes before one of them."""

    def __init__(self, clip: Clip, interrupted: int | None = None) -> None:
        self._clip, self._interrupted = clip, interrupted

    def forward(self, first: int, last: int) -> Iterator[Frame]:
        """Yield frames in order."""
        return self._each(range(first, last + 1))

    def backward(self, last: int, first: int) -> Iterator[Frame]:
        """Yield frames in reverse order."""
        return self._each(range(last, first - 1, -1))

    def _each(self, order: range) -> Iterator[Frame]:
        for i in order:
            if i == self._interrupted:
                raise KeyboardInterrupt
            yield self._clip[i][0]


@pytest.mark.parametrize("config", ["default", "maggio"])
def test_an_ellipse_without_a_turn_is_no_box(tmp_path: Path, config: str) -> None:
    clip = turning((320, 240), frames=60)
    write_film(tmp_path / "film.mkv", clip)
    truth = [clip[frame][1][0].ellipse for frame in range(60)]
    assert truth[0].theta == 0
    found = motes.correct(tmp_path / "film.mkv", {0: truth[0]}, config)
    turns = [a.ellipse.theta - b.theta for a, b in zip(found, truth, strict=True)]
    assert np.median([abs(math.remainder(turn, math.pi)) for turn in turns]) < math.radians(3)
    boxes = motes.correct(tmp_path / "film.mkv", {0: truth[0].box}, config)
    assert not any(track.ellipse.theta for track in boxes)


def test_boxes_and_ellipses_are_not_mixed(
    film: Path, clip: Clip, marks: dict[int, motes.Box | None]
) -> None:
    ellipse = Ellipse.from_box(box(clip, 20))
    with pytest.raises(ConfigError, match="Frame 20 is marked by an ellipse, and frame 71 by a"):
        motes.correct(film, {**marks, 20: ellipse})


def test_frames_may_come_backward(clip: Clip) -> None:
    tracker = motes.Tracker(backward=True)
    track = tracker.init(clip[20][0], box(clip, 20))
    assert track.time == clip[20][0].time
    back = [tracker.update(clip[i][0]) for i in range(19, 9, -1)]
    assert [track.frame for track in back] == [*range(19, 9, -1)]
    assert [track.time for track in back] == [clip[i][0].time for i in range(19, 9, -1)]
    assert tracker.info.track.time == clip[10][0].time
    assert tracker.info.track.status is Status.TRACKING
    with pytest.raises(SourceError, match="does not come before"):
        tracker.update(clip[12][0])


def test_hidden_frames_are_bridged(clip: Clip, tracks: list[Track]) -> None:
    """The stem hides the target for a while; both passes hold on or wait on their sides."""
    assert [track.frame for track in tracks] == [*range(FRAMES)]
    overlaps = [float(iou(track.box, box(clip, track.frame))) for track in tracks]
    visible = [clip[i][1][0].visible for i in range(FRAMES)]
    assert min(o for o, v in zip(overlaps, visible, strict=True) if v > 0.9) > 0.5
    assert max(abs(t.ellipse.x - clip[t.frame][1][0].ellipse.x) for t in tracks) < 20
    assert tracks[0].confidence == tracks[-1].confidence == 1
    assert tracks[0].box == pytest.approx(box(clip, 0))
    deviation = [math.sqrt(track.covariance[0, 0]) for track in tracks]
    assert deviation[0] == deviation[-1] == 0
    assert max(deviation) == max(deviation[10:-10])


@pytest.mark.slow
def test_only_neighboring_stretches_are_made_anew(
    film: Path, clip: Clip, tracks: list[Track], marks: dict[int, motes.Box | None]
) -> None:
    first = motes.refine(film, tracks, marks, {20: box(clip, 20)})
    assert first[20].box == pytest.approx(box(clip, 20))
    known = {**marks, 20: box(clip, 20)}
    second = motes.refine(film, first, known, {30: box(clip, 30), 25: None})
    same = [new is old for new, old in zip(second, first, strict=True)]
    assert same == [frame < 20 for frame in range(FRAMES)]
    assert second[25].status is Status.ABSENT
    again = motes.correct(film, {**known, 30: box(clip, 30), 25: None})
    assert [track.to_dict() for track in again] == [track.to_dict() for track in second]


def test_stretches_meet_at_keyframes() -> None:
    region = Ellipse(5, 5, 3, 3)
    found = Stretch.between(range(10, 50), {20: region, 25: None, 30: region})
    assert [(each.first, each.last) for each in found] == [(10, 20), (20, 30), (30, 49)]
    assert found[0].begin is None
    assert found[1] == Stretch(20, 30, region, region, frozenset({25}))
    assert found[2].end is None
    assert Stretch.between(range(7, 8), {7: region}) == [Stretch(7, 7, region, None)]


def test_an_interrupted_pass_is_kept(clip: Clip) -> None:
    region = Ellipse.from_box(box(clip, 0))
    stretch, so_far = Stretch(0, 47, region, None, frozenset({3, 5, 40})), list[Track]()
    with pytest.raises(KeyboardInterrupt):
        passes_over(Frames(clip, interrupted=6), stretch, preset("default"), 0, so_far)
    part, times = stretch.begun(so_far[-1].frame), [i / 25 for i in range(FRAMES)]
    kept = part.joined(times, Course.of(so_far), None)
    assert [track.frame for track in kept] == [*range(6)]
    assert [track.frame for track in kept if track.status is Status.ABSENT] == [3, 5]


def walk(count: int, **changes: object) -> list[Track]:
    """Return tracks of a target that walks to the right, two pixels a frame."""
    jitter = np.random.default_rng(0).normal(0, 1, (count, 2))
    place = np.stack([50 + 2.0 * np.arange(count), np.full(count, 60.0)], axis=1) + jitter
    return [
        Track(i, i / 25, Ellipse(x, y, 10, 20), np.eye(5), 0.9, Status.TRACKING, 0.1, 50.0)
        for i, (x, y) in enumerate(place.tolist())
    ]


def test_smoothing_bridges_losses_and_jumps() -> None:
    tracks = walk(60)
    for i in range(20, 30):
        tracks[i] = replace(tracks[i], status=Status.SEARCHING, ellipse=Ellipse(9, 9, 9, 9))
    for i in (40, 41):
        tracks[i] = replace(tracks[i], ellipse=Ellipse(300, 60, 10, 20))
    for i in range(57, 60):
        tracks[i] = replace(tracks[i], status=Status.LOST)
    smoothed = motes.smooth(tracks)
    assert [t.frame for t in smoothed if t.status is Status.INTERPOLATED] == [
        *range(20, 30),
        40,
        41,
    ]
    assert [t.frame for t in smoothed if t.outlier] == [40, 41]
    assert smoothed[25].ellipse.x == pytest.approx(100, abs=4)
    assert smoothed[41].ellipse.x == pytest.approx(132, abs=4)
    variances = [track.covariance[0, 0] for track in smoothed]
    assert variances[25] > variances[21] > variances[15]
    assert [track.status for track in smoothed[57:]] == [Status.LOST] * 3
    assert smoothed[58].ellipse == tracks[58].ellipse
    nothing = [replace(track, status=Status.LOST) for track in tracks]
    assert motes.smooth(nothing) == nothing


def test_one_pass_is_not_surer_than_its_tracker() -> None:
    tracks = [replace(track, covariance=100 * np.eye(5)) for track in walk(60)]
    assert all(track.covariance[0, 0] >= 100 for track in motes.smooth(tracks))


def test_what_is_lost_is_no_surer_when_it_is_bridged() -> None:
    """Whether the covariance is known, as in Python, or not, as of rows of a plain run."""
    tracks = walk(60)
    for i in range(20, 30):
        tracks[i] = replace(tracks[i], status=Status.SEARCHING, confidence=0.08)
    unknown = [replace(track, covariance=np.full((5, 5), math.nan)) for track in tracks]
    for found in (motes.smooth(tracks), motes.smooth(unknown)):
        assert {found[i].status for i in range(20, 30)} == {Status.INTERPOLATED}
        assert max(found[i].confidence for i in range(20, 30)) <= 0.08
    assert found[21].covariance[0, 0] > 5 * found[15].covariance[0, 0]


def test_rows_of_a_file_are_no_tracks(tmp_path: Path, film: Path) -> None:
    path = tmp_path / "rows.csv"
    with motes.TrackWriter(path) as writer:
        for track in walk(3):
            writer.write(track.frame, track.time, track)
    rows: Any = motes.read_track(path)
    for taken in (
        lambda: motes.smooth(rows),
        lambda: motes.doubts(rows, {}),
        lambda: motes.refine(film, rows, {0: (9, 9, 9, 9)}, {}),
    ):
        with pytest.raises(ConfigError, match=r"Give the Track of each frame.*; rows of a file"):
            taken()


def test_an_unsure_row_counts_less() -> None:
    """Its deviation is not known, but its confidence is."""
    tracks = [replace(track, covariance=np.full((5, 5), math.nan)) for track in walk(60)]
    tracks[30] = replace(tracks[30], ellipse=tracks[30].ellipse._replace(x=113))
    unsure = [*tracks[:30], replace(tracks[30], confidence=0.1), *tracks[31:]]
    sure, less = motes.smooth(tracks)[30], motes.smooth(unsure)[30]
    assert abs(less.ellipse.x - 110) < 0.7 * abs(sure.ellipse.x - 110)
    assert less.covariance[0, 0] > 5 * sure.covariance[0, 0]


def test_the_variances_of_a_confidence_give_it_back() -> None:
    ellipses = np.array([[9.0, 9, 10, 20, 0], [9, 9, 30, 5, 1], [9, 9, 10, 20, 0]])
    confidence = np.array([0.1, 0.6, 0.99])
    variances = variances_told(ellipses, confidence, 0.5)
    assert overlap_probability(ellipses, variances, 0.5) == pytest.approx(confidence)
    ends = variances_told(ellipses, np.array([0.0, 1.0, math.nan]), 0.5)
    assert np.isfinite(ends[:2]).all()


def test_the_first_doubt_is_where_most_is_gained() -> None:
    ellipses = np.tile([50.0, 50, 10, 10, 0], (101, 1))
    variances = np.ones((101, 5)) * 1e-6
    keys = np.zeros(101, bool)
    keys[[0, 100]] = True
    confidence = np.ones(101)
    assert ranked(ellipses, variances, confidence, keys, 5) == []
    t = np.arange(101)
    variances[:, :2] = (t * (100 - t) / 25.0)[:, None]
    found = ranked(ellipses, variances, confidence, keys, 3)
    assert found[0].place == pytest.approx(50, abs=2)
    assert {round(each.place / 25) for each in found[1:]} == {1, 3}  # the halves come next
    assert found[0].gain > found[1].gain
    confidence[70:80] = 0.1
    assert ranked(ellipses, variances * 1e-3, confidence, keys, 1)[0].place in range(60, 85)


def test_doubts_have_reasons() -> None:
    tracks = walk(60)
    for i in range(30, 60):
        tracks[i] = replace(tracks[i], ellipse=tracks[i].ellipse._replace(y=100))
    (doubt,) = motes.doubts(tracks, {0: None}, 1)
    assert doubt.frame >= 30
    assert doubt.gain > 5
    tracks[45] = replace(tracks[45], outlier=True, confidence=0.1)
    reasons = {d.frame: d.reasons for d in motes.doubts(tracks, {0: None}, 60)}
    assert "jump" in reasons[30]
    assert reasons[45] == ("a tracker was elsewhere", "low confidence")


def test_a_cut_of_the_film_is_a_doubt() -> None:
    tracks = walk(60)
    assert motes.doubts(tracks, {0: None}) == []
    first, *_ = motes.doubts(tracks, {0: None}, cuts=[30])
    assert (first.frame, first.reasons) == (30, ("cut",))
    assert motes.doubts(tracks, {0: None, 30: None}, cuts=[30]) == []  # the user has looked


@pytest.mark.parametrize("known", [True, False])
def test_distance_from_a_keyframe_alone_is_no_doubt(known: bool) -> None:
    tracks = walk(400)
    if known:  # as the rows of `correct` have them
        away = np.minimum(np.arange(400), 30)
        tracks = [
            replace(track, covariance=np.diag([0.01 * d] * 2 + [1e-4 * d] * 2 + [0.0]))
            for track, d in zip(tracks, away.tolist(), strict=True)
        ]
    assert motes.doubts(tracks, {0: None}) == []
    tracks[390:] = [replace(track, status=Status.LOST, confidence=0.05) for track in tracks[390:]]
    first, *_ = doubts = motes.doubts(tracks, {0: None})
    assert first.frame >= 390
    assert first.reasons == ("lost", "low confidence")
    assert all(doubt.frame >= 390 for doubt in doubts)
    assert all(doubt.gain >= 0.5 for doubt in doubts)
    gains = [doubt.gain for doubt in doubts]
    assert gains == sorted(gains, reverse=True)


def test_only_the_first_angle_is_within_a_turn() -> None:
    turned, turning = Ellipse(20, 20, 9, 5, 30.0), Ellipse(20, 20, 9, 5, 6.0)
    assert [*keyframes_in({4: turned, 2: turning, 0: None})] == [0, 2, 4]
    with pytest.raises(ConfigError, match="theta begins with 30"):
        keyframes_in({4: turning, 2: turned})


def test_bad_marks(film: Path, tracks: list[Track], clip: Clip) -> None:
    with pytest.raises(ConfigError, match=f"keyframe {FRAMES} is outside"):
        motes.correct(film, {FRAMES: box(clip, 0)})
    with pytest.raises(ConfigError, match="center outside"):
        motes.correct(film, {0: (500, 5, 9, 9)})
    with pytest.raises(ConfigError, match="every frame, in order"):
        motes.refine(film, tracks[::2], {0: box(clip, 0)}, {})
