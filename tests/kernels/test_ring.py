"""Correlations around a hole, against numpy's."""

import numpy as np
import pytest

from motes import kernels


@pytest.mark.parametrize("hole", [(7, 6, 19, 18), (0, 0, 5, 24), (26, 3, 26, 9)])
def test_correlations_are_those_of_numpy(hole: tuple[int, int, int, int]) -> None:
    rng = np.random.default_rng(0)
    large, small = (rng.random(shape, np.float32) * 700 for shape in ((31, 61), (24, 26)))
    large[:24, 30:56] = small
    left, top, right, bottom = hole
    ring = np.ones(small.shape, bool)
    ring[top:bottom, left:right] = False
    out = np.empty((8, 36), np.float32)
    kernels.ring.correlations(large, small, hole, out)
    views = np.lib.stride_tricks.sliding_window_view(large, small.shape)
    expected = [[np.corrcoef(each[ring], small[ring])[0, 1] for each in row] for row in views]
    np.testing.assert_allclose(out, expected, atol=1e-5)
    assert out.max() == pytest.approx(1)
    kernels.ring.correlations(np.ones_like(large), small, hole, out)
    assert not out.any()


@pytest.mark.parametrize("hole", [(-1, 0, 5, 5), (0, 0, 27, 5), (6, 0, 5, 5), (0, 0, 26, 24)])
def test_a_hole_that_is_not_within_is_refused(hole: tuple[int, int, int, int]) -> None:
    large, small = np.zeros((31, 61), np.float32), np.zeros((24, 26), np.float32)
    with pytest.raises(ValueError, match="a picture with a hole"):
        kernels.ring.correlations(large, small, hole, np.empty((8, 36), np.float32))
    with pytest.raises(ValueError, match="a picture with a hole"):
        kernels.ring.correlations(large, small, (1, 1, 2, 2), np.empty((8, 37), np.float32))
