"""motes follows objects through video with particle filters."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motes.background import BackgroundDetector
    from motes.detection import Detection, Detector, FaceDetector
    from motes.errors import ConfigError, FormatError, LimitError, MotesError, SourceError
    from motes.frame import Frame
    from motes.geometry import Box, Ellipse
    from motes.lookalike import LookalikeDetector
    from motes.objects import SceneTrack
    from motes.presets import PRESETS, configure, preset
    from motes.scene import Scene
    from motes.target import Place, Target
    from motes.track import Status, Track
    from motes.tracker import OpenCVTracker, Tracker
    from motes.trackers import Trackers
    from motes.video import open_source

__version__ = "0.1.0"

# Names are loaded on first use, so that `import motes` costs nothing.
_HOMES = {
    "PRESETS": "presets",
    "BackgroundDetector": "background",
    "Box": "geometry",
    "ConfigError": "errors",
    "Detection": "detection",
    "Detector": "detection",
    "Ellipse": "geometry",
    "FaceDetector": "detection",
    "FormatError": "errors",
    "Frame": "frame",
    "LimitError": "errors",
    "LookalikeDetector": "lookalike",
    "MotesError": "errors",
    "OpenCVTracker": "tracker",
    "Place": "target",
    "Scene": "scene",
    "SceneTrack": "objects",
    "SourceError": "errors",
    "Status": "track",
    "Target": "target",
    "Track": "track",
    "Tracker": "tracker",
    "Trackers": "trackers",
    "configure": "presets",
    "open_source": "video",
    "preset": "presets",
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
    "LimitError",
    "LookalikeDetector",
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
    if name not in _HOMES:
        raise AttributeError(f"module 'motes' has no attribute {name!r}")
    return getattr(importlib.import_module(f"motes.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
