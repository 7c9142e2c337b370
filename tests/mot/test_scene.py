"""Many objects: birth, identity, occlusion, death; and of very many the surest."""

import copy
import gc
import itertools
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pytest
from msgspec.structs import astuple, replace
from numpy.typing import NDArray

from motes import Detection, Detector, Frame, Scene, Status, Track
from motes.core.errors import ConfigError, SourceError
from motes.core.geometry import Box, iou
from motes.mot import track_initiation
from motes.mot.detection.background import BackgroundDetector
from motes.mot.overlaps import as_rows, occlusion_candidates
from motes.mot.scene_config import DetectionSelection, Initiation, SceneConfig, scene_config
from motes.mot.stages.associate import split_merged_blob
from motes.mot.track_initiation import SCORES, TrackInitiation
from motes.synthetic import Clip, Target
from scene_objects import grid, quick
from waiting import wait_until

GROUND = np.random.default_rng(0).integers(90, 110, (120, 200, 3)).astype(np.uint8)
COLORS = [(220, 60, 60), (60, 60, 220), (60, 200, 60)]


class Stage:
    """A scene of painted boxes whose detections are given."""

    def __init__(self, **changes: object) -> None:
        self.found: list[Detection] = []
        self.scene = Scene(lambda _: self.found, **changes)  # type: ignore[arg-type]
        self.index = -1

    def show(self, boxes: Sequence[Box | None], found: Sequence[Box] | None = None) -> list[Track]:
        """Paint boxes, later ones in front, and detect them or what is given instead."""
        pixels = GROUND.copy()
        for box, color in zip(boxes, COLORS, strict=False):
            if box is not None:
                x, y, w, h = map(int, box)
                pixels[max(y, 0) : y + h, max(x, 0) : max(x + w, 0)] = color
        there = [box for box in boxes if box is not None] if found is None else found
        self.found = [Detection(box) for box in there]
        self.index += 1
        return self.scene.update(Frame(self.index, self.index / 25, pixels))


def walker(index: int, x: float = 20, y: float = 30) -> Box:
    return Box(x + 3 * index, y, 16, 30)


def test_a_copy_goes_on_as_its_scene() -> None:
    scene = Scene(lambda _: [Detection(Box(20, 20, 30, 30), 0.9)])
    for _ in range(3):
        scene.update(GROUND)
    one, other = copy.deepcopy(scene).update(GROUND), scene.update(GROUND)
    assert [str(each.to_dict()) for each in one] == [str(each.to_dict()) for each in other] != []


@pytest.mark.slow
def test_identities_are_never_used_twice() -> None:
    stage = Stage()
    seen = []
    for visit in range(2):
        for i in range(10):
            said = stage.show([walker(i)])
        seen += [each.identity for each in said]
        for _ in range(60):
            stage.show([None])
        assert stage.scene.terminated == visit + 1
    assert seen == [1, 2]


@pytest.mark.slow
def test_who_is_hidden_coasts_behind_the_other_and_is_found_again() -> None:
    """The first passes behind the second, which stands; a blob covers both while they touch."""
    stage, still, said = Stage(), Box(90, 20, 40, 50), {}
    for i in range(70):
        box = walker(i, x=-10)
        touching = box.x + box.width > still.x and box.x < still.x + still.width
        left, right = min(box.x, still.x), max(box.x + 16, still.x + 40)
        blob = Box(left, 20, right - left, 50)
        on_screen = box.x > 0 and box.x + 16 < 200
        found = [blob] if touching else [still, box] if on_screen else [still]
        said[i] = {t.identity: t for t in stage.show([box, still], found)}
    boxes = {i: walker(i, x=-10) for i in said}
    before, after = said[26], said[52]
    assert boxes[26].x + 16 < still.x
    assert boxes[52].x > still.x + 40
    (who,) = [k for k, t in before.items() if iou(t.box, boxes[26]) > 0.7]
    (other,) = [k for k in before if k != who]
    hidden = said[40][who]
    assert (hidden.status, hidden.occluded_by) == (Status.OCCLUDED, other)
    assert hidden.confidence == 0
    assert iou(hidden.box, boxes[40]) > 0.5  # it keeps its pace
    assert said[40][other].status is Status.TRACKING
    assert iou(after[who].box, boxes[52]) > 0.7
    assert iou(after[other].box, still) > 0.7
    assert stage.scene.created == 2


def test_frames_at_which_a_slow_detector_does_not_look_cost_no_confidence() -> None:
    stage = Stage(config=scene_config("nummiaro", {"detections": {"every": 5}}))
    said = [track for i in range(40) for track in stage.show([walker(i)])]
    sure = [track.confidence for track in said]
    assert sure == sorted(sure)
    assert sure[-1] > sure[0] + 0.02


def stands(places: Sequence[NDArray[np.uint8]]) -> Iterator[Frame]:
    """Yield a film of places, in whose first 15 frames somebody stands."""
    for index, place in enumerate(places):
        pixels = place.copy()
        if index < 15:
            pixels[30:60, 20:36] = COLORS[0]
        yield Frame(index, index / 25, pixels)


def detected(scene: Scene, film: Iterator[Frame]) -> list[int]:
    """Return how many are detected in each frame."""
    return [len([each for each in scene.update(frame) if each.detected]) for frame in film]


@pytest.mark.parametrize("seen_before", [False, True])
def test_who_stands_there_at_first_is_found_if_the_begin_was_seen_before(seen_before: bool) -> None:
    """A background is learned from frames in which he has gone; another detector reads none."""
    scene = Scene(BackgroundDetector())
    if seen_before:
        scene.prepare(frame.pixels for frame in stands([GROUND] * 40))
    assert detected(scene, stands([GROUND] * 40))[3:15] == [int(seen_before)] * 12
    unread = stands([GROUND])
    Scene(lambda _: []).prepare(unread)
    assert next(unread).index == 0


def patchwork(seed: int) -> NDArray[np.uint8]:
    """Return a picture of another place."""
    patches = np.random.default_rng(seed).integers(0, 250, (5, 8, 3))
    return patches.astype(np.uint8).repeat(24, axis=0).repeat(24, axis=1)


def test_the_background_is_that_of_before_a_cut() -> None:
    scene, places = Scene(BackgroundDetector()), [patchwork(0)] * 40 + [patchwork(1)] * 80
    scene.prepare(stands(places))
    assert detected(scene, stands(places))[3:15] == [1] * 12


@pytest.mark.parametrize("prepared", [False, True])
def test_a_background_of_two_views_makes_all_counts_doubtful(prepared: bool) -> None:
    """The camera is turned, and nothing but its place in the picture changes."""
    scene, place = Scene(BackgroundDetector()), patchwork(0)
    views = [place] * 40 + [np.roll(place, 60, axis=1)] * 20
    if prepared:
        scene.prepare(stands(views))
    detected(scene, stands(views))
    assert set(scene.doubts.values()) == {0 if prepared else 40}


@pytest.mark.slow
@pytest.mark.parametrize("cut", [False, True])
def test_a_cut_of_the_film_ends_all_tracks(cut: bool) -> None:
    """The same thing goes on in another picture."""
    found, tracks = list[Detection](), list[list[tuple[int, bool]]]()
    scene = Scene(lambda _: found)
    for i in range(30):
        pixels = patchwork(cut and i >= 15)
        found[:] = [Detection(walker(i))]
        pixels[30:60, 20 + 3 * i : 36 + 3 * i] = COLORS[0]
        told = scene.update(Frame(i, i / 25, pixels))
        tracks.append([(each.identity, each.gone) for each in told])
    assert scene.doubts == ({"cut": 15} if cut else {})
    assert tracks[14:18] == (
        [[(1, False)], [(1, True)], [], [(2, False)]] if cut else [[(1, False)]] * 4
    )
    assert (scene.created, scene.terminated) == (1 + cut, cut)


@pytest.mark.slow
def test_tracks_of_one_object_do_not_depend_on_others() -> None:
    alone, together = Stage(seed=3), Stage(seed=3)
    for i in range(30):
        first = alone.show([walker(i)])
        found = [walker(i)] if i < 5 else [walker(i), Box(150, 75, 20, 30)]
        second = together.show([walker(i)], found)
        assert [t.ellipse for t in first] == [t.ellipse for t in second[:1]]
        assert [t.distance for t in first] == [t.distance for t in second[:1]]
    assert (len(first), len(second)) == (1, 2)


@pytest.mark.slow
def test_noise_neither_crashes_nor_grows() -> None:
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 64, (16, 24, 32, 3), np.uint8)
    pictures = rng.integers(0, 192, (24, 32, 3), np.uint8) + noise  # of one place: no film of cuts
    found: list[Detection] = []

    def detector(frame: Frame) -> list[Detection]:
        if frame.index % 10 == 0:  # long enough for births
            boxes = rng.uniform((-5, -5, 1, 1), (32, 24, 20, 20), (rng.integers(3), 4))
            found[:] = [Detection(Box(*box), float(rng.random())) for box in boxes.tolist()]
        return found if frame.index % 10 < 4 else []

    scene, sizes, most = Scene(detector, scene_config(quick(particles=5))), [], 0
    for index, pixels in zip(range(500), itertools.cycle(pictures)):
        most = max(most, len(scene.update(Frame(index, index / 25, pixels))))
        if index in (250, 499):
            gc.collect()
            sizes.append(sys.getallocatedblocks())
    assert scene.created >= scene.terminated > 10
    assert most < 20  # who is not seen again is gone after some seconds
    assert sizes[1] < sizes[0] + 600  # accounts alone would take more, kept for good


@pytest.mark.parametrize("motion", [np.eye(2, 3), np.full((3, 3), np.nan), np.zeros((3, 3)), "up"])
def test_a_motion_that_is_no_homography_is_refused(motion: Any) -> None:
    class Moved:
        def __call__(self, frame: Frame) -> list[Detection]:
            return []

        @property
        def motion(self) -> Any:
            return motion

    with pytest.raises(ConfigError, match=r"motion is .+; it must be a homography"):
        Scene(Moved()).update(Frame(0, 0.0, GROUND))


@pytest.mark.parametrize("detector", [None, 3, "mog2", BackgroundDetector])
def test_what_is_no_detector_is_refused_at_once(detector: Any) -> None:
    with pytest.raises(ConfigError, match=r"named_detector\(\); got"):
        Scene(detector)


def test_frames_must_fit() -> None:
    scene = Scene(lambda _: [])
    scene.update(Frame(3, 1.0, GROUND))
    with pytest.raises(SourceError, match="does not come after"):
        scene.update(Frame(4, 1.0, GROUND))
    with pytest.raises(SourceError, match="stays the same"):
        scene.update(Frame(4, 1.1, GROUND[:50]))
    with pytest.raises(ConfigError, match="particle filters: nummiaro"):
        Scene(lambda _: [], "mean_shift")
    for seed in (-1, 1 << 64, 1.5):
        with pytest.raises(ConfigError, match=r"seed is a whole number from 0 to 2\*\*64 - 1; got"):
            Scene(lambda _: [], seed=seed)  # type: ignore[arg-type]


@pytest.mark.slow
def test_identities_survive_full_occlusion() -> None:
    """From pixels alone: one walks behind a longer one for 15 frames, and onwards."""
    pytest.importorskip("cv2")
    empty = 60  # frames in which a background is learned
    x = np.concatenate([np.full(empty, -45.6), np.arange(-45.6, 200, 1.6)])
    behind = np.stack(np.broadcast_arrays(x, 75.0, 24.0, 17.0, 0.0), axis=1)
    before = np.stack(np.broadcast_arrays(239 - x, 75.0, 45.6, 25.0, np.pi), axis=1)
    green = (120, 190, 110), (30, 70, 40), (240, 240, 120)
    red = (200, 80, 80), (90, 20, 20), (250, 180, 120)
    clip = Clip((240, 150), (Target(behind, green), Target(before, red)), seed=30)
    scene, who, visible = Scene(BackgroundDetector()), list[list[int]](), list[float]()
    for frame, truths in clip:
        said = [each for each in scene.update(frame) if each.status is Status.TRACKING]
        there = [[t.identity for t in said if iou(t.box, one.ellipse.box) > 0.4] for one in truths]
        who.append([max(each, default=0) for each in there])
        visible.append(truths[0].visible)
    inside = empty + 50  # by when both have come in
    first, last = inside + np.flatnonzero(np.array(visible[inside:]) < 0.98)[[0, -1]]
    early, late = np.array(who[first - 10 : first - 5]), np.array(who[last + 5 : last + 10])
    for k in range(2):
        identity = np.bincount(early[:, k]).argmax()
        assert identity > 0
        assert (late[:, k] == identity).mean() > 0.8


class Slow:
    """A detector that is now quicker and now slower than what follows, and says what it does."""

    def __init__(self, wrapped: Detector, fail: int = -1) -> None:
        self.wrapped, self.fail = wrapped, fail
        self.warnings: dict[str, str] = {}

    def __call__(self, frame: Frame) -> Any:
        """Return what the wrapped one finds."""
        if frame.index == self.fail:
            raise SourceError("the detector is tired")
        time.sleep(0.003 * (frame.index % 3))
        self.warnings[f"{frame.index // 10}"] = f"Frame {frame.index}"
        return self.wrapped(frame)


def walks() -> Iterator[Frame]:
    """Yield two who meet, before a still camera, from frame 10 on."""
    rng = np.random.default_rng(1)
    for i in range(45):
        pixels = GROUND + rng.integers(0, 5, GROUND.shape, np.uint8)
        for box, color in zip((walker(i - 10), walker(55 - i)), COLORS, strict=False):
            x, y, w, h = map(int, box)
            if i >= 10:
                pixels[y : y + h, max(x, 0) : max(x + w, 0)] = color
        yield Frame(i, i / 25, pixels)


@pytest.mark.slow
def test_what_is_found_ahead_changes_nothing() -> None:
    scenes = [Scene(Slow(BackgroundDetector()), seed=2) for _ in range(3)]
    serial = [told(scenes[0], frame, scenes[0].update(frame)) for frame in walks()]
    assert scenes[0].created >= 2
    for scene, ahead in zip(scenes[1:], (True, False), strict=True):
        said = [told(scene, *each) for each in scene.watch(walks(), ahead=ahead)]
        assert said == serial


def told(scene: Scene, frame: Frame, tracks: list[Track]) -> tuple[object, ...]:
    """Return all that is said of a frame in a form that is compared bit for bit."""
    bits = [
        [value if isinstance(value, dict) else np.asarray(value).tobytes() for value in astuple(t)]
        for t in tracks
    ]
    who = [(t.identity, t.occluded_by, t.detected) for t in tracks]
    return frame.index, who, bits, dict(scene.warnings)


def test_no_more_than_two_frames_are_looked_at_ahead() -> None:
    looked: list[Frame] = []

    def detector(frame: Frame) -> list[Detection]:
        looked.append(frame)
        return []

    for frame, _ in Scene(detector).watch(itertools.islice(walks(), 20)):
        most = min(frame.index + 3, 20)
        wait_until(lambda most=most: len(looked) >= most)  # type: ignore[misc]
        assert len(looked) == most


@pytest.mark.parametrize("ahead", [True, False])
def test_what_fails_ahead_is_told_in_its_turn(ahead: bool) -> None:
    def film() -> Iterator[Frame]:
        yield from itertools.islice(walks(), 8)
        raise SourceError("the film is torn")

    for detector, frames, why in (
        (Slow(lambda _: [], fail=5), 5, "tired"),
        (Slow(lambda _: []), 8, "torn"),
    ):
        threads, watched = threading.active_count(), Scene(detector).watch(film(), ahead=ahead)
        assert [next(watched)[0].index for _ in range(frames)] == list(range(frames))
        with pytest.raises(SourceError, match=why):
            next(watched)
        assert threading.active_count() == threads


def test_objects_stay_where_they_should_be_in_what_they_share() -> None:
    places = np.array([[10, 10, 10, 20], [18, 12, 10, 20], [31, 11, 10, 20]], float)
    shared = split_merged_blob(places, Box(8, 11, 30, 23))
    np.testing.assert_allclose(shared, [[10, 11, 10, 20], [18, 12, 10, 20], [28, 11, 10, 20]])
    # One that is larger than the box has its center there.
    places = np.array([[10, 10, 40, 20], [15, 5, 10, 20]], float)
    np.testing.assert_allclose(split_merged_blob(places, Box(9, 4, 30, 27))[:, 0], [4, 15])


def test_occlusion_is_foreseen_by_equations_18_and_19() -> None:
    one = Box(0, 0, 20, 40)
    # A = (20 + 10) / 2 = 15, B = (40 + 30) / 2 = 35, R = sqrt(A² + B²) = 38.08
    near, far = Box(10 - 5 + 38, 20 - 15, 10, 30), Box(10 - 5 - 38.1, 20 - 15, 10, 30)
    i, j = occlusion_candidates(np.array([one, near, far]))
    assert (i.tolist(), j.tolist()) == ([0, 1], [1, 0])
    assert not len(occlusion_candidates(np.empty((0, 4)))[0])


GRAY = np.full((480, 640, 3), 100, np.uint8)


def config(**changes: object) -> SceneConfig:
    """Return a scene whose objects take little time of their own."""
    return replace(SceneConfig(quick(particles=2, places=5)), **changes)


def test_of_too_many_detections_the_surest_are_taken_and_that_is_told_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(track_initiation, "LOWEST", 0.0)  # none is too doubtful
    there = [Detection(Box(*box), score) for score, box in enumerate(grid(12, 0.36).tolist())]
    eight = config(detections=DetectionSelection(limit=8))
    scene = Scene(lambda _: there, eight)
    for index in range(4):
        scene.update(Frame(index, index / 25, GRAY))
    assert scene.created == 8
    assert scene.warnings == {
        "limit": "Frame 0: there are 12 detections; only the 8 surest are taken."
    }


@pytest.mark.slow
def test_four_times_the_objects_take_four_times_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Sixteen times, if anything was asked of each pair; the work is counted, not timed."""
    monkeypatch.setattr(track_initiation, "LOWEST", 0.0)

    def calls(count: int) -> int:
        """Return the calls of functions after so many births: all detected, half, and all."""
        there: list[Detection] = []
        scene, called, boxes = Scene(lambda _: there, config()), 0, grid(count, 0.36)

        def noted(_frame: object, event: str, _argument: object) -> None:
            nonlocal called
            called += event in ("call", "c_call")

        before = sys.getprofile()
        for index in range(7):
            shown = boxes[::2] if index == 4 else boxes
            doubles = [(shown, 1.0), (shown + 0.01, 0.9)]
            there = [Detection(Box(*box), score) for some, score in doubles for box in some]
            sys.setprofile(noted if index >= 3 else before)
            try:
                scene.update(Frame(index, index / 5, GRAY))
            finally:
                sys.setprofile(before)
        assert scene.created == count
        return called

    calls(80)  # imports, also those that only many need
    assert calls(80) < 6 * calls(20)


def test_how_sure_detections_are_is_judged_by_all_of_a_large_frame(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The surest come first, so that the last ones alone would let too many pass."""
    monkeypatch.setattr(track_initiation, "LOWEST", 0.1)
    births, count = TrackInitiation(), 4 * SCORES
    scored = [Detection(Box(*box), -i) for i, box in enumerate(grid(count, 0.36).tolist())]
    after, _ = births.with_scores(scored, scored).update(
        0.0, scored, as_rows(()), 0.2, Initiation()
    )
    assert len(after.candidates) == 0.9 * count


@pytest.mark.parametrize("ahead", [True, False])
def test_images_are_watched_as_they_are_updated(ahead: bool) -> None:
    images = [np.roll(GROUND, i, axis=1) for i in range(6)]
    one, other = (Scene(lambda frame: [(30 + frame.index, 20, 20, 20)]) for _ in range(2))
    watched = [told for image in images[:3] for told in one.update(image)]
    watched += [told for _, tracks in one.watch(images[3:], ahead=ahead) for told in tracks]
    updated = [told for image in images for told in other.update(image)]
    assert [(t.frame, t.box) for t in watched] == [(t.frame, t.box) for t in updated]


def test_a_scenes_configuration_takes_the_changes_of_the_command() -> None:
    config = scene_config("nummiaro", {"detections": {"every": 5}}, {"camera": "still"})
    plain = scene_config("nummiaro")
    assert config == replace(plain, detections=DetectionSelection(every=5), camera="still")
    with pytest.raises(ConfigError, match="did you mean 'every'"):
        scene_config("nummiaro", {"detections": {"evry": 5}})
    with pytest.raises(ConfigError, match="Give changes such as"):
        scene_config("nummiaro", 5)  # type: ignore[arg-type]
