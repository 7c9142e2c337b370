"""How objects come, stay and go in a scene, as configuration."""

from __future__ import annotations

from typing import Annotated, Self

from msgspec import Meta
from msgspec.structs import replace

from motes.core.config import Config, Count, NonNegative, Positive, Share
from motes.core.errors import ConfigError
from motes.mot.association import Association
from motes.mot.detection.moving_camera import Camera
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
    """The detector looks at every frame with this distance. Between these frames objects are
    followed by their appearance alone. A larger value is faster and less exact."""


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
    """Longest time without a detection, in seconds, in which an object is followed by its
    appearance alone. After it the object counts as occluded."""


class Initiation(Config, frozen=True):
    """When detections start a new object."""

    min_hits: Count = 3
    """Number of detections of a new object. A larger value gives fewer false objects, later."""


class Termination(Config, frozen=True):
    """When an object without a detection ends."""

    max_age: Positive = 3.0
    """Longest time in seconds for which an occluded object is kept. It is doubled where another
    object is visible in its place."""


class SceneConfig(Config, frozen=True):
    """How objects come, stay and go."""

    tracker: ParticleFilter
    """The particle filter that follows each object."""
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


def scene_config(tracker: str | ParticleFilter = "nummiaro:adaptive") -> SceneConfig:
    """Return the configuration of a scene whose objects are followed by a preset.

    Raises
    ------
    ConfigError
        If the preset is unknown or no particle filter.
    """
    config = preset(tracker) if isinstance(tracker, str) else tracker
    if not isinstance(config, ParticleFilter):
        filters = [name for name, known in PRESETS.items() if isinstance(known, ParticleFilter)]
        raise ConfigError(f"Objects are followed by particle filters: {', '.join(filters)}.")
    presence = replace(
        config.presence, max_positions=min(config.presence.max_positions, MAX_POSITIONS)
    )
    return SceneConfig(tracker=replace(config, presence=presence))
