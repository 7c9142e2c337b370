"""The methods of background subtraction, and whether OpenCV is there."""

from __future__ import annotations

import importlib.util
from typing import get_args

import pytest

from motes.mot.detection.background_models import Method

NO_CV2 = importlib.util.find_spec("cv2") is None
NEEDS_CV2 = pytest.mark.skipif(NO_CV2, reason="no OpenCV")
METHODS = get_args(Method)
