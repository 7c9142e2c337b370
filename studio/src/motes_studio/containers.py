"""What a film says of itself, read before anything is decoded."""

from __future__ import annotations

import os
from pathlib import Path

from motes import ConfigError, MotesError, SourceError
from motes.video import IMAGE_ENDINGS, TITLE_OPTIONS
from motes_studio.safety import Limits

FORMATS = (
    "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg,ogg,asf,flv,mpegvideo,h264,hevc,av1,obu,"
    "ivf,m4v,mjpeg,mpjpeg,dv,gif,apng,mxf,gxf,nut,rm,wtv,dhav,amv,yuv4mpegpipe"
)
"""FFmpeg's formats that hold their pictures themselves; no playlist, script or address."""


def check_container(path: str, limits: Limits) -> None:
    """Check a film before it is decoded.

    Raises
    ------
    SourceError
        If it is no film, or of a format that may reach elsewhere.
    ConfigError
        If it is larger than the limits.
    """
    name = Path(path).name
    if os.path.isdir(path):
        images = [
            os.path.join(path, each)
            for each in os.listdir(path)
            if os.path.splitext(each)[1].lower() in IMAGE_ENDINGS
        ]
        for image in images[:1]:
            check_limits(name, *_image_size(image), len(images), limits)
    elif os.path.splitext(path)[1].lower() in IMAGE_ENDINGS:
        check_limits(name, *_image_size(path), 1, limits)
    else:
        _check_video(path, name, limits)


def check_limits(name: str, width: int, height: int, frames: int, limits: Limits) -> None:
    """Raise a ConfigError if a film has too many pixels or frames."""
    if width * height > limits.pixels:
        raise ConfigError(
            f"{name} has {width}x{height} pixels, more than {limits.pixels:,}; rescale it."
        )
    if frames > limits.frames:
        raise ConfigError(f"{name} has {frames} frames, more than {limits.frames:,}; cut it.")


def _check_video(path: str, name: str, limits: Limits) -> None:
    import av

    options = {"format_whitelist": FORMATS, "protocol_whitelist": "file"}
    try:
        with av.open(f"file:{path}", options=options, **TITLE_OPTIONS) as container:
            for stream in container.streams.video:
                size = stream.codec_context.width, stream.codec_context.height
                check_limits(name, *size, stream.frames, limits)
    except (av.FFmpegError, ValueError) as error:
        if isinstance(error, MotesError):
            raise
        raise SourceError(
            f"{name} is not a video, or of a kind that the studio does not open; convert it."
        ) from None


def _image_size(path: str) -> tuple[int, int]:
    from PIL import Image

    try:
        with Image.open(path) as image:
            return image.size
    except (OSError, ValueError, Image.DecompressionBombError):
        raise SourceError(f"{Path(path).name} is no image that can be read.") from None
