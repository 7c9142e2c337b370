"""Frames from video files, images, cameras and streams.

`open_source` takes whatever a user names and gives a `Source`, an iterator of frames. What could
not be read is counted in its `Report`, not hidden: a damaged packet is skipped and reading goes on,
and a file that ends before its time is said to be cut off.
"""

from __future__ import annotations

import glob
import itertools
import os
import platform
import re
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, Self
from urllib.parse import urlsplit

import av
import numpy as np
from av.stream import Disposition
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray
from PIL import Image, ImageOps

from motes.errors import ConfigError, SourceError
from motes.frame import FRAME_INTERVAL, Frame, as_rgb

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.packet import Packet
    from av.video.frame import VideoFrame
    from av.video.stream import VideoStream

IMAGE_ENDINGS = frozenset(
    {".bmp", ".jpeg", ".jpg", ".pgm", ".png", ".pnm", ".ppm", ".tif", ".tiff", ".webp"}
)
MAX_BAD_PACKETS = 64
"""So many unreadable packets in a row are skipped; one more and the source is given up."""
OPEN_TIMEOUT = 5.0
READ_TIMEOUT = 5.0
"""Seconds that a camera or server may take to answer, and to send the next packet."""

_TICK = 1e-6
"""Times closer than this, in seconds, are the same but for rounding."""

_URL = re.compile(r"([a-z][a-z0-9+.-]+)://", re.IGNORECASE)
# Starting threads for each picture costs more than they save; PyAV 16 never starts any.
ONE_THREAD: dict[str, Any] = {"threads": 1} if int(av.__version__.split(".")[0]) >= 17 else {}


@dataclass(slots=True)
class Report:
    """What was read so far, and what was wrong with it.

    Attributes
    ----------
    decoded
        Pictures decoded, also those that `start` and `stride` pass over.
    skipped
        Packets that could not be decoded.
    damaged
        Pictures that were decoded with parts missing, which the decoder made up.
    retimed
        Pictures whose time stamp was missing or did not increase; they got the time of the one
        before plus the nominal interval.
    ended, expected
        Where the source ended and where its header says it ends, seconds, if it was cut off.
    """

    decoded: int = 0
    skipped: int = 0
    damaged: int = 0
    retimed: int = 0
    ended: float | None = None
    expected: float | None = None

    @property
    def truncated(self) -> bool:
        """Whether the source ended before its time."""
        return self.ended is not None

    @property
    def problems(self) -> str | None:
        """One line for people, or None if all was well."""
        parts = []
        if self.skipped:
            parts.append(f"{self.skipped} unreadable packet(s) skipped")
        if self.damaged:
            parts.append(f"{self.damaged} picture(s) damaged")
        if self.truncated:
            parts.append(f"cut off at {self.ended:.2f} s of {self.expected:.2f} s")
        if self.retimed:
            parts.append(f"{self.retimed} missing or wrong time stamp(s) replaced")
        return "; ".join(parts) or None


class _Reader(Protocol):
    """The pictures of one kind of source; every other step is the same for all kinds."""

    fps: float | None
    duration: float | None
    count: int | None
    live: bool

    def pictures(self, report: Report) -> Iterator[_Picture]:
        """Yield the pictures in order; only those whose pixels are asked for are converted."""

    def close(self) -> None: ...


_Picture = tuple[float | None, Callable[[], NDArray[np.uint8]]]
"""Time stamp in seconds, if there is one, and how to get the pixels."""


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
                raise SourceError(f"{name} holds no readable picture; {_REMEDY}")
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
    if end is not None and end <= start:
        raise ConfigError(f"end is {end}, start {start}; end must be greater.")
    name, reader = _find(str(source))
    return Source(name, reader, start, end, stride)


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
                if image.mode == "RGB":
                    return as_rgb(np.asarray(image))
                # By way of RGBA, as the transparency of a palette has nowhere to go in RGB.
                return as_rgb(np.asarray(image.convert("RGBA")))
    except FileNotFoundError:
        raise SourceError(f"There is no image {path}; check the name.") from None
    except Exception as error:  # decoders of damaged images raise nearly anything
        reason = getattr(error, "strerror", None) or "damaged, or not an image"
        raise SourceError(f"The image {path} cannot be read: {reason}; replace it.") from error


_REMEDY = "give a video, an image, or a folder of images."


def _find(source: str) -> tuple[str, _Reader]:
    """Return the name for messages and the reader of what a user named."""
    if source.isdecimal():
        return f"camera {source}", _camera(int(source))
    if url := _URL.match(source):
        if url[1].lower() not in ("http", "https", "rtsp", "rtsps"):
            raise SourceError(f"{url[1]}:// is not known; use http, https, rtsp or rtsps.")
        name = _without_password(source)
        # Over TCP, as UDP loses packets wherever there is a firewall or a full link.
        options = {"rtsp_transport": "tcp"} if url[1].lower().startswith("rtsp") else {}
        return name, _Video(
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
        raise SourceError(f"{source} is empty; {_REMEDY}")
    # With "file:", as FFmpeg would take a name with a colon for an address.
    return source, _Video(f"file:{source}", source, "check the file.")


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

    def pictures(self, report: Report) -> Iterator[_Picture]:
        for index, path in enumerate(self._paths):
            yield index * FRAME_INTERVAL, partial(read_image, path)

    def close(self) -> None:
        pass


def _camera(number: int) -> _Video:
    system = platform.system()
    name, options = f"camera {number}", {}
    if system == "Windows":
        found = [d.name for d in av.enumerate_input_devices("dshow") if "video" in d.media_types]
        if number >= len(found):
            raise SourceError(f"There is no camera {number}, only {len(found)}; connect it.")
        form, address = "dshow", f"video={found[number]}"
    elif system == "Darwin":
        # Cameras refuse the 29.97 frames per second that FFmpeg asks of them.
        form, address, options = "avfoundation", f"{number}:none", {"framerate": "30"}
    else:
        form, address = "v4l2", f"/dev/video{number}"
    advice = "connect it, or choose another number."
    return _Video(address, name, advice, form=form, options=options, remote=True)


def _rate(stream: VideoStream) -> float | None:
    """Return the nominal rate: the round one that FFmpeg guesses, if it agrees with the average."""
    guessed, average = stream.guessed_rate, stream.average_rate
    if guessed and average and abs(guessed / average - 1) > 0.05:
        guessed = average
    return float(guessed) if guessed else None


class _Video:
    """Whatever FFmpeg reads: files, streams, cameras."""

    def __init__(
        self,
        address: str,
        name: str,
        advice: str,
        *,
        form: str | None = None,
        options: dict[str, str] | None = None,
        remote: bool = False,
    ) -> None:
        self._name, self._advice, self._remote = name, advice, remote
        self._container = self._open(address, form, options)
        self._stream = self._best_stream()
        # Several threads are faster, but no two readings of a damaged file would be the same.
        self._stream.thread_type = "NONE"
        self._reformatter = VideoReformatter()
        self._bad_in_row = 0

        self.fps = _rate(self._stream)
        # Without a start there are no time stamps, and the duration is guessed from the bit rate.
        length, begin = self._container.duration, self._container.start_time
        self.duration = length / av.time_base if length and begin is not None else None
        self.live = remote and self.duration is None
        self.count = self._stream.frames or None
        if self.count is None and self.duration and self.fps:
            self.count = round(self.duration * self.fps)

    def _open(
        self, address: str, form: str | None, options: dict[str, str] | None
    ) -> InputContainer:
        try:
            container = av.open(
                address,
                format=form,
                options=options,
                metadata_errors="replace",
                timeout=(OPEN_TIMEOUT, READ_TIMEOUT) if self._remote else None,
            )
        except (av.FFmpegError, ValueError) as error:
            raise self._failure(error) from error
        if container.format.name == "tty":  # FFmpeg paints any text file
            container.close()
            raise SourceError(f"{self._name} is a text; {_REMEDY}")
        return container

    def _failure(self, error: Exception) -> SourceError:
        if isinstance(error, av.error.ExitError):
            return SourceError(f"{self._name} does not answer; {self._advice}")
        if isinstance(error, av.error.InvalidDataError):
            return SourceError(f"{self._name} is not a video, or a badly damaged one; {_REMEDY}")
        reason = getattr(error, "strerror", None) or str(error)
        return SourceError(f"{self._name} cannot be read: {reason}; {self._advice}")

    def _best_stream(self) -> VideoStream:
        """Return the first video stream that is not the cover of a record."""
        streams = [
            stream
            for stream in self._container.streams.video
            if not stream.disposition & Disposition.attached_pic
        ]
        if not streams or streams[0].codec_context is None:
            self._container.close()
            what = "holds a video of an unknown kind" if streams else "holds no video"
            raise SourceError(f"{self._name} {what}; {_REMEDY}")
        return streams[0]

    def close(self) -> None:
        self._container.close()

    def pictures(self, report: Report) -> Iterator[_Picture]:
        reached = 0.0
        for packet in self._packets(report):
            if packet.pts is not None and packet.time_base:
                # Any stream counts: sound may well go on where the pictures end.
                stop = (packet.pts + (packet.duration or 0)) * packet.time_base
                reached = max(reached, float(stop))
            if packet.stream.index != self._stream.index:
                continue
            try:
                frames = packet.decode()
            except av.FFmpegError as error:
                self._bad(report, error)
                continue
            for frame in frames:
                self._bad_in_row = 0
                report.damaged += frame.is_corrupt
                yield frame.time, partial(self._pixels, frame)
        tolerance = 2 / self.fps if self.fps else 2 * FRAME_INTERVAL
        if self.duration is not None and reached < self.duration - tolerance:
            report.ended, report.expected = reached, self.duration

    def _packets(self, report: Report) -> Iterator[Packet[Any]]:
        """Yield the packets of all streams, going on after damaged ones."""
        demux = self._container.demux()
        while True:
            try:
                packet = next(demux)
            except (StopIteration, IndexError):
                # PyAV trips in the end over streams that turned up in a damaged file on the way.
                return
            except av.error.InvalidDataError as error:
                self._bad(report, error)
                demux = self._container.demux()
                continue
            except av.FFmpegError as error:
                raise self._failure(error) from error
            yield packet

    def _bad(self, report: Report, error: Exception) -> None:
        report.skipped += 1
        self._bad_in_row += 1
        if self._bad_in_row > MAX_BAD_PACKETS:
            raise SourceError(
                f"{self._name} is damaged: {self._bad_in_row} packets in a row cannot be read "
                f"after frame {report.decoded - 1}; choose an end before that."
            ) from error

    def _pixels(self, frame: VideoFrame) -> NDArray[np.uint8]:
        try:
            converted = self._reformatter.reformat(frame, format="rgb24", **ONE_THREAD)
        except av.FFmpegError as error:
            raise SourceError(
                f"{self._name} has pixels in the form {frame.format.name}, which cannot be "
                f"converted; convert the video."
            ) from error
        pixels = converted.to_ndarray()
        if converted is frame:  # its memory is the decoder's, which may still need it
            pixels = pixels.copy()
        return as_rgb(np.rot90(pixels, round(frame.rotation / 90)))
