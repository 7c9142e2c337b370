"""What moves before a camera that stands still, and what light and a trembling camera change."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from backgrounds import NO_CV2
from motes import ConfigError, Detection, Frame, SourceError, open_source
from motes.core.geometry import Box, iou
from motes.kernels.structures import LightLimits
from motes.mot.detection import background, foreground
from motes.mot.detection.background import BackgroundConfig, BackgroundDetector
from motes.mot.detection.background_model import SelectiveUpdate
from motes.mot.detection.blobs import blobs, shared
from motes.mot.detection.foreground import without_ghosts
from motes.mot.detection.illumination import (
    Background,
    with_enclosed,
    without_light,
    without_tremble,
)
from motes.mot.detection.planes import planes_of
from motes.mot.detection.pretrained import PeopleConfig, RecordedDetections
from motes.mot.detection.sway import BLOCKS, FARTHEST, FEWEST, Sway, moved
from motes.mot.scene import LAG, Scene

WALKER = (16, 30)


def picture(index: int, rng: np.random.Generator) -> Frame:
    """Return noise, after 30 frames with a bright box on it that throws a shadow, and a speck."""
    pixels = rng.integers(95, 106, (120, 160, 3)).astype(np.uint8)
    if index >= 30:
        x = 3 * (index - 30)
        pixels[40:70, x : x + WALKER[0]] = (250, 220, 60)
        shadow = pixels[75:95, x : x + WALKER[0]]
        shadow[:] = 0.7 * shadow
        pixels[10:12, x : x + 2] = 250
    return Frame(index, index / 25, pixels)


@pytest.mark.parametrize("gain", [1.0, 1.18])
def test_what_moves_is_found_without_its_shadow_in_any_exposure(gain: float) -> None:
    """The picture gets brighter right after the walker has entered."""
    rng, detector = np.random.default_rng(0), BackgroundDetector()
    for index in range(50):
        frame = picture(index, rng)
        brighter = (gain if index >= 35 else 1.0) * frame.pixels
        pixels = np.minimum(np.rint(brighter), 255).astype(np.uint8)
        found = detector(Frame(index, index / 25, pixels))
        if index < 30:
            assert found == []
        elif index > 33:
            assert len(found) == 1, index
            assert iou(found[0].box, Box(3 * (index - 30), 40, *WALKER)) > 0.8
            assert found[0].score == 1
    assert detector.warnings == {}


def test_a_gray_shirt_that_comes_before_a_white_wall_is_no_shadow() -> None:
    """It is found before a green wall; before a white one, of which it is a shade, it stays."""
    rng, start, known = np.random.default_rng(0), 30, (BackgroundDetector(), BackgroundDetector())
    for index in range(80):
        place = Box(min(3 * (index - start), 110), 30, 24, 50)
        pixels = np.full((120, 160, 3), 200.0)
        pixels[:, :80] = (40, 120, 40)
        if index >= start:
            x = place.x
            shirt = np.zeros((120, 160, 1))
            shirt[35:75, x : x + 24] = 1
            shirt = uniform_filter(shirt, (1, 11, 1))  # its rim is soft, as on film
            pixels = (1 - shirt) * pixels + shirt * 160
            pixels[30:40, x : x + 24] = pixels[70:80, x : x + 24] = (60, 20, 20)  # hair and shoes
        noise = rng.integers(-4, 5, pixels.shape)
        frame = Frame(index, index / 25, np.rint(pixels + noise).astype(np.uint8))
        known[0].observe([place] if index > start else [])
        boxes, unknown = ([each.box for each in detector(frame)] for detector in known)
        if index > start + 35:
            assert len(unknown) == 2, index
            assert len(boxes) == 1, index
            assert iou(boxes[0], place) > 0.7, index


def test_a_flood_of_objects_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(background, "LIMIT", 7)
    detector = BackgroundDetector(BackgroundConfig(least=1e-4))
    still = np.full((200, 200, 3), 90, np.uint8)
    detector(Frame(0, 0.0, still))
    flood = still.copy()
    for k in range(36):
        y, x = 10 + 32 * (k // 6), 10 + 32 * (k % 6)
        flood[y : y + 5 + k // 6, x : x + 8] = 250
    found = detector(Frame(1, 0.04, flood))
    assert [each.box.height for each in found] == [10] * 6 + [9]  # the largest
    assert "36 moving patches" in detector.warnings["flood"]


@pytest.mark.parametrize(("small", "warned"), [(6, True), (4, False), (0, False)])
def test_what_is_too_small_to_be_an_object_is_told(small: int, warned: bool) -> None:
    """Unless there are objects enough: then it is noise."""
    detector = BackgroundDetector()
    for index in range(60):
        pixels = np.full((200, 200, 3), 90, np.uint8)
        for row in range(6):
            y, side = 10 + 30 * row, 8 if row < small else 12
            pixels[y : y + side, 3 * index : 3 * index + side] = 250
        found = detector(Frame(index, index / 25, pixels))
    assert bool(found) == (small < 6)
    said = detector.warnings.get("small", "")
    assert said.endswith("give a detector.least below 0.002, such as 0.00025.") == warned


def found(mask: NDArray[np.uint8], least: int = 20) -> list[Box]:
    """Return the blobs of a mask, of so many pixels at least."""
    return blobs(mask, least / mask.size)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"least": 0.6}, "least < most"),
        ({"history": 0}, "history: got 0; it takes integer, 1 to"),
        ({"shadow": 0}, "shadow"),
    ],
)
def test_settings_that_make_no_sense(settings: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        BackgroundConfig(**settings)  # type: ignore[arg-type]


def test_detections_in_a_file(tmp_path: Path) -> None:
    path = tmp_path / "det.txt"
    path.write_text("2,-1,11,21,30,40,0.5,-1,-1,-1\n\n1,-1,1,1,5,6,2\n2,-1,5,5,8,8\n")
    detector = RecordedDetections(path)
    pixels = np.zeros((9, 9, 3), np.uint8)
    first, second, third = (detector(Frame(i, i / 25, pixels)) for i in range(3))
    assert [each.box for each in first] == [(0, 0, 5, 6)]
    assert [(each.box, each.score) for each in second] == [
        ((10, 20, 30, 40), 0.5),
        ((4, 4, 8, 8), 1.0),
    ]
    assert third == []
    (said,) = detector.unused_detections
    assert said.startswith(f"1 of 3 detections of {path} were not used: 1 out of the ")
    assert said.endswith("picture or unfit in size, 0 after frame 2")
    until = RecordedDetections(path, end=1)  # the later ones are not asked for
    assert [each.box for each in until(Frame(0, 0.0, pixels))] == [(0, 0, 5, 6)]
    assert until.unused_detections == []
    path.write_text(path.read_text() + "3,-1,5,5,8,8,1,3,1\n")
    classes = RecordedDetections(path, end=1)
    classes(Frame(0, 0.0, pixels))
    (said,) = classes.unused_detections
    assert said == f"the numbers after the score in {path}, classes or places, are not read"
    late = RecordedDetections(path, end=1)
    assert late(Frame(1, 0.0, pixels)) == []
    (said,) = late.unused_detections
    assert said.startswith(f"{path} has no detections in the frames up to 1 that were used; its")


@pytest.mark.parametrize(
    ("frames", "step", "advice"),
    [
        (range(1, 30, 5), 1, "=5"),
        (range(3, 30, 4), 1, "=4 --start 2"),
        (range(1, 30, 5), 5, None),  # as with detections.every=5
        (range(1, 31), 4, None),  # those of frames that nobody asked for are not missed
        (range(1, 18, 5), 1, None),  # too few to tell
        ([1, 3, 5, 7, 9, 28], 1, None),
        ([7, 8], 1, None),
        ([7], 1, None),
    ],
)
def test_detections_of_every_nth_frame_are_noticed(
    tmp_path: Path, frames: Sequence[int], step: int, advice: str | None
) -> None:
    path = tmp_path / "det.txt"
    path.write_text("".join(f"{frame},-1,1,1,5,6,1\n" for frame in frames))
    detector = RecordedDetections(path)
    for i in range(0, 30, step):
        detector(Frame(i, i / 25, np.zeros((9, 9, 3), np.uint8)))
    said = detector.unused_detections
    assert [text.partition("detections.every")[2] for text in said] == [advice] * bool(advice)


@pytest.mark.parametrize(
    ("frames", "told"),
    [
        (range(1, 21), True),  # its detector was stopped, or saw every other frame of the film
        ([1, 2, 3, 20], False),  # too few to tell
        ([1, 2, 3, 4, 5, 24, 25], False),  # a street is empty now and then
        (range(1, 40), False),
    ],
)
def test_detections_that_end_before_the_film_are_noticed(
    tmp_path: Path, frames: Sequence[int], told: bool
) -> None:
    path = tmp_path / "det.txt"
    path.write_text("".join(f"{frame},-1,1,1,5,6,1\n" for frame in frames))
    detector = RecordedDetections(path)
    for i in range(40):
        detector(Frame(i, i / 25, np.zeros((9, 9, 3), np.uint8)))
    said = f"the last detections of {path} are of frame 19, and 20 frames come after it; if its "
    assert [text.startswith(said) for text in detector.unused_detections] == [True] * told


def test_a_file_that_holds_no_detections_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "det.txt"
    with pytest.raises(SourceError, match="check the name"):
        RecordedDetections(path)
    path.write_text("\n \n")
    with pytest.raises(SourceError, match=r"det.txt has no detections; give a file that has some"):
        RecordedDetections(path)
    wrong = ("1,-1,2,3,x,5,1", "1,-1,2", "1,-1,2,3,0,5,1", "nan,-1,1,1,1,1,1", "0,-1,2,3,4,5")
    scored = "1,2.5,3,4,5,0.9", "1,2,3,4,5,90"  # without an identity
    for line in (*wrong, "1.5,-1,2,3,4,5,1", *scored):
        path.write_text(f"1,-1,1,1,5,6,2\n{line}\n")
        with pytest.raises(SourceError, match="line 2, is not a detection"):
            RecordedDetections(path)


@pytest.mark.skipif(NO_CV2, reason="no OpenCV")
def test_people(data: Path) -> None:
    folder = data / "mot" / "TUD-Stadtmitte"
    truth = np.loadtxt(folder / "gt" / "gt.txt", delimiter=",", usecols=range(6))
    boxes = truth[truth[:, 0] == 1, 2:] - (1, 1, 0, 0)
    with open_source(folder / "img1" / "000001.jpg") as film:
        pixels = next(film).pixels
    found = PeopleConfig().detector()(Frame(0, 0.0, pixels))
    overlaps = iou(np.array([each.box for each in found])[:, None], boxes)
    assert len(found) >= 4
    assert (overlaps.max(axis=1) > 0.5).mean() >= 0.75
    assert PeopleConfig().detector()(Frame(0, 0.0, pixels[:100])) == []


def silhouette(*heads: int) -> NDArray[np.uint8]:
    """Return people of 100 pixels with their heads at x, shoulder to shoulder, in stride."""
    mask = np.zeros((160, 300), np.uint8)
    for x in heads:
        mask[30:46, x - 7 : x + 8] = 1
        mask[46:90, x - 18 : x + 19] = 1
        for step in range(40):
            mask[90 + step, x - 10 - step // 4 : x - step // 4] = 1
            mask[90 + step, x + step // 4 : x + 10 + step // 4] = 1
    return mask


def test_people_in_one_patch_are_divided_between_their_heads() -> None:
    assert len(found(silhouette(100))) == 1  # its legs are none
    pair = sorted(found(silhouette(100, 136)))
    assert [(box.x, box.width) for box in pair] == [(81, 37), (118, 37)]
    assert all(box.y == 30 and box.height == 100 for box in pair)
    three = found(silhouette(100, 136, 172))
    assert sorted(box.width for box in three) == [36, 37, 37]


def test_a_window_does_not_divide_a_car() -> None:
    """Through it one sees the road; the roof above it is two pixels thick."""
    mask = np.zeros((160, 300), np.uint8)
    mask[60:80, 80:150] = 1
    mask[80:110, 60:210] = 1
    mask[62:76, 95:135] = 0
    assert found(mask) == [Box(60, 60, 150, 50)]


def heads() -> NDArray[np.uint8]:
    """Return a mask with one patch of two heads, 40 wide and 60 high, its corner at 30, 20."""
    mask = np.zeros((120, 160), np.uint8)
    mask[40:80, 30:70] = 1
    mask[20:40, 32:44] = mask[20:40, 56:68] = 1
    return mask


@pytest.mark.parametrize(
    ("known", "parts"),
    [
        ([], 2),
        ([Box(30, 20, 40, 60)], 1),  # one object, whose outline has a hollow
        ([Box(30, 20, 18, 60)], 2),  # somebody has come beside the known one
        ([Box(30, 20, 18, 60), Box(52, 20, 18, 60)], 2),
        ([Box(30, 20, 12, 60), Box(42, 20, 14, 60), Box(58, 20, 12, 60)], 3),
        ([Box(30, 20, 18, 60), Box(52, 20, 18, 60), Box(28, 20, 300, 180)], 2),  # not the far one
        ([Box(100, 20, 18, 60)], 2),  # elsewhere
    ],
)
def test_known_objects_decide_whether_a_patch_is_divided(known: list[Box], parts: int) -> None:
    assert len(blobs(heads(), 0.002, known)) == parts


def disc(mask: NDArray[np.uint8], x: float, y: float, radius: float = 12.0) -> None:
    """Draw a disc into a mask."""
    rows, columns = np.indices(mask.shape)
    mask[np.hypot(columns + 0.5 - x, rows + 0.5 - y) <= radius] = 1


def test_a_patch_is_shared_by_the_objects_that_are_known_in_it() -> None:
    """Their places are off by a few pixels, as predicted ones are; another one is not there."""
    mask = np.zeros((120, 160), np.uint8)
    disc(mask, 60, 50)
    disc(mask, 78, 62)
    near = [Box(52, 34, 24, 24), Box(61, 53, 24, 24)]
    for known in (near, [*near, Box(120, 20, 24, 24)]):
        first, second = sorted(blobs(mask, 0.002, known))
        np.testing.assert_allclose(first, (48, 38, 24, 24), atol=1.5)
        np.testing.assert_allclose(second, (66, 50, 24, 24), atol=1.5)


def test_who_is_not_seen_in_a_patch_gets_no_share_of_it() -> None:
    mask = np.zeros((120, 160), np.uint8)
    disc(mask, 60, 50)
    disc(mask, 78, 62)
    mask[:, 71:] = 0  # the other one has gone behind something
    assert blobs(mask, 0.002, [Box(48, 38, 24, 24), Box(60, 50, 24, 24)]) == [Box(48, 38, 23, 31)]


def test_who_is_not_there_gets_no_share_though_the_patch_lies_around() -> None:
    """An L, whose empty corner holds the box of a known object; its foot is nearest to it."""
    mask = np.zeros((120, 160), np.uint8)
    mask[20:80, 40:60] = mask[74:80, 40:100] = 1
    assert blobs(mask, 0.002, [Box(40, 20, 20, 60), Box(70, 32, 24, 40)]) == [Box(40, 20, 60, 60)]


def test_a_part_of_a_shared_patch_that_is_too_small_is_left_out() -> None:
    mask = np.zeros((120, 160), np.uint8)
    disc(mask, 60, 50)
    mask[44:54, 70:90] = 1
    known = [Box(48, 38, 24, 24), Box(72, 44, 18, 10)]
    assert len(blobs(mask, 0.002, known)) == 2
    assert len(blobs(mask, 0.012, known)) == 1


WHOLE = Box(100, 50, 20, 10)
HALVES = np.array([[100.0, 50, 10, 10], [110, 50, 10, 10]])


@pytest.mark.parametrize(("off", "left"), [(0.0, 0.0), (1.0, 0.5), (-1.0, 0.0), (4.0, 2.5)])
def test_who_shares_a_patch_is_found_near_where_he_should_be(off: float, left: float) -> None:
    """Both fill it; a center is at most 0.3 half sides, here 1.5, from its place.

    One column lies as near to the one as to the other where half a pixel is left.
    """
    boxes, _ = shared(np.ones((10, 20), np.bool_), WHOLE, HALVES + np.array([off, 0, 0, 0]))
    np.testing.assert_allclose(boxes, HALVES + np.array([left, 0, 0, 0]), atol=0.01)


def test_pixels_far_from_all_who_share_a_patch_are_nobodys() -> None:
    """Up to twice the half sides of a box are shared: here ten pixels from its center."""
    boxes, seen = shared(np.ones((1, 90), np.bool_), Box(0, 0, 90, 1), np.array([[40.0, 0, 10, 1]]))
    np.testing.assert_allclose(boxes, [[40, 0, 10, 1]])
    assert seen.tolist() == [20]


def test_who_shares_no_pixel_of_a_patch_stays() -> None:
    gone = np.array([[200.0, 50, 10, 10]])
    boxes, seen = shared(np.ones((10, 20), np.bool_), WHOLE, np.vstack([HALVES, gone]))
    np.testing.assert_allclose(boxes, np.vstack([HALVES, gone]))
    assert seen.tolist() == [100, 100, 0]


def test_some_pixels_of_a_large_patch_tell_how_it_is_shared() -> None:
    """They lie all over it, also where its width is a multiple of the step from one to the next."""
    whole = Box(2000, 1000, 400, 200)
    boxes, seen = shared(np.ones((200, 400), np.bool_), whole, 20 * HALVES)
    np.testing.assert_allclose(boxes, 20 * HALVES, atol=2)
    np.testing.assert_allclose(seen, 40_000, rtol=0.02)


def test_two_alike_who_touch_and_turn_round_keep_their_identities() -> None:
    """Paths alone would have them pass each other."""
    rng = np.random.default_rng(0)
    scene, ends = Scene(BackgroundDetector(BackgroundConfig(preview=0.0))), []
    for index in range(130):
        pixels = rng.integers(195, 206, (200, 120, 3)).astype(np.uint8)
        apart = abs(index - 65) * 1.5 + 8  # half of their distance: they touch, and go back
        if index:
            mask = np.zeros(pixels.shape[:2], np.uint8)
            disc(mask, 60, 100 - apart)
            disc(mask, 60, 100 + apart)
            pixels[mask > 0] = 40
        tracks = scene.update(Frame(index, index / 25, pixels))
        if index in (30, 100):
            ends.append([each.identity for each in sorted(tracks, key=lambda t: t.ellipse.y)])
    assert len(ends[0]) == 2
    assert ends[0] == ends[1]


GONE = Box(100, 30, 16, 30)


def painted(ground: NDArray[np.uint8], box: Box) -> NDArray[np.uint8]:
    """Return a picture with a bright box on it."""
    out = ground.copy()
    x, y, width, height = map(int, box)
    out[y : y + height, x : x + width] = (220, 200, 60)
    return out


def ground(seed: int = 0) -> NDArray[np.uint8]:
    return np.random.default_rng(seed).integers(95, 106, (120, 160, 3)).astype(np.uint8)


def green(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    return np.ascontiguousarray(pixels[:, :, 1])


def test_a_patch_that_fills_the_picture_has_no_outline_and_stays() -> None:
    all_of_it = Box(0, 0, 160, 120)
    mask = np.ones((120, 160), np.uint8)
    assert without_ghosts([all_of_it], mask, ground(), green(ground(1))) == [all_of_it]


def test_who_walks_off_leaves_no_ghost(monkeypatch: pytest.MonkeyPatch) -> None:
    """Somebody is in the first frame, which makes the background, and leaves from frame 3 on."""
    for share, left in ((0.5, 0), (0.0, 1)):
        monkeypatch.setattr(foreground, "GHOST", share)
        detector = BackgroundDetector()
        for index in range(7):
            place = GONE._replace(x=100.0 - 8 * max(0, index - 3))
            found = detector(Frame(index, index / 25, painted(ground(index), place)))
        boxes = [each.box for each in found]
        assert sum(iou(box, place) > 0.8 for box in boxes) == 1
        assert sum(abs(box.x - GONE.x) <= 2 for box in boxes) == left


@pytest.mark.parametrize("gone", [False, True])
def test_the_edges_of_the_ground_in_a_patch_are_no_outline(*, gone: bool) -> None:
    """A gray object before a table: its patch has holes and cuts where the table's edges are."""
    floor = np.full((120, 160), 100, np.uint8)
    floor[50:52], floor[:, 60:64] = 250, 20
    mask = np.zeros_like(floor)
    mask[30:90, 40:80] = 1
    mask[49:53], mask[60:80, 59:65] = 0, 0
    before = floor.copy()
    before[30:90, 40:80] = 110
    now, learned = (floor, before) if gone else (before, floor)
    patch = Box(40, 30, 40, 60)
    picture = np.repeat(now[:, :, None], 3, axis=2)
    assert without_ghosts([patch], mask, picture, learned) == [patch] * (not gone)


Picture = NDArray[np.uint8]
PATCH = slice(20, 60), slice(30, 70)


def wall() -> Picture:
    """Return a wall of colored bricks with a bright lintel."""
    pixels = np.full((80, 100, 3), (150, 110, 90), np.uint8)
    pixels[::10] = (180, 170, 160)
    pixels[:, ::20] = (180, 170, 160)
    return pixels


def kept(pixels: Picture, shadow: float = 0.5, highlight: float = 1.25) -> float:
    """Return the share of the patch that counts as an object."""
    mask = np.zeros((80, 100), np.uint8)
    mask[PATCH] = 1
    limits = LightLimits(shadow, highlight, tint=12, texture=6)
    left = without_light(mask, planes_of(pixels), Background(planes_of(wall()), 4.0), limits)
    return float(left[PATCH].mean())


def scaled(factor: float) -> Picture:
    pixels = wall()
    pixels[PATCH] = np.rint(factor * pixels[PATCH])
    return pixels


@pytest.mark.parametrize("factor", [0.6, 0.8, 1.15])
def test_light_that_leaves_the_edges_is_no_object(factor: float) -> None:
    assert kept(scaled(factor)) < 0.2
    assert kept(scaled(factor), 1, 1) == 1  # none is removed


@pytest.mark.parametrize("factor", [0.3, 1.6])
def test_more_than_light_is_an_object(factor: float) -> None:
    assert kept(scaled(factor)) > 0.9


def test_an_object_of_the_walls_mean_color_has_other_edges() -> None:
    """A coat as bright as the wall in the shade, with folds in place of bricks."""
    pixels = wall()
    pixels[PATCH] = (105, 77, 63)
    pixels[20:60, 30:70:4] = (135, 99, 81)
    assert kept(pixels) > 0.5


def test_a_tremble_of_a_pixel_is_no_foreground() -> None:
    background = Background(planes_of(wall()), 4.0)
    everywhere = np.ones((80, 100), np.uint8)
    shaken = np.roll(wall(), (1, 1), axis=(0, 1))
    assert without_tremble(everywhere, planes_of(shaken), background).sum() == 0
    shaken[30:40, 40:50] = 20
    assert without_tremble(everywhere, planes_of(shaken), background).sum() == 100


@pytest.mark.parametrize("prepared", [True, False])
def test_a_camera_that_sways_shows_what_moves_alone(prepared: bool) -> None:
    """Without that, each edge of the ground is foreground."""
    rng, detector = np.random.default_rng(0), BackgroundDetector()
    ground = np.kron(rng.integers(40, 200, (20, 26, 3)), np.ones((8, 8, 1))).astype(np.uint8)

    def swaying(index: int) -> tuple[Frame, Box]:
        x, y = round(4 * np.sin(index / 6)), round(3 * np.sin(index / 9))
        scene = ground.copy()
        left = 24 + 2 * (index - 40)
        if index >= 40:
            scene[60:100, left : left + 20] = (250, 20, 250)
        pixels = scene[16 - y : 136 - y, 16 - x : 176 - x]
        noisy = (pixels + rng.normal(0, 2, pixels.shape)).clip(0, 255).astype(np.uint8)
        return Frame(index, index / 25, noisy), Box(left - 16 + x, 44 + y, 20, 40)

    if prepared:
        detector.prepare(swaying(index)[0] for index in range(90))
    for index in range(90):
        frame, box = swaying(index)
        found = detector(frame)
        assert len(found) == (index >= 40)
        assert all(iou(each.box, box) > 0.85 for each in found)
    assert detector.warnings == {}


@pytest.mark.parametrize("gain", [0.75, 1.35])
def test_a_camera_that_sways_and_gets_darker_or_brighter_shows_nothing(gain: float) -> None:
    """Nor does the border of the background, which a shifted picture does not show."""
    rng, detector = np.random.default_rng(0), BackgroundDetector()
    ground = np.kron(rng.integers(60, 160, (20, 26, 3)), np.ones((8, 8, 1)))
    for index in range(90):
        x, y = round(4 * np.sin(index / 6)), round(3 * np.sin(index / 9))
        lit = np.interp(index, (30, 80), (1, gain)) * ground[16 - y : 136 - y, 16 - x : 176 - x]
        noisy = (lit + rng.normal(0, 2, lit.shape)).clip(0, 255).astype(np.uint8)
        assert detector(Frame(index, index / 25, noisy)) == []
    assert detector.warnings == {}


@pytest.mark.slow
def test_a_camera_that_pans_after_a_rest_is_noticed_and_shows_nothing() -> None:
    """It pans so slowly that it seems to sway first."""
    rng, detector = np.random.default_rng(0), BackgroundDetector()
    ground = np.kron(rng.integers(60, 160, (30, 60, 3)), np.ones((8, 8, 1)))
    for index in range(100):
        left = max(0, index - 30)
        noisy = ground[:, left : left + 320] + rng.normal(0, 2, (240, 320, 3))
        assert detector(Frame(index, index / 25, noisy.clip(0, 255).astype(np.uint8))) == []
    assert "Frame 39: the camera moves" in detector.warnings["camera"]


def test_a_sway_is_found_in_whole_pixels() -> None:
    rng = np.random.default_rng(0)
    ground = rng.integers(0, 256, (120, 160, 3)).astype(np.uint8)
    sway = Sway()
    sway.refer(ground[:, :, 1])
    for shift, found in [((0, 0), (0, 0)), ((7, -8), (7, -8)), ((-20, 0), (7, -8))]:
        sway.find(np.roll(ground, shift, axis=(1, 0)), FARTHEST)
        assert sway.shift == found
    steady = moved(np.roll(ground, (7, -8), axis=(1, 0)), (7, -8), np.zeros_like(ground))
    assert (steady[8:, :-7] == ground[8:, :-7]).all()
    assert not steady[:8].any()
    assert not steady[:, -7:].any()


@pytest.mark.parametrize("gain", [0.5, 1.6])
def test_another_exposure_is_no_sway(gain: float) -> None:
    rng, sway = np.random.default_rng(0), Sway()
    ground = np.kron(rng.integers(40, 150, (30, 40, 3)), np.ones((4, 4, 1))).astype(np.uint8)
    sway.refer(ground[:, :, 1])
    for shift in ((0, 0), (2, -1)):
        sway.find((gain * np.roll(ground, shift, axis=(1, 0))).astype(np.uint8))
        assert sway.shift == shift


def test_a_large_picture_tells_its_sway_by_as_few_pixels() -> None:
    """Else it would take a tenth of a second."""
    ground = np.random.default_rng(0).integers(0, 256, (1200, 1600, 3)).astype(np.uint8)
    sway = Sway()
    sway.refer(ground[:, :, 1])
    sway.find(np.roll(ground, (2, -1), axis=(1, 0)))
    assert sway.shift == (2, -1)
    assert FEWEST < sway._edges.shape[1] <= 2 * BLOCKS


@pytest.mark.parametrize("size", [(120, 160), (12, 160), (30, 20)])
def test_a_ground_with_few_edges_tells_no_sway(size: tuple[int, int]) -> None:
    sway, even = Sway(), np.full((*size, 3), 90, np.uint8)
    sway.refer(even[:, :, 1])
    sway.find(even + np.uint8(40), FARTHEST)
    assert sway.shift == (0, 0)


def test_what_an_outline_encloses_is_no_shadow() -> None:
    mask, before = np.zeros((2, 40, 40), np.uint8)
    before[10:30, 10:25] = before[25:30, 25:38] = 1  # an object with a shadow beside it
    mask[10:30, 10:25] = 1
    mask[12:28, 12:23] = 0
    mask[18:20, 10:12] = 0  # a gap in its outline
    filled = with_enclosed(mask, before)
    assert filled[12:28, 12:23].all()
    assert not filled[:, 25:].any()
    open_side = mask.copy()
    open_side[12:28, 23:25] = 0
    assert not with_enclosed(open_side, before)[14:26, 14:21].any()


SIZE = 14, 30


def frame(index: int, x: int | None, rate: float = 5.0) -> Frame:
    """Return a gray ground with an object at x, if any."""
    rng = np.random.default_rng(index)
    pixels = rng.integers(95, 106, (80, 160, 3)).astype(np.uint8)
    if x is not None:
        pixels[30:60, x : x + SIZE[0]] = (220, 60, 200)
    return Frame(index, index / rate, pixels)


def test_the_picture_to_learn_by_hand() -> None:
    before, now = np.full((3, 9, 9), 10, np.uint8), np.full((3, 9, 9), 50, np.uint8)
    update = SelectiveUpdate(before, 0.0, trial=1.0, patience=3.0)
    mask = np.zeros((9, 9), np.uint8)
    mask[0, 0] = mask[0, 8] = 1
    known = [Box(4.6, -2, 9, 9)]
    for time, left, right in ((0.5, 10, 10), (1.5, 50, 10), (2.5, 50, 10), (3.5, 50, 50)):
        learned = update.learned_from(now, mask, time, known)
        assert (learned[0, 0, 0], learned[0, 0, 8], learned[0, 8, 4]) == (left, right, 50), time


class Listener:
    """A detector that notes what it is told."""

    def __init__(self) -> None:
        self.told: list[Sequence[Box]] = []

    def observe(self, moved: Sequence[Box]) -> None:
        """Note it."""
        self.told.append(moved)

    def __call__(self, frame: Frame) -> list[Detection]:
        """Return a walker."""
        return [Detection(Box(20 + 4 * frame.index, 30, *SIZE))]


def test_a_detector_learns_some_frames_later_where_what_has_moved_is() -> None:
    pictures = [frame(index, 20 + 4 * index) for index in range(12)]
    lists = []
    for ahead in (True, False):
        listener = Listener()
        scene = Scene(listener)
        tracks = [found for _, found in scene.watch(pictures, ahead=ahead)]
        lists.append(listener.told)
    assert lists[0] == lists[1]  # whatever the threads do
    first = next(n for n, boxes in enumerate(listener.told) if boxes)
    (box,) = listener.told[first]
    np.testing.assert_allclose(box, tracks[first][0].box)  # as it goes evenly
    assert first - LAG == 3  # 12 pixels on from its first detection


def test_a_prepared_detector_finds_who_is_in_the_first_frame(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Frames of another size, which a camera may send later, end the preview.

    The film is read from a later time on, as with --start.
    """
    monkeypatch.setattr(foreground, "GHOST", 0.0)
    film = [frame(index, 20 + 3 * (index - 500)) for index in range(500, 540)]
    for prepared in (True, False):
        detector = BackgroundDetector()
        if prepared:
            other = Frame(540, 108.0, np.zeros((40, 160, 3), np.uint8))
            detector.prepare(iter([*film, other]))
        first = [each.box for each in detector(film[0])]
        later = [each.box for each in [*map(detector, film[1:12])][-1]]
        assert len(first) == prepared
        assert len(later) == 1 + (not prepared)  # and leaves no ghost


def test_a_detector_that_is_not_prepared_learns_the_usual_colors_by_and_by(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Who stands in the first frame leaves a ghost, until it is seen that the place is free."""
    monkeypatch.setattr(foreground, "GHOST", 0.0)
    film = [frame(index, 20 + 3 * index) for index in range(36)]
    counts = {}
    for preview in (0.0, 2.9, 30.0):  # the sixteenth frame, of which it is told, is at 3 s
        detector = BackgroundDetector(BackgroundConfig(preview=preview))
        counts[preview] = [len(detector(picture)) for picture in film]
    assert counts[0.0][12:] == counts[2.9][12:] == [2] * 24
    assert counts[30.0][12:15] == [2] * 3
    assert counts[30.0][15:] == [1] * 21


def test_after_another_light_the_usual_colors_are_learned_anew(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(foreground, "GHOST", 0.0)
    film = [frame(index, 3 * index) for index in range(45)]
    for picture in film[8:]:
        picture.pixels[:] //= 3
    detector = BackgroundDetector()
    detector.prepare(film[:8])
    counts = [len(detector(picture)) for picture in film]
    assert "light" in detector.warnings
    assert counts[20] == 2
    assert counts[25:] == [1] * 20


def test_patience_has_an_end() -> None:
    config = BackgroundConfig(history=20, trial=1, patience=8)
    scene = Scene(BackgroundDetector(config))
    for index in range(105):
        scene.update(frame(index, None if index < 5 else min(20 + 4 * (index - 5), 80)))
    assert scene.detector(frame(105, 80)) == []
