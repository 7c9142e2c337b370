"""The public names, which `__init__.py` loads on first use."""

from . import (
    cues as cues,
)
from . import (
    filtering as filtering,
)
from . import (
    synthetic as synthetic,
)
from . import (
    testing as testing,
)
from .core.config import Config as Config
from .core.detection import (
    Detection as Detection,
)
from .core.detection import (
    Detector as Detector,
)
from .core.detection import (
    DetectorConfig as DetectorConfig,
)
from .core.detection import as_detections as as_detections
from .core.errors import (
    ConfigError as ConfigError,
)
from .core.errors import (
    FormatError as FormatError,
)
from .core.errors import (
    MissingDependencyError as MissingDependencyError,
)
from .core.errors import (
    MotesError as MotesError,
)
from .core.errors import (
    PluginError as PluginError,
)
from .core.errors import (
    SourceError as SourceError,
)
from .core.frame import Frame as Frame
from .core.geometry import Box as Box
from .core.geometry import Ellipse as Ellipse
from .core.track import Status as Status
from .core.track import Track as Track
from .correction.correct import correct as correct
from .correction.correct import refine as refine
from .correction.correct import smooth as smooth
from .correction.doubts import Doubt as Doubt
from .correction.doubts import doubts as doubts
from .correction.keyframes import read_keyframes as read_keyframes
from .mot.analytics.events import Event as Event
from .mot.analytics.events import EventCounter as EventCounter
from .mot.analytics.ground_plane import Ground as Ground
from .mot.analytics.regions import Line as Line
from .mot.analytics.regions import Regions as Regions
from .mot.analytics.regions import Zone as Zone
from .mot.detection.background import (
    BackgroundConfig as BackgroundConfig,
)
from .mot.detection.background import (
    BackgroundDetector as BackgroundDetector,
)
from .mot.detection.lookalike import (
    LookalikeConfig as LookalikeConfig,
)
from .mot.detection.lookalike import (
    LookalikeDetector as LookalikeDetector,
)
from .mot.detection.onnx_detector import (
    OnnxConfig as OnnxConfig,
)
from .mot.detection.onnx_detector import (
    OnnxDetector as OnnxDetector,
)
from .mot.detection.pretrained import (
    FaceDetector as FaceDetector,
)
from .mot.detection.pretrained import (
    PeopleDetector as PeopleDetector,
)
from .mot.scene import Scene as Scene
from .mot.scene_config import SceneConfig as SceneConfig
from .mot.scene_config import scene_config as scene_config
from .output.overlay import draw as draw
from .output.scene_overlay import draw_scene as draw_scene
from .rows.reader import read_track as read_track
from .rows.writer import TrackWriter as TrackWriter
from .sot.algorithm import Algorithm as Algorithm
from .sot.algorithm import StepInfo as StepInfo
from .sot.batch import Trackers as Trackers
from .sot.discriminative.tracker import Discriminative as Discriminative
from .sot.known_target import KnownTarget as KnownTarget
from .sot.known_target import Place as Place
from .sot.known_target import load_places as load_places
from .sot.mean_shift import MeanShift as MeanShift
from .sot.opencv_api import OpenCVTracker as OpenCVTracker
from .sot.particle_filter import ParticleFilter as ParticleFilter
from .sot.presets import (
    PRESETS as PRESETS,
)
from .sot.presets import (
    TrackerConfig as TrackerConfig,
)
from .sot.presets import (
    configure as configure,
)
from .sot.presets import (
    preset as preset,
)
from .sot.tracker import Tracker as Tracker
from .video.image_files import read_image as read_image
from .video.sources import Source as Source
from .video.sources import open_source as open_source
from .video.writer import VideoWriter as VideoWriter

__all__: list[str]
__version__: str
