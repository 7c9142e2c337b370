"""The table of directions is that of the angles."""

from __future__ import annotations

import numpy as np

from motes.cues.search_window import sectors


def test_the_sector_of_a_gradient_is_that_of_its_angle() -> None:
    down, across = np.mgrid[-256:256, -256:256]
    numbers = np.round(np.arctan2(down, across) * 9 / np.pi) % 18
    np.testing.assert_array_equal(sectors(), numbers)
