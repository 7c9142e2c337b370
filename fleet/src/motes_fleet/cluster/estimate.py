"""How much memory a job needs, from the size of its frames and its preset.

The memory is the largest resident memory of `motes track` and `motes watch`, measured from 320x240
to 3840x2160 pixels (`benchmarks/cluster_memory.py`, lab/docs/scale.md): a constant, and bytes for
each pixel.
"""

from __future__ import annotations

import contextlib
import glob
import os

from motes.video import HELD, IMAGE_ENDINGS
from motes_fleet.cluster.jobs import Job

PARTICLES, DEFAULT, WATCH, NETWORK = 80 << 20, 100 << 20, 160 << 20, 40 << 20
"""Bytes for a preset with particles, the default tracker, many objects, and a trained network."""
TRACK_PIXEL, WATCH_PIXEL = 54, 215
"""Bytes for each pixel of a frame."""
MARGIN = 1.25
"""Films differ in what their decoder keeps."""
UNKNOWN = (1920, 1080)
"""Size of frames that are not on this machine."""


def memory_of(job: Job) -> int:
    """Return the bytes that a job is expected to need."""
    width, height = frame_size(job.source) or UNKNOWN
    pixels = width * height
    if job.do == "watch":
        return int(MARGIN * (WATCH + WATCH_PIXEL * pixels))
    base = DEFAULT if job.preset in (None, "default") else PARTICLES
    base += NETWORK if job.network else 0
    held = 0 if job.keyframes is None else HELD
    return int(MARGIN * (base + TRACK_PIXEL * pixels + held))


def frame_size(source: str) -> tuple[int, int] | None:
    """Return width and height from the head of a film or image; None if they are not known."""
    if "://" in source:
        return None
    if os.path.isdir(source):
        with os.scandir(source) as entries:
            source = next((entry.path for entry in entries if _is_image(entry.path)), source)
    elif not os.path.exists(source):
        source = next(iter(glob.glob(source)), source)
    with contextlib.suppress(Exception):  # whoever reads all of it explains what is wrong
        return _size_of_image(source) if _is_image(source) else _size_of_video(source)
    return None


def _is_image(path: str) -> bool:
    return os.path.splitext(path)[1].lower() in IMAGE_ENDINGS


def _size_of_image(path: str) -> tuple[int, int]:
    from PIL import Image

    with Image.open(path) as image:
        return image.size


def _size_of_video(path: str) -> tuple[int, int]:
    import av

    with av.open(f"file:{path}") as container:
        stream = container.streams.video[0]
        return stream.width, stream.height
