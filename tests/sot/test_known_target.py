"""Known targets and the places where they may appear."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from motes import ConfigError, Ellipse, FormatError, Frame, KnownTarget, Place, load_places
from motes.cues.color import Color
from oracles import region, scene

FRAME = scene(0, (40, 30))


def target() -> KnownTarget:
    return KnownTarget.learn(Color(space="hsv", bins=(8, 8, 4)), FRAME, region((40, 30)))


def test_a_target_survives_its_file(tmp_path: Path) -> None:
    path = tmp_path / "target.json"
    first = target()
    first.save(path)
    again = KnownTarget.load(path)
    assert again.color == first.color
    assert again.size == first.size == Ellipse(0, 0, 10, 7)
    np.testing.assert_allclose(again.model.histogram, first.model.histogram, rtol=1e-12)
    np.testing.assert_array_equal(again.model.histogram, again.model.anchor)
    values = json.loads(path.read_text())
    assert list(values) == ["type", "a", "b", "theta", "cue", "bins"]
    assert sum(share for _, share in values["bins"]) == pytest.approx(1)


NONE = r"target.json is not a histogram file .*KnownTarget.save"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"bins": []}, "at least one"),
        ({"bins": [[-1, 0.5]]}, "bins must be 0 to 255"),
        ({"bins": [[0, 0.0]]}, NONE),
        ({"bins": [[0, 1.5]]}, NONE),
        ({"a": -3}, NONE),
        ({"cue": {"type": "smell"}}, NONE),
        ({"type": "motes_track"}, NONE),
        ({"extra": 1}, NONE),
        ({"others": {"edges": {}}}, "is not a histogram file .*no key 'others'"),
        *((text, NONE) for text in ("", "{", "[]", "\xff\xfe", '"text"', "null", "[" * 100_000)),
    ],
)
def test_files_that_are_no_targets(tmp_path: Path, content: Any, message: str) -> None:
    """Values in place of those of a target, or another text."""
    path = tmp_path / "target.json"
    target().save(path)
    if isinstance(content, dict):
        content = json.dumps(json.loads(path.read_text()) | content)
    path.write_text(content, encoding="latin-1")
    with pytest.raises(FormatError, match=message) as error:
        KnownTarget.load(path)
    assert "\n" not in str(error.value)


def covered(boxes: Any, shape: tuple[int, int]) -> Any:
    counts = np.zeros(shape, int)
    for x, y, w, h in np.asarray(boxes, int):
        counts[y : y + h, x : x + w] += 1
    return counts


@given(st.integers(1, 15))
def test_a_border_covers_the_edge_once(width: int) -> None:
    picture = Frame(0, 0.0, np.zeros((32, 40, 3), np.uint8))
    counts = covered(Place(border=width).boxes(picture), (32, 40))
    expected = np.ones((32, 40), int)
    expected[width:-width, width:-width] = 0
    np.testing.assert_array_equal(counts, expected)


@pytest.mark.parametrize(
    ("box", "inside"), [((5, 6, 7, 8), (5, 6, 7, 8)), ((-9, -9, 900, 900), (0, 0, 40, 32))]
)
def test_a_door_is_cut_to_the_frame(box: Any, inside: Any) -> None:
    picture = Frame(0, 0.0, np.zeros((32, 40, 3), np.uint8))
    assert Place(box=box).boxes(picture) == [inside]


@pytest.mark.parametrize(
    ("place", "message"),
    [
        (Place(name="door", box=(40, 0, 5, 5)), "Place 'door' lies outside the frame of 40x32"),
        (Place(name="door", box=(-5, 0, 5, 5)), "lies outside"),
        (Place(box=(39.5, 0, 9, 9)), "outside the frame"),
        (Place(name="edge", border=16), "a border of 16 fills the frame 40x32"),
        (Place(name="both", box=(0, 0, 5, 5), border=3), "needs either"),
        (Place(name="none"), "needs either"),
    ],
)
def test_places_that_do_not_fit(place: Place, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        place.boxes(Frame(0, 0.0, np.zeros((32, 40, 3), np.uint8)))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "place"),
        ("place = []", "names no place"),
        ("[[place]]\nbx = [1, 2, 3, 4]", "did you mean 'box'"),
        ("[[place]]\nbox = [1, 2, 3]", r"place\[0\].box"),
        ("[[place]]\nbox = [1, 2, -3, 4]", r"place\[0\].box"),
        ("[[place]]\nbox = [nan, 2, 3, 4]", "finite number"),
        ("[[place]]\nbox = [1, 2, inf, 4]", "finite number"),
        ("[[place]]\nbox = [0, 0, 0.9, 0.9]", r"box\[2\]: got .*; it takes number, at least 1"),
        ("[[place]]\nborder = 0", r"place\[0\].border"),
        ("[[place", "is not valid TOML"),
    ],
)
def test_toml_that_makes_no_sense(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "places.toml"
    path.write_text(text, encoding="latin-1")
    with pytest.raises(ConfigError, match=message):
        load_places(path)
