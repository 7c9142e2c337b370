"""motes follows objects through video with particle filters."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motes.core.detection import Detection, Detector
    from motes.core.errors import (
        ConfigError,
        FormatError,
        MissingDependencyError,
        MotesError,
        SourceError,
    )
    from motes.core.frame import Frame
    from motes.core.geometry import Box, Ellipse
    from motes.core.track import Status, Track
    from motes.mot.detection.background import BackgroundDetector
    from motes.mot.detection.lookalike import LookalikeDetector
    from motes.mot.detection.pretrained import FaceDetector
    from motes.mot.scene import Scene
    from motes.mot.tracked_object import SceneTrack
    from motes.sot.batch import Trackers
    from motes.sot.known_target import Place, Target
    from motes.sot.opencv_api import OpenCVTracker
    from motes.sot.presets import PRESETS, configure, preset
    from motes.sot.tracker import Tracker
    from motes.video.sources import open_source

__version__ = "0.1.0"

# Names are loaded on first use, so that `import motes` costs nothing.
_HOMES = {
    "BackgroundDetector": "mot.detection.background",
    "Box": "core.geometry",
    "ConfigError": "core.errors",
    "Detection": "core.detection",
    "Detector": "core.detection",
    "Ellipse": "core.geometry",
    "FaceDetector": "mot.detection.pretrained",
    "FormatError": "core.errors",
    "Frame": "core.frame",
    "LookalikeDetector": "mot.detection.lookalike",
    "MissingDependencyError": "core.errors",
    "MotesError": "core.errors",
    "OpenCVTracker": "sot.opencv_api",
    "PRESETS": "sot.presets",
    "Place": "sot.known_target",
    "Scene": "mot.scene",
    "SceneTrack": "mot.tracked_object",
    "SourceError": "core.errors",
    "Status": "core.track",
    "Target": "sot.known_target",
    "Track": "core.track",
    "Tracker": "sot.tracker",
    "Trackers": "sot.batch",
    "configure": "sot.presets",
    "open_source": "video.sources",
    "preset": "sot.presets",
}

__all__ = [
    "PRESETS",
    "BackgroundDetector",
    "Box",
    "ConfigError",
    "Detection",
    "Detector",
    "Ellipse",
    "FaceDetector",
    "FormatError",
    "Frame",
    "LookalikeDetector",
    "MissingDependencyError",
    "MotesError",
    "OpenCVTracker",
    "Place",
    "Scene",
    "SceneTrack",
    "SourceError",
    "Status",
    "Target",
    "Track",
    "Tracker",
    "Trackers",
    "configure",
    "open_source",
    "preset",
]


def __getattr__(name: str) -> Any:
    if name == "LimitError":
        raise AttributeError("motes.LimitError is MissingDependencyError now")
    if name not in _HOMES:
        raise AttributeError(f"module 'motes' has no attribute {name!r}")
    return getattr(importlib.import_module(f"motes.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
