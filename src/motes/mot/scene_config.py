"""How objects come, stay and go in a scene, and which detector finds them, as configuration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from msgspec import Meta
from msgspec.structs import asdict, fields, replace

from motes.core.config import Config, Count, NonNegative, Positive, Share, from_dict, merge
from motes.core.detection import Detector, DetectorConfig
from motes.core.errors import ConfigError
from motes.core.registry import Registry
from motes.mot.association import Association
from motes.mot.detection.background import BackgroundConfig
from motes.mot.detection.custom import CustomConfig
from motes.mot.detection.lookalike import LookalikeConfig
from motes.mot.detection.moving_camera import Camera
from motes.mot.detection.onnx_detector import OnnxConfig, onnx_values
from motes.mot.detection.pretrained import FacesConfig, PeopleConfig, RecordedConfig
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import PRESETS, preset

MAX_POSITIONS = 2000
"""Largest number of places at which a new object's background is measured: some milliseconds."""
LOOKALIKE_OVERLAP = 0.2
"""Least intersection over union of an object that looks like a target with its detection."""


class DetectionSelection(Config, frozen=True):
    """Which detections of a frame are used."""

    limit: Count = 10_000
    """Largest number of detections of a frame that are used: those with the highest scores. With a
    smaller value more are ignored."""
    classes: tuple[str, ...] = ()
    """Names of the classes that are used; all if empty."""
    least: float | None = None
    """Least score of a detection that is used; by default any. With a larger value fewer are
    used."""
    every: Count = 1
    """The detector looks at every n-th frame, where n is this number. In the frames between,
    objects are where they look as before, or go on at their speed. A larger value is less exact."""


class Smoothing(Config, frozen=True):
    """How fast an object's velocity and size follow its detections."""

    velocity: Share = 0.8
    """Share of the old velocity that an object keeps at a detection. With a larger value the
    velocity changes more slowly."""
    size: Share = 0.5
    """Share of the old size that an object keeps at a detection. With a larger value the size
    changes more slowly."""


class Occlusion(Config, frozen=True):
    """When an object without a detection is occluded."""

    overlap: Annotated[float, Meta(gt=0, le=1)] = 0.3
    """An object without a detection is occluded by another object that covers more than this share
    of it. With a larger value fewer are."""
    max_time_without_detection: NonNegative = 0.12
    """Longest time without a detection, in seconds, in which an object is followed by its filter
    alone, if it is not known yet how it looks. After it the object counts as occluded."""


class Initiation(Config, frozen=True):
    """When detections start a new object."""

    min_hits: Count = 3
    """Number of detections of a new object; one less if a score is above those that no other frame
    confirms. A larger value gives fewer false objects, later."""


class Termination(Config, frozen=True):
    """When an object without a detection ends."""

    max_age: Positive = 3.0
    """Longest time in seconds for which an occluded object is kept. It is doubled where another
    object is visible in its place."""


class SceneConfig(Config, frozen=True):
    """How objects come, stay and go."""

    tracker: ParticleFilter
    """The particle filter that follows each object. Its calibration says nothing here: an object's
    confidence is how steadily it is detected."""
    camera: Camera = "auto"
    """Whether the camera is still or moving; if auto, it is followed while it moves. Its motion is
    taken from corners of the picture, and the places of all objects are predicted with it. A
    background moves along if the camera is moving; else it needs a still one."""
    detections: DetectionSelection = DetectionSelection()
    """Which detections of a frame are used."""
    association: Association = Association()
    """Which detection belongs to which object."""
    smoothing: Smoothing = Smoothing()
    """How fast an object's velocity and size follow its detections."""
    occlusion: Occlusion = Occlusion()
    """When an object without a detection is occluded."""
    initiation: Initiation = Initiation()
    """When detections start a new object."""
    termination: Termination = Termination()
    """When an object without a detection ends."""

    def for_lookalikes(self) -> Self:
        """Return the configuration for objects that look like a target.

        Patches before a background that moves along change their outline from frame to frame, more
        than the detections for which `association.overlap` was chosen.
        """
        association = replace(self.association, overlap=LOOKALIKE_OVERLAP)
        return replace(self, association=association)


def scene_config(
    tracker: str | ParticleFilter = "nummiaro:adaptive", *changes: Mapping[str, Any]
) -> SceneConfig:
    """Return the configuration of a scene whose objects are followed by a preset.

    `changes` are laid over it, from plain nested values, such as {"detections": {"every": 5}};
    `motes config --watch` lists the keys.

    Raises
    ------
    ConfigError
        If the preset is unknown or no particle filter, or for an unknown key, or a value that does
        not fit.
    """
    config = preset(tracker) if isinstance(tracker, str) else tracker
    if not isinstance(config, ParticleFilter):
        filters = [name for name, known in PRESETS.items() if isinstance(known, ParticleFilter)]
        raise ConfigError(f"Objects are followed by particle filters: {', '.join(filters)}.")
    presence = replace(
        config.presence, max_positions=min(config.presence.max_positions, MAX_POSITIONS)
    )
    scene = SceneConfig(tracker=replace(config, presence=presence))
    for change in changes:
        if not isinstance(change, Mapping):
            raise ConfigError(
                f"Give changes such as {{'detections': {{'every': 5}}}}; got {change!r}."
            )
        scene = from_dict(merge(scene.to_dict(), change), SceneConfig)
    return scene


DETECTORS = Registry[type[DetectorConfig]](
    "detector",
    "motes.detectors",
    DetectorConfig,
    {
        "background": BackgroundConfig,
        "people": PeopleConfig,
        "faces": FacesConfig,
        "recorded": RecordedConfig,
        "like": LookalikeConfig,
        "callable": CustomConfig,
        "onnx": OnnxConfig,
    },
)


class WatchConfig(SceneConfig, frozen=True):
    """A scene, and the detector of its objects."""

    detector: DetectorConfig = BackgroundConfig()
    """The detector of objects, and its settings."""

    @classmethod
    def of(cls, preset: str) -> Self:
        """Return a preset of the trackers with a background; raise as `scene_config` does."""
        return cls(**asdict(scene_config(preset)))

    def changed(self, changes: Mapping[str, Any], *, detector: str | None = None) -> Self:
        """Return the configuration with changes laid over it.

        Raises a ConfigError for an unknown detector or key, or a value that does not fit; and a
        SourceError if the TOML file beside an ONNX file cannot be read.

        Parameters
        ----------
        changes
            Plain nested values, as in TOML.
        detector
            The name of a detector in place of this one, with its default settings.
        """
        values = merge(self.to_dict(), changes)
        if detector is not None:
            values = merge(values, {"detector": detector_values(detector)})
        config: Self = from_dict(values, type(self))
        return config


def detector_values(name: str | None) -> dict[str, Any]:
    """Return the values of a `DetectorConfig` for a detector's name; None means a background.

    Raises a ConfigError if no detector has that name, or the TOML file beside an ONNX file is not
    valid; and a SourceError if the latter cannot be read.
    """
    if name is None:
        return {"type": "background"}
    if name.endswith(".txt"):
        return {"type": "recorded", "file": name}
    if name.endswith(".onnx"):
        return onnx_values(name)
    if all(name.partition(":")):
        return {"type": "callable", "name": name}
    if name in DETECTORS and _chosen_by_name(DETECTORS.resolve(name)):
        return {"type": name}
    known = ", ".join(name for name, kind in DETECTORS.usable().items() if _chosen_by_name(kind))
    raise ConfigError(
        f"A detector is {known}, MODULE:CALLABLE, or an .onnx or .txt file; got {name!r}."
    )


def _chosen_by_name(kind: Any) -> bool:
    return not any(field.required for field in fields(kind))


def check_code(detector: str | None, allowed: bool) -> None:
    """Raise a ConfigError if a file names a detector that is code, unless that is allowed."""
    if detector is None or allowed or detector.endswith((".txt", ".onnx")):
        return
    if all(detector.partition(":")):
        raise ConfigError(
            f"The detector {detector} is code, which would run; if you trust it, add --own-code."
        )


def named_detector(name: str | None = None, settings: Mapping[str, object] = {}) -> Detector:
    """Return a detector by its name, as `motes watch --detector` takes it; by default a background.

    `settings` are values of the keys that `motes config --watch detector` lists, such as
    {"least": 0.001}.

    Raises
    ------
    ConfigError
        If no detector has that name, a key is unknown, or a value does not fit.
    SourceError
        If its file cannot be read.
    MissingDependencyError
        If its package is not installed.
    """
    values = {"type": name} if settings and name in DETECTORS else detector_values(name)
    config: DetectorConfig = from_dict({**values, **settings}, DetectorConfig)
    return config.detector()
