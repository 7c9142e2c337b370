"""A contact sheet shows a target of any size as large as fits on its tile."""

import numpy as np
import pytest

from motes import Ellipse, Status, Track
from motes.output.contact_sheet import CONTEXT, GAP, TILE, contact_sheet


@pytest.mark.parametrize("half", [3.0, 10.0, 60.0])
def test_a_target_fills_its_tile(half: float) -> None:
    pixels = np.full((600, 800, 3), (0, 90, 0), np.uint8)
    ellipse = Ellipse(400, 300, half, half, 0.0)
    track = Track(
        frame=0, time=0.0, ellipse=ellipse, covariance=np.eye(5), confidence=1.0,
        status=Status.TRACKING, distance=0.0, effective_sample_size=1.0,
    )  # fmt: skip
    tile = contact_sheet([(pixels, track, "1.")])[GAP : GAP + TILE, GAP : GAP + TILE]
    background = (tile == (0, 90, 0)).all(axis=2)
    assert background[[3, 3, -4, -4], [3, -4, 3, -4]].all()
    outline = np.argwhere(~background[5:-5, 5:-5])
    across = np.ptp(outline, axis=0) + 1
    assert across == pytest.approx(TILE / CONTEXT, rel=0.2)
