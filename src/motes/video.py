"""Frames from video files, images, cameras and streams.

`open_source` takes whatever a user names and gives a `Source`, an iterator of frames. What could
not be read is counted in its `Report`, not hidden.
"""

from __future__ import annotations

import glob
import itertools
import os
import re
import sys
import warnings
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Protocol, Self
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps

from motes.decoder import REMEDY, Decoder, Report, Stamped, camera
from motes.errors import ConfigError, SourceError
from motes.frame import FRAME_INTERVAL, Frame, as_rgb

IMAGE_ENDINGS = frozenset(
    {".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".pnm", ".ppm", ".tif", ".tiff", ".webp"}
)

SCHEMES = ("http", "https", "rtsp", "rtsps")

_TICK = 1e-6
"""Times closer than this, in seconds, are the same but for rounding."""

_URL = re.compile(r"([a-z][a-z0-9+.-]+)://", re.IGNORECASE)


class _Reader(Protocol):
    """The pictures of one kind of source; every other step is the same for all kinds."""

    fps: float | None
    duration: float | None
    count: int | None
    live: bool

    def pictures(self, report: Report) -> Iterator[Stamped]:
        """Yield the pictures in order; only those whose pixels are asked for are converted."""

    def close(self) -> None: ...


class Source:
    """An iterator of frames, and a context manager that closes what it reads; see `open_source`.

    Attributes
    ----------
    name
        What is read, for messages; passwords in addresses are left out.
    width, height
        Of every frame, in pixels.
    fps
        Nominal frames per second, None if unknown.
    duration
        Of the whole source in seconds, None if unknown.
    frame_count
        Estimate of how many frames the chosen range holds, None if unknown.
    live
        Whether frames come at the pace of a camera, without an end.
    report
        See `Report`; complete once the source is exhausted.
    """

    def __init__(
        self, name: str, reader: _Reader, start: int, end: int | None, stride: int
    ) -> None:
        self.name = name
        self.fps, self.duration, self.live = reader.fps, reader.duration, reader.live
        self.report = Report()
        self._reader = reader
        ends = [stop for stop in (end, reader.count) if stop is not None]
        self.frame_count = len(range(start, min(ends), stride)) if ends else None
        frames = self._select(start, end, stride)
        try:
            first = next(frames, None)
            if first is None and self.report.decoded:
                raise SourceError(
                    f"{name} has {self.report.decoded} frames, none of them from {start} on; "
                    f"choose a smaller start."
                )
            if first is None:
                raise SourceError(f"{name} holds no readable picture; {REMEDY}")
        except BaseException:
            reader.close()
            raise
        self.width, self.height = first.width, first.height
        self._frames: Iterator[Frame] = itertools.chain([first], frames)

    def _select(self, start: int, end: int | None, stride: int) -> Iterator[Frame]:
        interval = 1 / self.fps if self.fps else FRAME_INTERVAL
        size, origin, last = None, None, -interval
        pictures = itertools.islice(self._reader.pictures(self.report), end)
        for index, (stamp, load) in enumerate(pictures):
            self.report.decoded += 1
            expected = last + interval
            if origin is None and stamp is not None:
                origin = stamp - expected
            moment = expected if stamp is None or origin is None else stamp - origin
            if stamp is None or moment - last < _TICK:
                self.report.retimed += 1
                moment = expected
            last = moment
            if index < start or (index - start) % stride:
                continue
            pixels = load()
            height, width, _ = pixels.shape
            size = size or (width, height)
            if size != (width, height):
                raise SourceError(
                    f"Frame {index} of {self.name} has {width}x{height} pixels, those before "
                    f"{size[0]}x{size[1]}; split or rescale it so that all have one size."
                )
            yield Frame(index, moment, pixels)

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Frame:
        return next(self._frames)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the file, camera or connection; there are no frames after that."""
        self._frames = iter(())
        self._reader.close()


def open_source(
    source: str | int | Path, *, start: int = 0, end: int | None = None, stride: int = 1
) -> Source:
    """Open a source of frames and read up to its first chosen frame.

    Parameters
    ----------
    source
        A video file; an image; a folder of images or a pattern such as "dir/*.jpg", in the
        natural order of their names (img2 before img10); the number of a camera, 0 or "0" (write
        "./0" for a file of that name); or an http, https, rtsp or rtsps address.
    start, end, stride
        The frames with index start, start + stride, ... below end. `Frame.index` counts in the
        source: start 10 and stride 2 give 10, 12, ...

    Returns
    -------
    Source
        Its frames are upright (rotation marks are honored), RGB uint8, all of one size. Their
        times are the container's, in seconds since the first frame of the source, and strictly
        increase; images are `FRAME_INTERVAL` apart.

    Raises
    ------
    SourceError
        If there is nothing to read, now or, while iterating, later on.
    ConfigError
        If start, end and stride make no sense.
    """
    if start < 0:
        raise ConfigError(f"start is {start}; the first frame has index 0.")
    if stride < 1:
        raise ConfigError(f"stride is {stride}; give 1 for every frame, 2 for every other.")
    if end is not None and end > sys.maxsize:
        raise ConfigError(f"end is {end}; no source has so many frames, leave it out for all.")
    if end is not None and end <= start:
        raise ConfigError(f"end is {end}, start {start}; end must be greater.")
    name, reader = _find(str(source))
    return Source(name, reader, start, end, stride)


def is_remote(source: str) -> bool:
    """Return whether a source is a camera or an address, which may answer later if not now."""
    url = _URL.match(source)
    return source.isdecimal() or bool(url and url[1].lower() in SCHEMES)


def read_image(path: str | Path) -> NDArray[np.uint8]:
    """Read an image, upright, as RGB uint8 of shape (height, width, 3).

    Raises
    ------
    SourceError
        If the file is missing or not an image.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of large pictures and odd metadata
            with Image.open(path) as opened:
                image = ImageOps.exif_transpose(opened)
                if image.mode.startswith("I;16"):
                    return as_rgb(np.asarray(image).astype(np.uint16))
                if image.mode == "I":  # 16 bits of gray in 32
                    return as_rgb(np.asarray(image).clip(0, 65535).astype(np.uint16))
                if image.mode in ("RGB", "F"):
                    return as_rgb(np.asarray(image))
                # By way of RGBA, as the transparency of a palette has nowhere to go in RGB.
                return as_rgb(np.asarray(image.convert("RGBA")))
    except FileNotFoundError:
        raise SourceError(f"There is no image {path}; check the name.") from None
    except Exception as error:  # decoders of damaged images raise nearly anything
        reason = getattr(error, "strerror", None) or "damaged, or not an image"
        raise SourceError(f"The image {path} cannot be read: {reason}; replace it.") from error


def _find(source: str) -> tuple[str, _Reader]:
    """Return the name for messages and the reader of what a user named."""
    if source.isdecimal():
        return f"camera {source}", camera(int(source))
    if url := _URL.match(source):
        if not is_remote(source):
            raise SourceError(f"{url[1]}:// is not known; use http, https, rtsp or rtsps.")
        name = _without_password(source)
        # Over TCP, as UDP loses packets wherever there is a firewall or a full link.
        options = {"rtsp_transport": "tcp"} if url[1].lower().startswith("rtsp") else {}
        return name, Decoder(
            source, name, "check the address and the network.", options=options, remote=True
        )
    if os.path.isdir(source):
        return source, _Images(source, _folder(source))
    if not os.path.exists(source):
        if glob.has_magic(source):
            return source, _Images(source, glob.glob(source, recursive=True))
        raise SourceError(f"There is no file or folder {source}; check the name.")
    if os.path.splitext(source)[1].lower() in IMAGE_ENDINGS:
        return source, _Images(source, [source])
    if os.path.isfile(source) and not os.path.getsize(source):
        raise SourceError(f"{source} is empty; {REMEDY}")
    # With "file:", as FFmpeg would take a name with a colon for an address.
    return source, Decoder(f"file:{source}", source, "check the file.")


def _folder(path: str) -> list[str]:
    try:
        return [os.path.join(path, name) for name in os.listdir(path)]
    except OSError as error:
        raise SourceError(f"The folder {path} cannot be read: {error.strerror}.") from error


def _without_password(url: str) -> str:
    parts = urlsplit(url)
    return parts._replace(netloc=parts.netloc.rpartition("@")[2]).geturl()


def _natural(name: str) -> list[tuple[int, int | str]]:
    parts = re.findall(r"\d+|\D+", name)
    return [(0, int(part)) if part.isdecimal() else (1, part) for part in parts]


class _Images:
    """Image files, one frame each."""

    fps: float | None = 1 / FRAME_INTERVAL
    duration: float | None
    count: int | None
    live = False

    def __init__(self, name: str, paths: list[str]) -> None:
        self._paths = sorted(
            (
                path
                for path in paths
                if os.path.splitext(path)[1].lower() in IMAGE_ENDINGS
                and not os.path.basename(path).startswith(".")
            ),
            key=_natural,
        )
        if not self._paths:
            endings = ", ".join(sorted(IMAGE_ENDINGS))
            raise SourceError(f"There are no images in {name}; they would end in {endings}.")
        self.count = len(self._paths)
        self.duration = len(self._paths) * FRAME_INTERVAL

    def pictures(self, report: Report) -> Iterator[Stamped]:
        for index, path in enumerate(self._paths):
            yield index * FRAME_INTERVAL, partial(read_image, path)

    def close(self) -> None:
        pass
