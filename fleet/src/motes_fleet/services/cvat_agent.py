"""A tracking function for CVAT's agents: `cvat-cli function run-agent` runs it on any machine.

    cvat-cli function create-native motes --function-module motes_fleet.services.cvat_agent
    cvat-cli function run-agent ID --function-module motes_fleet.services.cvat_agent

It needs the package cvat-cli. https://docs.cvat.ai/docs/api_sdk/sdk/auto-annotation/
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from motes import Box, ConfigError, Frame, Status, Tracker
from motes.core import optional

if TYPE_CHECKING:
    from PIL.Image import Image


class TrackingFunction:
    """Tracks rectangles, as `cvat_sdk.auto_annotation.TrackingFunction` describes it."""

    def __init__(self, preset: str = "default") -> None:
        self._preset = preset
        self._sdk = optional(
            "cvat_sdk.auto_annotation", "CVAT's agent needs its package", "cvat-cli"
        )

    @property
    def spec(self) -> Any:
        """The shapes that can be tracked."""
        return self._sdk.TrackingFunctionSpec(supported_shape_types=["rectangle"])

    def preprocess_image(self, context: Any, image: Image) -> Frame:
        """Return an image as a frame; all shapes on it share what cues compute from it."""
        del context
        return Frame(0, 0.0, np.asarray(image.convert("RGB")))

    def init_tracking_state(self, context: Any, pp_image: Frame, shape: Any) -> Tracker:
        """Return a tracker of a shape."""
        del context
        tracker = Tracker(self._preset)
        tracker.init(pp_image, box_of(shape.points))
        return tracker

    def track(self, context: Any, pp_image: Frame, state: Tracker) -> Any:
        """Return the shape in the next image; None if it is not found."""
        del context
        track = state.update(pp_image.pixels)
        if track.status is not Status.TRACKING or track.guessed:
            return None
        return self._sdk.TrackableShape(type="rectangle", points=corners_of(track.box))


def create(preset: str = "default") -> TrackingFunction:
    """Return the function; the agent calls this, with the parameters of its command line (-p)."""
    return TrackingFunction(preset)


def box_of(shape: list[float]) -> Box:
    """Return the box of the corners left, top, right, bottom, or of a polygon.

    Raises
    ------
    ConfigError
        If it has fewer than four numbers, or an odd number of them.
    """
    if len(shape) < 4 or len(shape) % 2:
        raise ConfigError(f"A shape has the corners of a rectangle; got {len(shape)} numbers.")
    points = np.reshape(np.array(shape, np.float64), (-1, 2))
    (left, top), (right, bottom) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return Box(left, top, right - left, bottom - top)


def corners_of(box: Box) -> list[float]:
    """Return the corners left, top, right, bottom of a box."""
    return [round(value, 2) for value in (box.x, box.y, box.x + box.width, box.y + box.height)]
