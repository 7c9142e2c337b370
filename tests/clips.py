"""Small videos for tests: whole, cut, damaged, rotated, with odd timing."""

import itertools
import random
import struct
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import Literal

import av
import numpy as np
from numpy.typing import NDArray

from motes import Frame, VideoWriter

Pixels = NDArray[np.uint8]
Codec = Literal[
    "libx264", "libvpx", "ffv1", "qtrle", "mjpeg", "mpeg4", "mpeg1video", "mpeg2video",
    "wrapped_avframe",
]  # fmt: skip


def write_pictures(
    path: str | Path, pictures: Iterable[Pixels], fps: float = 25, times: Iterable[float] = ()
) -> None:
    """Write pictures, one for each time if there are any."""
    with VideoWriter(path, fps) as writer:
        for pixels, time in itertools.zip_longest(pictures, times):
            writer.write(pixels, time)


def write_film(path: str | Path, clip: Iterable[tuple[Frame, object]], fps: float = 25) -> None:
    """Write the frames of a rendered clip."""
    write_pictures(path, (frame.pixels for frame, _ in clip), fps)


def picture(index: int, width: int = 64, height: int = 48) -> Pixels:
    """Return picture number `index`: smooth colors that drift, and a white block top left."""
    y, x = np.mgrid[:height, :width]
    planes = [
        128 + 60 * np.sin((x + 2 * index) / 9),
        128 + 60 * np.cos((y - index) / 7),
        128 + 60 * np.sin((x + y + index) / 11),
    ]
    pixels = np.stack(planes, axis=2).astype(np.uint8)
    pixels[: height // 4, : width // 4] = 255
    return pixels


def noise(index: int, width: int = 64, height: int = 48) -> Pixels:
    """Return a picture that compresses badly, so that its packet is large."""
    return np.random.default_rng(index).integers(0, 256, (height, width, 3), np.uint8)


def clip(
    path: Path,
    frames: int = 30,
    *,
    width: int = 64,
    height: int = 48,
    fps: int = 25,
    times_ms: list[int] | None = None,
    codec: Codec = "libx264",
    pix_fmt: str = "yuv420p",
    noisy: bool = False,
    options: dict[str, str] | None = None,
) -> Path:
    """Write a video of `picture` (or `noise`) 0, 1, ...; options go to the encoder."""
    muxing = {"fflags": "+bitexact"}  # else Matroska has a random identity in it
    if path.suffix in (".mp4", ".mov"):
        muxing["movflags"] = "+faststart"
    with av.open(str(path), "w", options=muxing) as container:
        stream = container.add_stream(codec, rate=fps, options=options)
        stream.width, stream.height, stream.pix_fmt = width, height, pix_fmt
        stream.codec_context.time_base = Fraction(1, 1000) if times_ms else Fraction(1, fps)
        draw = noise if noisy else picture
        for index in range(frames):
            frame = av.VideoFrame.from_ndarray(draw(index, width, height), format="rgb24")
            frame.pts = times_ms[index] if times_ms else index
            frame.time_base = stream.codec_context.time_base
            container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def remuxed(path: Path, **options: str) -> bytes:
    """Return the pictures of a film in a file of their own, made with these options."""
    other = path.with_stem("remuxed")
    with av.open(str(path)) as film, av.open(str(other), "w", options=options) as made:
        stream = made.add_stream_from_template(film.streams.video[0])
        for packet in film.demux(film.streams.video[0]):
            if packet.dts is not None:
                packet.stream = stream
                made.mux(packet)
    return other.read_bytes()


def cut(path: Path, share: float) -> Path:
    """Return a copy of a file that holds only its first part."""
    return _copy(path, path.read_bytes()[: int(path.stat().st_size * share)])


def damage(path: Path, flips: int = 200, seed: int = 0) -> Path:
    """Return a copy of a file with bytes changed in its middle half."""
    data, rng = bytearray(path.read_bytes()), random.Random(seed)
    for _ in range(flips):
        data[rng.randrange(len(data) // 4, 3 * len(data) // 4)] ^= rng.randrange(1, 256)
    return _copy(path, bytes(data))


def mark(path: Path, a: int, b: int, c: int, d: int) -> Path:
    """Return a copy of an MP4 with a mark to show (x, y) at (a x + c y, b x + d y)."""
    data = bytearray(path.read_bytes())
    matrix = data.index(b"tkhd") + 4 + 40  # in a version 0 header
    fixed = [a << 16, b << 16, 0, c << 16, d << 16, 0, 0, 0, 1 << 30]
    data[matrix : matrix + 36] = struct.pack(">9i", *fixed)
    return _copy(path, bytes(data))


def _copy(path: Path, data: bytes) -> Path:
    copy = path.with_stem(path.stem + "-changed")
    copy.write_bytes(data)
    return copy


def silence(samples: int) -> av.AudioFrame:
    """Return sound at 8000 samples a second."""
    silent = np.zeros((1, samples), np.int16)
    frame = av.AudioFrame.from_ndarray(silent, format="s16", layout="mono")
    frame.sample_rate = 8000
    return frame


def sound_only(path: Path) -> Path:
    """Write sound without pictures."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("pcm_s16le", rate=8000)
        container.mux(stream.encode(silence(8000)))
        container.mux(stream.encode(None))
    return path


def packets(path: Path) -> list[tuple[int, int]]:
    """Return where in the file each picture's bytes are, and how many, in decoding order."""
    with av.open(str(path)) as container:
        return [(each.pos or 0, each.size) for each in container.demux(video=0) if each.size]


def spoil(path: Path, first: int, count: int) -> Path:
    """Return a copy of a video in which `count` packets from number `first` on hold zeros."""
    data = bytearray(path.read_bytes())
    with av.open(str(path)) as container:
        for packet in itertools.islice(container.demux(video=0), first, first + count):
            position = data.index(bytes(packet))
            data[position : position + packet.size] = bytes(packet.size)
    return _copy(path, bytes(data))
