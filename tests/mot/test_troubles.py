"""What a scene makes of pictures that are no good: it says so once, and invents few objects."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from motes import Frame, Scene
from motes.mot.detection.background import BackgroundDetector
from motes.mot.detection.exposure import Exposure
from motes.mot.detection.reference_image import LASTS, ReferenceImage
from motes.mot.detection.sway import FARTHEST
from motes.mot.scene_config import DetectionSelection, scene_config
from motes.synthetic.scenery import noise, to_bytes

Picture = NDArray[np.uint8]
Floats = NDArray[np.floating[Any]]
WIDTH, HEIGHT = 200, 120
CHANGE = 50
"""In this frame it happens."""


def ground(seed: int, width: int = WIDTH) -> Picture:
    """Return a smooth ground with many shades and colors."""
    rng = np.random.default_rng(seed)
    shades = 110 + 35 * noise(rng, width, HEIGHT, 24)[:, :, None]
    return to_bytes(shades + 20 * np.stack([noise(rng, width, HEIGHT, 40) for _ in "rgb"], 2))


def walked(picture: Picture, index: int) -> Picture:
    """Return a picture with two in it who walk past each other, from frame 20 on."""
    out, way = picture.copy(), 3 * (index - 20)
    for x, y, color in ((way, 40, (220, 60, 60)), (192 - way, 75, (60, 60, 220))):
        if index >= 20:
            out[y : y + 30, max(x, 0) : max(x + 16, 0)] = color
    return out


def film(picture: Callable[[int], Picture | Floats], frames: int) -> Iterator[Frame]:
    """Yield pictures with a camera's noise."""
    rng = np.random.default_rng(3)
    for index in range(frames):
        noisy: Floats = picture(index) + rng.normal(0, 2, (HEIGHT, WIDTH, 3))
        yield Frame(index, index / 25, noisy.clip(0, 255).astype(np.uint8))


def watched(picture: Callable[[int], Picture | Floats], frames: int) -> Scene:
    """Return a scene that has seen a film."""
    scene = Scene(BackgroundDetector())
    for _ in scene.watch(film(picture, frames)):
        pass
    return scene


@pytest.mark.slow
def test_a_sudden_light_makes_no_crowd() -> None:
    """The two who are there look like others, and where they stood, ghosts may be left."""
    empty, gain = ground(0), 1.6
    scene = watched(lambda i: walked(empty, i) * (gain if i >= CHANGE else 1.0), 80)
    assert 2 <= scene.created <= 6
    assert list(scene.warnings) == ["light"]
    assert scene.warnings["light"].startswith(f"Frame {CHANGE}: ")


@pytest.mark.slow
def test_an_exposure_loses_nobody() -> None:
    empty, gain = ground(0), 0.75
    scene = watched(lambda i: walked(empty, i) * (gain if i >= CHANGE else 1.0), 75)
    assert (scene.created, scene.terminated, scene.warnings) == (2, 0, {})


def test_a_curve_is_read_off_what_is_not_covered() -> None:
    """Somebody in black covers all that is dark, and the camera brightens the rest."""
    usual = np.random.default_rng(3).integers(40, 230, (240, 320, 3)).astype(np.uint8)
    seen = 255 * (usual / 255) ** 0.8
    seen[usual.mean(axis=2) < 100] = 2
    curves = Exposure(usual).curves(seen.astype(np.uint8))
    assert curves is not None
    values = np.array([90, 150, 210])
    np.testing.assert_allclose(curves[:, values], [255 * (values / 255) ** 1.25] * 3, atol=4)
    assert curves[:, 2].max() < 4


@pytest.mark.parametrize("kind", ["gamma", "contrast"])
def test_a_curve_is_that_of_the_camera(kind: str) -> None:
    values = np.arange(30, 231, 50)
    usual = np.random.default_rng(3).integers(20, 240, (240, 320, 3)).astype(np.uint8)

    def seen(colors: NDArray[np.integer]) -> NDArray[np.uint8]:
        curve = 255 * (colors / 255) ** 0.7 if kind == "gamma" else 50 + 0.75 * colors
        return np.rint(curve).astype(np.uint8)

    curves = Exposure(usual).curves(seen(usual))
    assert curves is not None
    np.testing.assert_allclose(curves[:, seen(values)], [values] * 3, atol=1.5)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["light", "camera"])
def test_what_happens_later_is_not_said_of_the_first_frame(kind: str) -> None:
    """The first background is of the preview, most of which is after the change."""
    wide, detector = ground(0, WIDTH + FARTHEST + 4), BackgroundDetector()
    before, after = wide[:, :WIDTH], ground(7) if kind == "light" else wide[:, FARTHEST + 4 :]
    frames = list(film(lambda index: after if index >= 20 else before, 45))
    detector.prepare(frames)
    for frame in frames:
        detector(frame)
    assert list(detector.warnings) == [kind]
    assert detector.warnings[kind].startswith("Frame 20: ")


@pytest.mark.slow
@pytest.mark.parametrize("speed", [0.5, 12])
def test_a_camera_that_begins_to_move_makes_no_crowd(speed: float) -> None:
    wide = ground(0, WIDTH + 500)

    def picture(index: int) -> Picture:
        x = round(speed * max(0, index - CHANGE))
        return walked(wide[:, x : x + WIDTH], index)

    scene = watched(picture, 90)
    assert 2 <= scene.created <= 4
    told = int(scene.warnings["camera"].split()[1][:-1])
    assert CHANGE < told < CHANGE + 15 + FARTHEST / speed  # until then, it may sway
    assert len(scene.warnings) == 1 + ("light" in scene.warnings)


@pytest.mark.slow
def test_after_a_camera_has_moved_it_must_stand_still() -> None:
    """For ten frames; what it shows until then may be the edges of things that stand."""
    wide, detector = ground(0, WIDTH + 20), BackgroundDetector()

    def picture(index: int) -> Picture:
        x = (FARTHEST + 4) * (index >= CHANGE)
        return walked(wide[:, x : x + WIDTH], index)

    found = [len(detector(frame)) for frame in film(picture, 70)]
    assert found[CHANGE : CHANGE + 11] == [0] * 11
    assert min(found[30:CHANGE]) >= 2
    assert min(found[CHANGE + 11 :]) >= 1


def test_a_step_of_a_few_pixels_hides_nobody() -> None:
    """Such a camera sways, and need not stand still first."""
    wide, detector = ground(0, WIDTH + FARTHEST), BackgroundDetector()

    def picture(index: int) -> Picture:
        x = 3 * (index >= CHANGE)
        return walked(wide[:, x : x + WIDTH], index)

    found = [len(detector(frame)) for frame in film(picture, 70)]
    assert found[30:] == [2] * 40
    assert not detector.warnings


def test_an_anchor_slips_with_the_picture_alone() -> None:
    """Neither by a thing that covers 40 % and moves, nor by light; and again after each slip."""
    wide = ground(2, 2 * WIDTH)
    here, there = wide[:, :WIDTH], wide[:, 1 : WIDTH + 1]
    anchor = ReferenceImage(here)
    assert not anchor.has_moved(here)
    assert not anchor.has_moved((here * 0.7).astype(np.uint8))
    half = here.copy()
    half[:, :80] = there[:, :80]
    assert not anchor.has_moved(half)
    assert anchor.has_moved(there)
    assert not anchor.has_moved(there)
    assert anchor.has_moved(here)


def test_what_a_background_can_follow_is_no_motion() -> None:
    """A quarter of a pixel in as many frames as a reference is used for."""
    here, there = (ground(2, WIDTH + 3)[:, x : x + WIDTH].astype(float) for x in (0, 3))
    anchor = ReferenceImage(here.astype(np.uint8))
    for index in range(12 * LASTS):
        share = index / (12 * LASTS)
        assert not anchor.has_moved(((1 - share) * here + share * there).astype(np.uint8)), index


@pytest.mark.parametrize("gain", [0.75, 1.3])
def test_an_exposure_is_no_motion(gain: float) -> None:
    """Where it grows brighter to one side, as a wall in the sun, a gain looks like a shift."""
    wide = ground(2, 2 * WIDTH) / 3 + np.linspace(30, 200, 2 * WIDTH)[:, None]
    here, there = (wide[:, x : x + WIDTH] for x in (0, 3))
    brighter = (here * gain).clip(0, 255).astype(np.uint8)
    assert not ReferenceImage(here.astype(np.uint8)).has_moved(brighter)
    assert ReferenceImage(brighter).has_moved(there.astype(np.uint8))


@pytest.mark.parametrize("sides", [True, False])
def test_corners_are_no_boxes_and_that_is_said_once(sides: bool) -> None:
    """Two go through the picture, and one of them out of it; as sides, most leave it at once."""
    scene = Scene(lambda frame: [boxed(frame.index * 4 + x, y) for x, y in ((20, 60), (150, 9))])

    def boxed(x: int, y: int) -> tuple[int, ...]:
        return (x, y, x + 20, y + 40) if sides else (x, y, 20, 40)

    for frame in film(lambda index: ground(0), 15):
        scene.update(frame)
    assert list(scene.warnings) == ["corners"] * sides
    if sides:
        assert scene.warnings["corners"].startswith("Frame 9: most boxes so far fit into the pict")


@pytest.mark.parametrize(
    ("least", "score", "said"), [(0.4, 87, True), (0.4, 2.5, False), (40, 87, False)]
)
def test_a_least_score_on_another_scale_is_said(least: float, score: float, said: bool) -> None:
    config = replace(scene_config(), detections=DetectionSelection(least=least))
    scene = Scene(lambda frame: [(20, 20, 20, 20, score)], config)
    scene.update(next(film(lambda index: ground(0), 1)))
    assert list(scene.warnings) == ["scale"] * said
