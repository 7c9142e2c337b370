"""Videos and pictures, a kind of input for each kind of file.

Now and then an encoder writes other bytes of the same pictures, and so the inputs are others.
"""

from functools import cache, partial

from PIL import Image

from clips import Codec, clip, picture
from motes import MotesError, open_source

from .campaign import Kind
from .outcomes import check_message, put, scratch

VIDEOS: dict[str, tuple[Codec, str]] = {
    "a.mp4": ("libx264", "yuv420p"),
    "b.mkv": ("libx264", "yuv420p"),
    "c.avi": ("mpeg4", "yuv420p"),
    "d.webm": ("libvpx", "yuv420p"),
    "e.ts": ("mpeg2video", "yuv420p"),
    "f.h264": ("libx264", "yuv420p"),
    "g.mov": ("qtrle", "rgb24"),
    "h.mkv": ("ffv1", "yuv420p"),
    "i.avi": ("mjpeg", "yuvj420p"),
}
ANIMATIONS = ("j.gif", "k.png", "l.webp", "m.tiff")
STILLS = ("n.png", "o.jpg", "p.webp", "q.tiff", "r.bmp")


@cache
def _files() -> dict[str, bytes]:
    """Return a small file of each container and codec."""
    folder = scratch() / "films"
    folder.mkdir()
    for name, (codec, form) in VIDEOS.items():
        clip(folder / name, 12, codec=codec, pix_fmt=form)
    first, *rest = (Image.fromarray(picture(index)) for index in range(6))
    for name in ANIMATIONS:
        first.save(folder / name, save_all=True, append_images=rest, duration=40)
    for name in STILLS:
        first.save(folder / name)
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def seeds(name: str) -> list[bytes]:
    return [_files()[name]]


def read(name: str, data: bytes) -> str:
    """Read all frames of a file with the ending of this name.

    Returns
    -------
    "whole"; "part" if the report names problems; "stopped" if an error ended the frames; "refused"
    if there was none.
    """
    frames, last = 0, -1.0
    try:
        with open_source(put(name, data)) as film:
            for frame in film:
                assert frame.time > last, f"time {frame.time} after {last}"
                frames, last = frames + 1, frame.time
            return "part" if film.report.problems else "whole"
    except MotesError as error:
        check_message(str(error))
        return "stopped" if frames else "refused"


KINDS = tuple(
    Kind(f"film-{name}", partial(seeds, name), partial(read, name), block=10)
    for name in (*VIDEOS, *ANIMATIONS, *STILLS)
)
