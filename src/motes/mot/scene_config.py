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
"""An object's background is looked at around so many places at its birth: a few milliseconds."""


class SceneConfig(Config, frozen=True):
    """How objects come, stay and go.

    Attributes
    ----------
    tracker
        What follows each object.
    association
        What makes a detection the same object as before.
    duplicate_overlap
        A detection with more than this share in a surer one, or the other way round, is the same.
    min_score_quantile
        This share of all detections, the least sure ones, begins no objects.
    min_hits
        A detection becomes an object when it is confirmed in so many frames in a row.
    velocity_smoothing
        Share of its velocity that an object keeps when a detection says another one.
    size_smoothing
        Share of its size that an object keeps when a detection says another one.
    occlusion_overlap
        An object is hidden by another if that covers more than this share of it.
    max_time_without_detection
        Seconds for which colors alone may follow an object that no detection confirms.
    max_age
        Seconds for which a hidden object is waited for, if it was known for as long before; twice
        that where another object is seen.
    max_age_at_border
        The same where it should be at the border, or outside.
    min_max_age
        Seconds for which any hidden object is waited for.
    containment
        A box with more than this share of it in another one lies within that.
    merged_blob_ratio
        A detection with two objects in it is so many times larger than either.
    limit
        No more detections than these, the surest, are taken of one frame.
    """

    tracker: ParticleFilter
    association: Association = Association()
    duplicate_overlap: Share = 0.6
    min_score_quantile: Share = 0.25
    min_hits: Count = 3
    velocity_smoothing: Share = 0.8
    size_smoothing: Share = 0.5
    occlusion_overlap: Annotated[float, Meta(gt=0, le=1)] = 0.3
    max_time_without_detection: NonNegative = 0.12
    max_age: Positive = 3.0
    max_age_at_border: NonNegative = 0.2
    min_max_age: NonNegative = 0.4
    containment: Share = 0.7
    merged_blob_ratio: Annotated[float, Meta(ge=1)] = 1.4
    limit: Count = 10_000


def scene_config(tracker: str | ParticleFilter = "nummiaro:adaptive") -> SceneConfig:
    """Return the configuration of a scene whose objects a preset follows.

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
