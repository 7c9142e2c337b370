"""The methods of background subtraction that can run here."""

from __future__ import annotations

import importlib.util
from typing import get_args

import pytest

from motes.mot.detection.background_models import Method

NO_CV2 = importlib.util.find_spec("cv2") is None
METHODS = [
    pytest.param(m, marks=pytest.mark.skipif(NO_CV2 and m != "gaussian", reason="no OpenCV"))
    for m in get_args(Method)
]
