"""CVAT's serverless function of a tracker, for Nuclio: `handler: motes.services.cvat:handler`.

A request holds the picture, the shapes to begin with, and the states of the trackers, which this
function returned for the picture before. The states come with each request, so any worker can
answer it. https://docs.cvat.ai/docs/manual/advanced/serverless-tutorial/
"""

from __future__ import annotations

import base64
import io
import json
import tempfile
import zlib
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from PIL import Image

from motes.core.errors import ConfigError, MotesError
from motes.core.geometry import Box
from motes.core.track import Status
from motes.core.types import Bytes
from motes.sot.tracker import Tracker

PRESET = "default"
BROKEN = (
    ValueError,
    TypeError,
    OSError,
    SyntaxError,
    RecursionError,
    Image.DecompressionBombError,
    msgspec.MsgspecError,
)
"""What reading a broken request or picture raises."""
LARGEST_STATE = 1 << 28
"""Bytes of a state when it is unpacked; a larger one is refused."""


class Request(msgspec.Struct):
    """What CVAT sends: a picture in base64, and shapes (left, top, right, bottom) and states."""

    image: str
    shapes: list[list[float]] = []
    states: list[str | None] = []


def init_context(context: Any) -> None:
    """Prepare a worker; Nuclio calls it once."""
    context.logger.info("motes is ready")


def handler(context: Any, event: Any) -> Any:
    """Answer a request of CVAT; Nuclio calls it."""
    body: dict[str, Any]
    try:
        body, status = respond(event.body), 200
    except MotesError as error:
        body, status = {"error": str(error)}, 400
    return context.Response(
        body=json.dumps(body), headers={}, content_type="application/json", status_code=status
    )


def respond(body: Any) -> dict[str, list[Any]]:
    """Return the shapes and the states after a picture.

    A shape without a state begins a tracker. A target that is not found keeps its last place.

    Raises
    ------
    ConfigError
        If the request has another form, or a shape does not fit the picture.
    FormatError
        If a state is none.
    """
    try:
        given = body if isinstance(body, dict) else json.loads(body)
        request: Request = msgspec.convert(given, Request)
        pixels = picture(base64.b64decode(request.image, validate=True))
    except BROKEN as error:
        raise ConfigError(f"This is not a request of CVAT to a tracker: {error}") from None
    shapes: list[list[float]] = []
    states: list[str] = []
    for i, shape in enumerate(request.shapes):
        state = request.states[i] if i < len(request.states) else None
        if state is None:
            tracker = Tracker(PRESET)
            box = tracker.init(pixels, box_of(shape)).box
        else:
            tracker = unpacked(state)
            track = tracker.update(pixels)
            found = track.status is Status.TRACKING
            box = track.box if found or len(shape) != 4 else box_of(shape)
        shapes.append(corners_of(box))
        states.append(packed(tracker))
    return {"shapes": shapes, "states": states}


def picture(data: bytes) -> Bytes:
    """Return the pixels (H, W, 3) of an image file."""
    with Image.open(io.BytesIO(data)) as image:
        return np.asarray(image.convert("RGB"))


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


def packed(tracker: Tracker) -> str:
    """Return a tracker as text."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tracker"
        tracker.save(path)
        return base64.b64encode(zlib.compress(path.read_bytes(), 1)).decode()


def unpacked(state: str) -> Tracker:
    """Return the tracker of a text of `packed`; raise a ConfigError or FormatError for another."""
    try:
        data = zlib.decompressobj().decompress(base64.b64decode(state), LARGEST_STATE)
    except (ValueError, zlib.error):
        raise ConfigError("A state was not made by motes; begin the track anew.") from None
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tracker"
        path.write_bytes(data)
        return Tracker.load(path)
