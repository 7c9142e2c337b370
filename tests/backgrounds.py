"""Whether OpenCV is there."""

import importlib.util

import pytest

NO_CV2 = importlib.util.find_spec("cv2") is None
NEEDS_CV2 = pytest.mark.skipif(NO_CV2, reason="no OpenCV")
