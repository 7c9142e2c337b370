"""Small films of each kind of encoding."""

from pathlib import Path
from typing import cast

from clips import Codec, clip

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
    form = "yuvj420p" if codec == "mjpeg" else "yuv420p"
    return clip(path, frames, codec=cast(Codec, codec), pix_fmt=form, options=options)
