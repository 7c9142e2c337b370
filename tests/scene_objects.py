"""Objects of a scene, built by hand for tests of its stages."""

from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from motes import PRESETS, Box, Frame, ParticleFilter, Status, scene_config
from motes.core.types import Floats
from motes.mot.look import FRAMES, Look
from motes.mot.scene_config import SceneConfig
from motes.mot.tracked_object import TrackedObject

Color = tuple[int, int, int]
RED, BLUE = (220, 60, 60), (60, 60, 220)
SIZE = 200, 120
DT = 0.04


def quick(particles: int = 20, places: int = 20) -> ParticleFilter:
    """Return a filter that takes little time."""
    tracker = PRESETS["nummiaro"]
    assert isinstance(tracker, ParticleFilter)
    presence = replace(tracker.presence, max_positions=places)
    return replace(tracker, particles=particles, presence=presence)


def config() -> SceneConfig:
    """Return a scene whose filters have few particles."""
    return scene_config(quick())


def grid(count: int, share: float) -> Floats:
    """Return boxes (count, 4) that cover a share of a frame of 640x480, however many they are."""
    across = int(np.ceil((count * 4 / 3) ** 0.5))
    places = np.stack([np.arange(count) % across, np.arange(count) // across], axis=1) + 0.2
    return np.hstack([places, np.full((count, 2), share**0.5)]) * (640 / across)


def picture(index: int, *painted: tuple[Box, Color]) -> Frame:
    """Return a gray frame with colored boxes, later ones in front."""
    pixels = np.full((*SIZE[::-1], 3), 100, np.uint8)
    for (x, y, width, height), color in painted:
        pixels[int(y) : int(y + height), int(x) : int(x + width)] = color
    return Frame(index, index * DT, pixels)


def visible(identity: int, frame: Frame, box: Box) -> TrackedObject:
    """Return an object that is detected in a frame."""
    hits = [(frame.time, box)] * 2
    rng = np.random.default_rng(identity)
    return TrackedObject.begin(identity, config().tracker, rng, frame, hits)


def undetected(identity: int, frame: Frame, box: Box) -> TrackedObject:
    """Return a visible object that has no detection in the next frame yet."""
    return visible(identity, frame, box).predict(DT)


def occluded(identity: int, frame: Frame, box: Box, by: int | None = None) -> TrackedObject:
    """Return an object that was last detected in a frame, and is occluded since."""
    return undetected(identity, frame, box).occlude(by)


def with_look(each: TrackedObject, color: Color, frames: int = FRAMES) -> TrackedObject:
    """Return an object that was of a color in so many frames when it was last clear of others."""
    (look,) = Look.at(picture(0, (each.track.box, color)), [each.track.ellipse])
    return replace(each, known=replace(look, frames=frames))


def statuses(objects: Sequence[TrackedObject]) -> dict[int, Status]:
    """Return the status of each object by its identity."""
    return {each.identity: each.track.status for each in objects}
