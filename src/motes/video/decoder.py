"""Pictures from whatever FFmpeg reads: files, streams and cameras.

What could not be read is counted in a `Report`, not hidden: a damaged packet is skipped and reading
goes on, and a file that ends before its time is said to be cut off.
"""

from __future__ import annotations

import contextlib
import errno
import math
import platform
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, Any

import av
import numpy as np
from av.sidedata.sidedata import Type as SideData
from av.stream import Disposition
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray

from motes.core.errors import SourceError
from motes.core.frame import FRAME_INTERVAL, as_rgb
from motes.video.pace import Pace
from motes.video.prefetch import prefetch

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.packet import Packet
    from av.video.frame import VideoFrame
    from av.video.stream import VideoStream

Stamped = tuple[float | None, Callable[[], NDArray[np.uint8]]]
"""Time stamp in seconds, if there is one, and how to get the pixels."""

MAX_BAD_PACKETS = 64
"""So many unreadable packets in a row are skipped; one more and the source is given up."""
OPEN_TIMEOUT = 5.0
READ_TIMEOUT = 5.0
"""Seconds that a camera or server may take to answer, and to send the next packet."""
BACKLOG = 2000
"""So many packets of a live source are received before they are asked for: a minute or so."""
REMEDY = "give a video, an image, or a folder of images."

ASPECT = 1.25
"""Pixels that are wider, or higher, than that are said to be: round objects look no longer so."""
LIVE_FORMATS = ("hls", "mpjpeg", "rtsp")
"""FFmpeg's names for what has no end unless it says how long it is."""

_PYAV = int(av.__version__.split(".")[0])
# Starting threads for each picture costs more than they save; PyAV 16 never starts any.
ONE_THREAD: dict[str, Any] = {"threads": 1} if _PYAV >= 17 else {}
# A title may be in any encoding; PyAV 19 knows that.
_ANY_TITLE: dict[str, Any] = {"metadata_errors": "replace"} if _PYAV < 19 else {}


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
    left_out
        Pictures after the first one in animated files among other images.
    drops
        How often a live source ended or failed, and was to be opened again.
    aspect
        How many times as wide as high the pixels are, 1 if that is not known; frames are given
        as they are stored.
    """

    decoded: int = 0
    skipped: int = 0
    damaged: int = 0
    retimed: int = 0
    ended: float | None = None
    expected: float | None = None
    left_out: int = 0
    drops: int = 0
    aspect: float = 1.0

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
        if self.left_out:
            parts.append(
                f"{self.left_out} picture(s) left out, those after the first in an animated file"
            )
        if self.drops:
            parts.append(f"dropped {self.drops} time(s)")
        if not 1 / ASPECT < self.aspect < ASPECT:
            parts.append(f"pixels are {self.aspect:.2f} times as wide as high, and left so")
        return "; ".join(parts) or None


class Decoder:
    """The first video of a file, a stream or a camera.

    Parameters
    ----------
    address
        As FFmpeg takes it.
    name
        What it is called in messages.
    advice
        What to do where it cannot be read.
    form, options
        FFmpeg's format and options, where it does not find them by itself.
    remote
        Whether to wait no longer than `OPEN_TIMEOUT` and `READ_TIMEOUT`.

    Attributes
    ----------
    fps
        Nominal frames per second, None if unknown.
    duration
        Seconds, None if unknown.
    count
        Estimate of how many pictures there are, None if unknown.
    live
        Whether pictures may come at the pace of a camera, without an end: nothing tells how long
        the source is.

    Raises
    ------
    SourceError
        Here, if there is no video to read; later, if it ends in an error or is too damaged, or if
        it is live and ends.
    """

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
        self._pace = Pace()
        self._container = self._open(address, form, options)
        self._stream = self._best_stream()
        # Several threads are faster, but no two readings of a damaged file would be the same.
        self._stream.thread_type = "NONE"
        self._reformatter = VideoReformatter()
        self._bad_in_row = 0
        self._reached = 0.0

        kind = self._container.format.name
        # It sends JPEGs without times, so they count from when they come.
        self._untimed = remote and kind == "mpjpeg"
        self._camera = form is not None or kind in LIVE_FORMATS
        self._unsized = remote and self._container.size <= 0
        self._failed: av.FFmpegError | None = None
        self.fps = None if self._untimed else _rate(self._stream)
        # Without a start there are no time stamps, and the duration is guessed from the bit rate;
        # but Matroska, cut off after its first picture, still has it in its header.
        length: int | None = self._container.duration
        begin: int | None = self._container.start_time
        known = begin is not None or "matroska" in kind
        self.duration = length / av.time_base if length and known else None
        self.live = self.duration is None and (self._unsized or (remote and self._camera))
        self.count = self._stream.frames or None
        if self.count is None and self.duration and self.fps:
            self.count = round(self.duration * self.fps)

    def _open(
        self, address: str, form: str | None, options: dict[str, str] | None
    ) -> InputContainer:
        try:
            container: InputContainer = av.open(
                address,
                format=form,
                options=options,
                timeout=(OPEN_TIMEOUT, READ_TIMEOUT) if self._remote else None,
                **_ANY_TITLE,
            )
        except (av.FFmpegError, ValueError) as error:
            raise self._failure(error) from error
        if container.format.name == "tty":  # FFmpeg paints any text file
            container.close()
            raise SourceError(f"{self._name} is a text; {REMEDY}")
        return container

    def _failure(self, error: Exception) -> SourceError:
        if isinstance(error, av.error.ExitError):
            return SourceError(f"{self._name} does not answer; {self._advice}")
        if isinstance(error, av.error.InvalidDataError):
            return SourceError(f"{self._name} is not a video, or a badly damaged one; {REMEDY}")
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
            raise SourceError(f"{self._name} {what}; {REMEDY}")
        return streams[0]

    def file_of(self, index: int) -> str | None:
        """Return None: pictures of a video are in no file of their own."""
        return None

    def close(self) -> None:
        """Let go of the file or connection."""
        self._container.close()

    @property
    def recorded(self) -> bool:
        """Whether the source has an end, as far as is known: see `Pace` for what does not say."""
        return not self.live or (not self._camera and self._pace.recorded)

    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures in order, and count in `report` what could not be read.

        Close this iterator before the decoder: a thread may be reading.
        """
        report.aspect = float(self._stream.codec_context.sample_aspect_ratio or 1)
        packets = self._packets(report)
        with prefetch(packets, BACKLOG) if self.live else contextlib.nullcontext(packets) as ready:
            for packet in ready:
                if packet.stream.index == self._stream.index:
                    yield from self._decoded(packet, report)
                else:  # it counts as well: sound may go on where the pictures end
                    self._reach(packet)
        if self._failed is not None:
            yield from self._decoded(None, report)  # what the decoder still holds back
            # Where an answer over HTTP does not say how long it is, its end is no failure.
            if not (self._unsized and self._failed.errno == errno.EIO):
                raise self._failure(self._failed) from self._failed
        if not self.recorded:
            raise SourceError(f"{self._name} ended.")
        tolerance = 2 / self.fps if self.fps else 2 * FRAME_INTERVAL
        if self.duration is not None and self._reached < self.duration - tolerance:
            report.ended, report.expected = self._reached, self.duration

    def _reach(self, part: Packet[Any] | VideoFrame) -> None:
        """Note how far the source goes."""
        if part.pts is not None and part.time_base:
            stop = (part.pts + (part.duration or 0)) * part.time_base
            self._reached = max(self._reached, float(stop))

    def _decoded(self, packet: Packet[Any] | None, report: Report) -> Iterator[Stamped]:
        """Yield the pictures that a packet completes; None stands for the end."""
        try:
            frames = packet.decode() if packet is not None else self._stream.decode(None)
        except av.FFmpegError as error:
            self._bad(report, error)
            return
        for frame in frames:
            self._bad_in_row = 0
            report.damaged += frame.is_corrupt
            if packet is None:  # which would have said in what its time is
                frame.time_base = self._stream.time_base
            self._reach(frame)
            yield frame.time, partial(self._pixels, frame)

    def _packets(self, report: Report) -> Iterator[Packet[Any]]:
        """Yield the packets of all streams, going on after damaged ones."""
        demux = self._container.demux()
        while True:
            try:
                packet = next(demux)
            except (StopIteration, IndexError):
                # PyAV trips in the end over streams that turned up in a damaged file on the way.
                return
            except (av.error.InvalidDataError, av.error.BlockingIOError) as error:
                self._bad(report, error)
                demux = self._container.demux()
                continue
            except av.FFmpegError as error:
                self._failed = error
                return
            if packet.stream.index == self._stream.index and packet.size and packet.time_base:
                stamp = None if packet.dts is None else float(packet.dts * packet.time_base)
                passed = self._pace.note(stamp)
                if self._untimed:
                    packet.time_base = Fraction(1, 1000)
                    packet.pts = packet.dts = round(passed * 1000)
            yield packet

    def _bad(self, report: Report, error: Exception) -> None:
        report.skipped += 1
        self._bad_in_row += 1
        if self._bad_in_row > MAX_BAD_PACKETS:
            where = (
                f"after frame {report.decoded - 1}; choose an end before that."
                if report.decoded
                else f"at its beginning; {REMEDY}"
            )
            raise SourceError(
                f"{self._name} is damaged: {self._bad_in_row} packets in a row cannot be read "
                f"{where}"
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
        return as_rgb(_upright(np.asarray(pixels, np.uint8), _display_matrix(frame)))


def camera(number: int) -> Decoder:
    """Return the decoder of a camera of this machine, by its number from 0."""
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
    return Decoder(address, name, advice, form=form, options=options, remote=True)


def _display_matrix(frame: VideoFrame) -> NDArray[np.int32]:
    """Return how a picture is shown, (2, 2): what is at (x, y) is shown at (x, y) @ matrix."""
    try:
        side_data: Mapping[Any, Any] = frame.side_data
    except ValueError:  # beside a kind that PyAV does not know, it tells only the angle
        cos, sin = round(math.cos(angle := math.radians(-frame.rotation))), round(math.sin(angle))
        return np.array([[cos, sin], [-sin, cos]], np.int32)
    found = side_data.get(SideData.DISPLAYMATRIX)
    if found is None:
        return np.eye(2, dtype=np.int32)
    return np.frombuffer(bytes(found), np.int32).reshape(3, 3)[:2, :2]


def _upright(pixels: NDArray[np.uint8], matrix: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Return a picture turned and mirrored by a display matrix, to the nearest 90 degrees."""
    across, along = matrix.diagonal().tolist(), matrix[::-1].diagonal().tolist()
    if abs(along[1]) > abs(across[0]):
        pixels, across = pixels.swapaxes(0, 1), along
    if across[0] < 0:
        pixels = pixels[:, ::-1]
    return pixels[::-1] if across[1] < 0 else pixels


def _rate(stream: VideoStream) -> float | None:
    """Return the nominal rate: the round one that FFmpeg guesses, if it agrees with the average."""
    guessed, average = stream.guessed_rate, stream.average_rate
    timed = stream.start_time is not None  # otherwise the average is FFmpeg's default
    if guessed and average and timed and abs(guessed / average - 1) > 0.05:
        guessed = average
    return float(guessed) if guessed else None
