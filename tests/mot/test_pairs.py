"""Boxes that meet, and one-to-one assignment of few pairs, against all pairs; and how they grow."""

import numpy as np
import pytest

from motes.core.geometry import Box, Ellipse
from motes.core.types import Floats
from motes.mot import association, overlaps, pairs
from motes.mot.association import PART, assign, assign_pairs, near
from motes.mot.overlaps import inscribed, intersection_over_first, without_duplicates
from motes.mot.pairs import candidates, meeting


def boxes_like(kind: str, rng: np.random.Generator, n: int) -> Floats:
    """Return boxes (n, 4) of sizes from alike to very different, some where others are."""
    places = rng.uniform(-50, 200, (n, 2))
    sizes = {
        "alike": rng.uniform(15, 25, (n, 2)),
        "any": np.exp(rng.uniform(0, 6, (n, 2))),
        "flat": np.stack([rng.uniform(50, 300, n), rng.uniform(1, 3, n)], axis=1),
        "whole": rng.integers(0, 30, (n, 2)).astype(float),  # edges touch, some have no area
    }[kind]
    return np.hstack([np.rint(places) if kind == "whole" else places, sizes])


def test_ellipses_in_boxes_are_those_of_each() -> None:
    boxes = boxes_like("any", np.random.default_rng(0), 9)
    each = [Ellipse.from_box(Box(*box)) for box in boxes]
    np.testing.assert_array_equal(inscribed(boxes), each)
    assert inscribed(boxes[:0]).shape == (0, 5)


@pytest.mark.parametrize("few", [0, 1000])
@pytest.mark.parametrize("kind", ["alike", "any", "flat", "whole"])
def test_boxes_that_meet_are_all_that_share_an_area(
    kind: str, few: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pairs, "FEW", few)
    rng = np.random.default_rng(0)
    for _ in range(30):
        first, second = (boxes_like(kind, rng, int(rng.integers(0, 60))) for _ in range(2))
        low = np.maximum(first[:, None, :2], second[:, :2])
        high = np.minimum(first[:, None, :2] + first[:, None, 2:], second[:, :2] + second[:, 2:])
        expected = np.nonzero((low < high).all(axis=2))
        np.testing.assert_array_equal(meeting(first, second), expected)
        one, other = candidates(first, second)
        assert len({*zip(one.tolist(), other.tolist(), strict=True)}) == len(one)


def test_where_hidden_objects_may_come_up_is_what_all_pairs_say() -> None:
    rng = np.random.default_rng(0)
    places = np.concatenate([rng.uniform(0, 300, (40, 2, 2)), rng.uniform(3, 30, (40, 2, 3))], 2)
    variances, boxes = rng.uniform(0, 4, (40, 2)), boxes_like("alike", rng, 60)
    area = 640 * 480
    i, j, off = near(places, variances, boxes, area)
    centers = boxes[:, :2] + (boxes[:, 2:] - 1) / 2
    seen = (variances + PART**2) * places[:, 0, 2:4].prod(axis=1)[:, None]
    squares = (places[:, :, None, :2] - centers) ** 2 / seen[:, None, None]
    as_likely = 2 * np.log(area / (2 * np.pi * np.sqrt(seen.prod(axis=1))))
    shares = np.sqrt(squares.sum(axis=3).min(axis=1) / as_likely[:, None])
    np.testing.assert_array_equal([i, j], np.nonzero(shares <= 1))
    np.testing.assert_allclose(off, shares[i, j])


def test_an_object_that_may_be_anywhere_is_found_nowhere() -> None:
    place, area = np.array([[[100.0, 100, 12, 12, 0]] * 2]), 640 * 360
    here, beside = np.array([[94.0, 94, 13, 13], [154, 94, 13, 13]])
    for sigma, found in (0.5, [0]), (5, [0, 1]), (19, []):
        _, j, _ = near(place, np.full((1, 2), sigma**2), np.stack([here, beside]), area)
        assert j.tolist() == found, sigma


@pytest.mark.parametrize("block", [3, 1000])
def test_each_detection_drops_those_after_it_that_are_the_same(
    block: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(overlaps, "BLOCK", block)
    rng = np.random.default_rng(0)
    for _ in range(20):
        boxes = boxes_like("any", rng, 40)
        shares = intersection_over_first(boxes[:, None], boxes)
        same, kept = np.maximum(shares, shares.T) > 0.6, list[int]()
        for i in range(len(boxes)):
            if not same[i, kept].any():
                kept.append(i)
        assert without_duplicates(boxes, 0.6) == kept


@pytest.mark.parametrize("dense", [0, 30])
def test_assignment_of_pairs_is_that_of_a_matrix(
    dense: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(association, "DENSE", dense)
    rng = np.random.default_rng(0)
    for _ in range(60):
        n, m = (int(k) for k in rng.integers(1, 30, 2))
        possible = rng.random((n, m)) < rng.choice([0.02, 0.05, 0.3])
        costs = np.where(possible, rng.random((n, m)), np.inf)
        costs[0, 0] = 0
        i, j = np.indices((n, m)).reshape(2, -1)
        assert assign_pairs(i, j, costs.ravel(), (n, m)) == assign(costs)
