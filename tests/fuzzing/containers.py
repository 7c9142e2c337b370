"""Video and image files of every kind, damaged."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from clips import Codec, clip, picture
from motes.core.errors import MotesError
from motes.video.sources import open_source

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

Damage = Callable[[np.random.Generator, bytearray], None]


def seed_files(folder: Path) -> list[Path]:
    """Write a small file of each container and codec, and return them."""
    paths = [
        clip(folder / name, 12, codec=codec, pix_fmt=form) for name, (codec, form) in VIDEOS.items()
    ]
    first, *rest = (Image.fromarray(picture(index)) for index in range(6))
    for name in ANIMATIONS:
        paths.append(folder / name)
        first.save(paths[-1], save_all=True, append_images=rest, duration=40)
    for name in STILLS:
        paths.append(folder / name)
        first.save(paths[-1])
    return paths


def damage(rng: np.random.Generator, data: bytes) -> bytes:
    """Return data with one to three kinds of damage."""
    damaged = bytearray(data)
    for _ in range(int(rng.integers(1, 4))):
        if damaged:
            KINDS[int(rng.integers(len(KINDS)))](rng, damaged)
    return bytes(damaged)


def _flip(rng: np.random.Generator, data: bytearray) -> None:
    """Change single bits."""
    for place in rng.integers(len(data), size=int(rng.integers(1, 40))):
        data[place] ^= 1 << int(rng.integers(8))


def _cut(rng: np.random.Generator, data: bytearray) -> None:
    """Cut off the end."""
    del data[int(rng.integers(len(data))) :]


def _remove(rng: np.random.Generator, data: bytearray) -> None:
    """Take out a piece."""
    del data[_piece(rng, data)]


def _swap(rng: np.random.Generator, data: bytearray) -> None:
    """Copy a piece over another place."""
    piece = bytes(data[_piece(rng, data)])
    place = int(rng.integers(len(data)))
    data[place : place + len(piece)] = piece


def _fill(rng: np.random.Generator, data: bytearray) -> None:
    """Overwrite a piece with zeros, ones or noise."""
    piece = _piece(rng, data)
    size = len(data[piece])
    data[piece] = (bytes(size), b"\xff" * size, rng.bytes(size))[int(rng.integers(3))]


def _header(rng: np.random.Generator, data: bytearray) -> None:
    """Change bytes among the first."""
    for place in rng.integers(min(len(data), 512), size=int(rng.integers(1, 6))):
        data[place] = int(rng.integers(256))


def _length(rng: np.random.Generator, data: bytearray) -> None:
    """Put an extreme or small number where a length may be."""
    size, order = int(rng.choice([2, 4, 8])), ("big", "little")[int(rng.integers(2))]
    value = (
        int(rng.choice([0, 1, 255, 2**15, 2**16 - 1]))
        if rng.random() < 0.5
        else 2 ** (8 * size) - 1
    )
    place = int(rng.integers(max(1, len(data) - size)))
    data[place : place + size] = value.to_bytes(size, order)  # type: ignore[arg-type]


KINDS: tuple[Damage, ...] = (_flip, _cut, _remove, _swap, _fill, _header, _length)


def _piece(rng: np.random.Generator, data: bytearray) -> slice:
    first = int(rng.integers(len(data)))
    return slice(first, first + int(rng.integers(1, max(2, len(data) // 8))))


def check(path: Path) -> str:
    """Read all frames of a file; raise whatever is neither an end nor a MotesError of one line.

    Returns
    -------
    "whole"; "part" if the report names problems; "stopped" if an error ended the frames; "refused"
    if there was none.
    """
    frames = 0
    try:
        with open_source(path) as film:
            last = -1.0
            for frame in film:
                assert frame.time > last, f"time {frame.time} after {last}"
                frames, last = frames + 1, frame.time
            return "part" if film.report.problems else "whole"
    except MotesError as error:
        if "\n" in str(error):
            raise ValueError("this error takes more than one line") from error
        return "stopped" if frames else "refused"
