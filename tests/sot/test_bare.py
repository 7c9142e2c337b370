"""Whether a region holds anything to follow, and who is told."""

import numpy as np
import pytest

from motes import Ellipse, Frame, Tracker, synthetic
from motes.core.types import Floats
from motes.sot.bare import bare_note, cut_note
from textured import blocks

BOX = 140, 100, 40, 30
MIDDLE = 160, 115


def wall(noise: float = 2.0, light: float = 0.2) -> Floats:
    """Return the gray levels of a wall that is lit from one side."""
    grain = np.random.default_rng(1).normal(0, noise, (240, 320))
    lit: Floats = 100 + light * np.arange(320) + grain
    return lit


def blob(levels: float, side: float) -> Floats:
    """Return the levels of a spot in the middle of `BOX`."""
    y, x = np.mgrid[:240, :320]
    far = np.hypot(x - MIDDLE[0], y - MIDDLE[1]) / (side / 4)
    lit: Floats = levels * np.exp(-(far**2) / 2)
    return lit


def frame(gray: Floats) -> Frame:
    return Frame(0, 0.0, np.clip(np.rint(gray), 0, 255).astype(np.uint8))


def waves(levels: float) -> Floats:
    """Return the levels of a cloth of waves, the same everywhere."""
    y, x = np.mgrid[:240, :320]
    lit: Floats = levels * np.sin(x / 7) * np.sin(y / 5)
    return lit


def stripes() -> Floats:
    """Return an edge that goes through the middle of `BOX`, with nothing on it."""
    return np.where(np.arange(320) < 160, 60.0, 200.0) + wall(1.0, 0.0) - 100


TEXTURE: Floats = blocks(1, 240, 320, 7, (60, 60, 60), (190, 190, 190))[..., 0].astype(float)


@pytest.mark.parametrize(
    ("gray", "bare"),
    [
        pytest.param(np.full((240, 320), 90.0), True, id="one color"),
        pytest.param(wall(), True, id="wall"),
        pytest.param(wall(6.0), True, id="grain"),
        pytest.param(stripes(), True, id="edge"),
        pytest.param(wall(0.5) + waves(9), True, id="faint cloth"),
        pytest.param(wall(0.5) + waves(16), False, id="cloth"),
        pytest.param(wall() + blob(10, 30), False, id="faint"),
        pytest.param(wall(0.5) + blob(6, 12), False, id="fainter and smaller"),
        pytest.param(TEXTURE, False, id="texture"),
    ],
)
def test_bare_regions(gray: Floats, bare: bool) -> None:
    assert (bare_note(frame(gray), Ellipse.from_box(BOX)) is not None) == bare


@pytest.mark.parametrize(
    ("region", "bare", "other"),
    [
        (Ellipse.from_box(BOX)._replace(theta=0.7), wall(), wall() + blob(10, 30)),
        (Ellipse(*MIDDLE, 6, 6), wall(), wall() + blob(20, 12)),
        (Ellipse(5, 5, 20, 15), wall(light=0.0), TEXTURE),
        (Ellipse(319.5, 239.4, 20, 15), wall(light=0.0), TEXTURE),
    ],
    ids=["turned", "small", "in a corner", "half outside"],
)
def test_other_regions(region: Ellipse, bare: Floats, other: Floats) -> None:
    assert bare_note(frame(bare), region)
    assert bare_note(frame(other), region) is None


def test_targets_of_films_are_not_bare() -> None:
    for film in (synthetic.demo((320, 240), frames=1), synthetic.Pitch()):
        picture, truths = film[0]
        seen = [truth.ellipse for truth in truths if truth.visible > 0.5]
        assert [bare_note(picture, ellipse) for ellipse in seen] == [None] * len(seen)


def test_library_warns(caplog: pytest.LogCaptureFixture) -> None:
    tracker = Tracker()
    tracker.init(frame(wall()), BOX)
    (said,) = caplog.records
    assert said.getMessage() == tracker.info.note
    assert (said.name, said.levelname) == ("motes", "WARNING")
    assert "x=140, y=100, 40x30 in frame 0" in said.getMessage()
    caplog.clear()
    tracker.update(Frame(1, 0.04, frame(wall()).pixels))
    other = Tracker()
    other.init(frame(wall() + blob(60, 40)), BOX)
    assert not any(each.info.note for each in (tracker, other))
    assert not caplog.records


@pytest.mark.parametrize(("x", "cut"), [(-5, True), (0, True), (2, False), (60, True)])
def test_a_region_at_the_border_may_be_cut(x: int, cut: bool) -> None:
    picture = frame(np.random.default_rng(0).integers(0, 256, (80, 80)).astype(float))
    region = Ellipse.from_box((x, 30, 20, 20))
    assert (cut_note(picture, region) is not None) == cut
    tracker = Tracker("nummiaro")
    tracker.init(picture, region)
    assert ("border" in (tracker.info.note or "")) == cut
