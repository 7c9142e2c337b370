"""Small films of each kind of encoding."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import av
import numpy as np

from oracles import mosaic

KINDS: dict[str, tuple[str, str, dict[str, str]]] = {
    "h264": ("libx264", "mp4", {"g": "8", "bf": "2"}),
    "open_groups": ("libx264", "mkv", {"g": "8", "bf": "2", "x264-params": "open-gop=1"}),
    "one_group": ("libx264", "mp4", {"g": "250"}),
    "mpeg1": ("mpeg1video", "mpg", {"g": "6", "bf": "2"}),
    "mpeg4": ("mpeg4", "avi", {"g": "10"}),
    "transport": ("mpeg2video", "ts", {"g": "6", "bf": "2"}),
    "mjpeg": ("mjpeg", "avi", {}),
}


def video(path: Path, codec: str, options: dict[str, str], frames: int = 30) -> Path:
    """Write a film whose pictures all differ."""
    with av.open(str(path), "w") as container:
        stream: Any = container.add_stream(codec, 25, options=options)
        stream.width, stream.height = 64, 48
        stream.pix_fmt = "yuvj420p" if codec == "mjpeg" else "yuv420p"
        for i in range(frames):
            pixels = np.roll(mosaic(3, 48, 64), 2 * i, axis=1)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(pixels, format="rgb24")))
        container.mux(stream.encode(None))
    return path
