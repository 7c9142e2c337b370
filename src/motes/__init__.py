"""motes follows objects through video with particle filters.

Four more modules are public: `motes.cues` (how far pixels are from a target model),
`motes.filtering` (the parts of a particle filter), `motes.synthetic` (rendered clips with exact
truth) and `motes.testing` (checks for packages that extend motes).
"""

TYPE_CHECKING = False  # as in typing, which takes longer to import than all else here
if TYPE_CHECKING:  # type checkers read the names here, and `_NAMES` has them for all else
    from typing import Any

    from motes import (
        cues as cues,
        filtering as filtering,
        synthetic as synthetic,
        testing as testing,
    )
    from motes.core.adapters import as_detections as as_detections
    from motes.core.config import Config as Config
    from motes.core.detection import (
        Detection as Detection,
        Detector as Detector,
        DetectorConfig as DetectorConfig,
    )
    from motes.core.errors import (
        ConfigError as ConfigError,
        FormatError as FormatError,
        MissingDependencyError as MissingDependencyError,
        MotesError as MotesError,
        PluginError as PluginError,
        SourceError as SourceError,
    )
    from motes.core.frame import Frame as Frame
    from motes.core.geometry import Box as Box, Ellipse as Ellipse
    from motes.core.track import Status as Status, Track as Track
    from motes.correction.correct import correct as correct, smooth as smooth
    from motes.correction.keyframes import read_keyframes as read_keyframes
    from motes.correction.refine import refine as refine
    from motes.correction.suspects import Doubt as Doubt, doubts as doubts
    from motes.mot.analytics.events import Event as Event, EventCounter as EventCounter
    from motes.mot.analytics.ground_plane import Ground as Ground
    from motes.mot.analytics.regions import Line as Line, Regions as Regions, Zone as Zone
    from motes.mot.detection.background import (
        BackgroundConfig as BackgroundConfig,
        BackgroundDetector as BackgroundDetector,
    )
    from motes.mot.detection.lookalike import (
        LookalikeConfig as LookalikeConfig,
        LookalikeDetector as LookalikeDetector,
    )
    from motes.mot.detection.onnx_detector import (
        OnnxConfig as OnnxConfig,
        OnnxDetector as OnnxDetector,
    )
    from motes.mot.detection.pretrained import (
        FaceDetector as FaceDetector,
        FacesConfig as FacesConfig,
        PeopleConfig as PeopleConfig,
        PeopleDetector as PeopleDetector,
    )
    from motes.mot.scene import Scene as Scene
    from motes.mot.scene_config import SceneConfig as SceneConfig, scene_config as scene_config
    from motes.mot.tracked_object import SceneTrack as SceneTrack
    from motes.output.overlay import draw as draw
    from motes.rows.reader import read_track as read_track
    from motes.output.scene_overlay import draw_scene as draw_scene
    from motes.rows.writer import TrackWriter as TrackWriter
    from motes.sot.algorithm import Algorithm as Algorithm
    from motes.sot.batch import Trackers as Trackers
    from motes.sot.discriminative.tracker import Discriminative as Discriminative
    from motes.sot.known_target import KnownTarget as KnownTarget
    from motes.sot.mean_shift import MeanShift as MeanShift
    from motes.sot.opencv_api import OpenCVTracker as OpenCVTracker
    from motes.sot.particle_filter import ParticleFilter as ParticleFilter
    from motes.sot.places import Place as Place, load_places as load_places
    from motes.sot.presets import (
        PRESETS as PRESETS,
        TrackerConfig as TrackerConfig,
        configure as configure,
        preset as preset,
    )
    from motes.sot.step_info import StepInfo as StepInfo
    from motes.sot.tracker import Tracker as Tracker
    from motes.video.image_files import read_image as read_image
    from motes.video.sources import Source as Source, open_source as open_source
    from motes.video.writer import VideoWriter as VideoWriter

__version__ = "0.1.0"

_NAMES = {
    "core.adapters": "as_detections",
    "core.config": "Config",
    "core.detection": "Detection Detector DetectorConfig",
    "core.errors": "ConfigError FormatError MissingDependencyError MotesError PluginError "
    "SourceError",
    "core.frame": "Frame",
    "core.geometry": "Box Ellipse",
    "core.track": "Status Track",
    "correction.correct": "correct smooth",
    "correction.keyframes": "read_keyframes",
    "correction.refine": "refine",
    "correction.suspects": "Doubt doubts",
    "mot.analytics.events": "Event EventCounter",
    "mot.analytics.ground_plane": "Ground",
    "mot.analytics.regions": "Line Regions Zone",
    "mot.detection.background": "BackgroundConfig BackgroundDetector",
    "mot.detection.lookalike": "LookalikeConfig LookalikeDetector",
    "mot.detection.onnx_detector": "OnnxConfig OnnxDetector",
    "mot.detection.pretrained": "FaceDetector FacesConfig PeopleConfig PeopleDetector",
    "mot.scene": "Scene",
    "mot.scene_config": "SceneConfig scene_config",
    "mot.tracked_object": "SceneTrack",
    "output.overlay": "draw",
    "rows.reader": "read_track",
    "output.scene_overlay": "draw_scene",
    "rows.writer": "TrackWriter",
    "sot.algorithm": "Algorithm",
    "sot.batch": "Trackers",
    "sot.discriminative.tracker": "Discriminative",
    "sot.known_target": "KnownTarget",
    "sot.mean_shift": "MeanShift",
    "sot.opencv_api": "OpenCVTracker",
    "sot.particle_filter": "ParticleFilter",
    "sot.places": "Place load_places",
    "sot.presets": "PRESETS TrackerConfig configure preset",
    "sot.step_info": "StepInfo",
    "sot.tracker": "Tracker",
    "video.image_files": "read_image",
    "video.sources": "Source open_source",
    "video.writer": "VideoWriter",
}
"""The public names of each module. They are loaded on first use: `import motes` costs nothing."""
_HOMES = {name: home for home, names in _NAMES.items() for name in names.split()}
_MODULES = ("cues", "filtering", "synthetic", "testing")

__all__ = sorted(_HOMES)


def __getattr__(name: str) -> "Any":
    import importlib

    if name in _MODULES:
        return importlib.import_module(f"motes.{name}")
    if name not in _HOMES:
        raise AttributeError(f"module 'motes' has no attribute {name!r}")
    return getattr(importlib.import_module(f"motes.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, *_MODULES, "__version__"]
