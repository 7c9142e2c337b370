"""Mean shift from a predicted start: its filter against a textbook one, and what it follows."""

from __future__ import annotations

import numpy as np
import pytest

from motes import Box, Frame
from motes_lab.adapters.registry import tracker_spec
from motes_lab.papers.predicted_mean_shift import ACCELERATION, MEASUREMENT, Motion


def test_prediction_and_update_by_the_textbook() -> None:
    """Four states x, y, vx, vy in one filter, in Joseph form."""
    unit = 12.0
    motion = Motion(np.array([30.0, 40.0]), unit)
    m, p = np.array([30.0, 40, 0, 0]), np.diag([0.0, 0, unit**2, unit**2])
    f = np.block([[np.eye(2), np.eye(2)], [np.zeros((2, 2)), np.eye(2)]])
    g = np.vstack([np.eye(2) / 2, np.eye(2)])
    h, r = np.eye(2, 4), np.eye(2) * (MEASUREMENT * unit) ** 2
    rng = np.random.default_rng(0)
    for _ in range(6):
        m, p = f @ m, f @ p @ f.T + g @ g.T * (ACCELERATION * unit) ** 2
        np.testing.assert_allclose(motion.predict(), m[:2])
        z = rng.normal(40, 15, 2)
        gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + r)
        m, keep = m + gain @ (z - h @ m), np.eye(4) - gain @ h
        p = keep @ p @ keep.T + gain @ r @ gain.T
        motion.update(z)
        np.testing.assert_allclose(motion.mean.ravel(), m)
        np.testing.assert_allclose(np.kron(motion.covariance, np.eye(2)), p, atol=1e-9)


@pytest.mark.parametrize(
    ("name", "kept"),
    [("motes_lab.papers.predicted_mean_shift:tracker", True), ("mean_shift", False)],
)
def test_regions_that_do_not_overlap_are_followed_by_the_prediction(name: str, kept: bool) -> None:
    """A square of 20 pixels that moves by 2 more in each frame, up to 28."""
    adapter, places = tracker_spec(name).begin(0), np.cumsum(np.arange(0, 30, 2)) + 10
    pictures = [np.full((60, 300, 3), 128, np.uint8) for _ in places]
    for index, (picture, x) in enumerate(zip(pictures, places.tolist(), strict=True)):
        picture[20:40, x : x + 20] = 255, 0, 0
        frame = Frame(index, index / 25, picture)
        answer = adapter.update(frame) if index else adapter.init(frame, Box(x, 20, 20, 20))
    assert answer.ellipse is not None
    assert (abs(answer.ellipse.x - (places[-1] + 9.5)) < 4) == kept
