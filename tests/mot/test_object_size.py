"""How large objects are at each place, and what that says about patches."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motes.core.geometry import Box
from motes.mot.detection.blobs import Blob, blobs
from motes.mot.detection.object_size import ObjectSizes

WIDTH, HEIGHT = 320, 240


def car(x: float, foot: float) -> Box:
    """Return the box of a car whose foot is at a place: the horizon is at 20."""
    width = 0.3 * (foot - 20)
    return Box(x - width / 2, foot - 0.8 * width, width, 0.8 * width)


def taught(wrong: int = 0) -> ObjectSizes:
    """Return the sizes of a road on which cars have gone, some of which were two in one box."""
    rng = np.random.default_rng(0)
    boxes = [car(*place) for place in rng.uniform((60, 80), (260, 220), (60, 2))]
    for n in range(wrong):
        x, y, width, height = boxes[n]
        boxes[n] = Box(x - width / 2, y - height, 2 * width, 2 * height)
    sizes = ObjectSizes()
    sizes.learn(boxes, [0.9] * len(boxes))
    return sizes


def drawn(*boxes: Box) -> NDArray[np.uint8]:
    """Return a mask in which boxes are foreground."""
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    for x, y, width, height in boxes:
        mask[round(y) : round(y + height), round(x) : round(x + width)] = 1
    return mask


def found(mask: NDArray[np.uint8], sizes: ObjectSizes | None) -> list[Blob]:
    return blobs(mask, speck=3, gap=(0.01, 0.002), least=0.002, valley=0.1, narrow=0.1, sizes=sizes)


@pytest.mark.parametrize("wrong", [0, 20])
def test_sizes_grow_from_the_horizon_and_some_wrong_ones_do_not_matter(wrong: int) -> None:
    sizes, feet = taught(wrong), np.array([[100.0, 100], [200, 200]])
    usual, spreads = sizes.at(feet)
    want = [car(*foot)[2:] for foot in feet.tolist()]
    np.testing.assert_allclose(usual, want, rtol=0.1)
    assert (spreads < 0.2).all()
    assert (sizes.largest(feet) > usual).all()


def test_what_was_not_seen_is_not_known() -> None:
    sizes = ObjectSizes()
    assert not sizes.known
    assert np.isinf(sizes.largest(np.array([[100.0, 100]]))).all()
    sizes.learn([car(100, 100)] * 50, [0.9] * 50)  # one car that stands
    assert not sizes.known
    assert np.isinf(taught().largest(np.array([[100.0, 10]]))).all()  # above the horizon


def test_parts_within_the_size_of_one_are_one() -> None:
    """A dark car of which the hood and the roof are seen; and two cars behind each other."""
    x, y, width, height = car(150, 160)
    hood = Box(x, y + 0.7 * height, width, 0.3 * height)
    roof = Box(x + 0.2 * width, y, 0.6 * width, 0.35 * height)
    assert len(found(drawn(hood, roof), None)) == 2
    (one,) = found(drawn(hood, roof), taught())
    np.testing.assert_allclose(one.box, (x, y, width, height), atol=1.5)
    assert len(found(drawn(car(150, 120), car(150, 160)), taught())) == 2


def test_a_notch_in_a_roof_divides_no_car() -> None:
    mask = drawn(one := car(150, 160))
    mask[round(one.y) : round(one.y) + 8, 145:155] = 0
    assert len(found(mask, None)) == 2
    assert len(found(mask, taught())) == 1


def test_cars_abreast_are_two() -> None:
    one, other = car(120, 160), car(120 + car(120, 160).width - 3, 160)
    assert len(found(drawn(one, other), None)) == 1
    boxes = sorted(each.box for each in found(drawn(one, other), taught()))
    np.testing.assert_allclose(boxes, [one, other], atol=4)


def test_a_truck_is_one() -> None:
    foot = car(150, 200)
    truck = Box(foot.x - 5, foot.y - 70, foot.width + 10, foot.height + 70)
    assert len(found(drawn(truck), taught())) == 1


def test_who_is_hidden_is_not_told_from_the_upper_part_of_a_truck() -> None:
    """The scene, which has seen both before, divides their patch."""
    assert len(found(drawn(car(150, 200), car(152, 170)), taught())) == 1
