"""How objects come, stay and go in a scene, as configuration."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta
from msgspec.structs import replace

from motes.core.config import Config, Count, NonNegative, Positive, Share
from motes.core.errors import ConfigError
from motes.mot.association import Association
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import PRESETS, preset

MAX_POSITIONS = 2000
"""Largest number of places at which a new object's background is measured: some milliseconds."""


class DetectionSelection(Config, frozen=True):
    """Which detections of a frame are used.

    Attributes
    ----------
    limit
        Largest number of detections of a frame that are used: those with the highest scores. With a
        smaller value more are ignored.
    classes
        Names of the classes that are used; all if empty.
    least
        Least score of a detection that is used; by default any. With a larger value fewer are used.
    every
        The detector looks at every frame with this distance. Between these frames objects are
        followed by their appearance alone. A larger value is faster and less exact.
    """

    limit: Count = 10_000
    classes: tuple[str, ...] = ()
    least: float | None = None
    every: Count = 1


class Smoothing(Config, frozen=True):
    """How fast an object's velocity and size follow its detections.

    Attributes
    ----------
    velocity
        Share of the old velocity that an object keeps at a detection. With a larger value the
        velocity changes more slowly.
    size
        Share of the old size that an object keeps at a detection. With a larger value the size
        changes more slowly.
    """

    velocity: Share = 0.8
    size: Share = 0.5


class Occlusion(Config, frozen=True):
    """When an object without a detection is occluded.

    Attributes
    ----------
    overlap
        An object without a detection is occluded by another object that covers more than this share
        of it. With a larger value fewer are.
    max_time_without_detection
        Longest time without a detection, in seconds, in which an object is followed by its
        appearance alone. After it the object counts as occluded.
    """

    overlap: Annotated[float, Meta(gt=0, le=1)] = 0.3
    max_time_without_detection: NonNegative = 0.12


class Initiation(Config, frozen=True):
    """When detections start a new object.

    Attributes
    ----------
    min_hits
        Number of detections of a new object. A larger value gives fewer false objects, later.
    """

    min_hits: Count = 3


class Termination(Config, frozen=True):
    """When an object without a detection ends.

    Attributes
    ----------
    max_age
        Longest time in seconds for which an occluded object is kept. It is doubled where another
        object is visible in its place.
    """

    max_age: Positive = 3.0


class SceneConfig(Config, frozen=True):
    """How objects come, stay and go.

    Attributes
    ----------
    tracker
        The particle filter that follows each object.
    detections
        Which detections of a frame are used.
    association
        Which detection belongs to which object.
    smoothing
        How fast an object's velocity and size follow its detections.
    occlusion
        When an object without a detection is occluded.
    initiation
        When detections start a new object.
    termination
        When an object without a detection ends.
    """

    tracker: ParticleFilter
    detections: DetectionSelection = DetectionSelection()
    association: Association = Association()
    smoothing: Smoothing = Smoothing()
    occlusion: Occlusion = Occlusion()
    initiation: Initiation = Initiation()
    termination: Termination = Termination()


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
