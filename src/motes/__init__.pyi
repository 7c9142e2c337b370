"""The public names, which `__init__.py` loads on first use."""

from . import (
    cues as cues,
    filtering as filtering,
    synthetic as synthetic,
    testing as testing,
)
from .core.config import Config as Config
from .core.detection import (
    Detection as Detection,
    Detector as Detector,
    DetectorConfig as DetectorConfig,
    as_detections as as_detections,
)
from .core.errors import (
    ConfigError as ConfigError,
    FormatError as FormatError,
    MissingDependencyError as MissingDependencyError,
    MotesError as MotesError,
    PluginError as PluginError,
    SourceError as SourceError,
)
from .core.frame import Frame as Frame
from .core.geometry import Box as Box, Ellipse as Ellipse
from .core.track import Status as Status, Track as Track
from .correction.correct import correct as correct, refine as refine, smooth as smooth
from .correction.doubts import Doubt as Doubt, doubts as doubts
from .correction.keyframes import read_keyframes as read_keyframes
from .mot.analytics.event import Event as Event
from .mot.analytics.event_counter import EventCounter as EventCounter
from .mot.analytics.ground_plane import Ground as Ground
from .mot.analytics.regions import Line as Line, Regions as Regions, Zone as Zone
from .mot.detection.lookalike import LookalikeDetector as LookalikeDetector
from .mot.scene import Scene as Scene
from .mot.scene_config import named_detector as named_detector, scene_config as scene_config
from .output.overlay import draw as draw
from .output.scene_overlay import draw_scene as draw_scene
from .rows.reader import read_track as read_track
from .rows.writer import TrackWriter as TrackWriter
from .sot.algorithm import Algorithm as Algorithm, StepInfo as StepInfo
from .sot.discriminative.tracker import Discriminative as Discriminative
from .sot.known_target import KnownTarget as KnownTarget, Place as Place, load_places as load_places
from .sot.mean_shift import MeanShift as MeanShift
from .sot.opencv_api import OpenCVTracker as OpenCVTracker
from .sot.particle_filter import ParticleFilter as ParticleFilter
from .sot.presets import (
    PRESETS as PRESETS,
    TrackerConfig as TrackerConfig,
    configure as configure,
    preset as preset,
)
from .sot.tracker import Tracker as Tracker
from .sot.trackers import Trackers as Trackers
from .video.sources import Source as Source, open_source as open_source
from .video.writer import VideoWriter as VideoWriter

__all__: list[str]
__version__: str
