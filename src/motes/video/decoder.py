"""Pictures from everything that FFmpeg reads: files, streams and cameras.

Errors are counted in a `Report`, not hidden. A damaged packet is skipped and reading goes on; a
file that ends too early is reported as cut off.
"""

from __future__ import annotations

import contextlib
import errno
import itertools
import math
import os
import platform
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import AbstractContextManager
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
from motes.core.frame import DEPTHS, FRAME_INTERVAL, as_rgb, depth_of
from motes.video.pace import Pace
from motes.video.pipe import Pipe
from motes.video.prefetch import QUEUE_SIZE, check_reader, prefetch
from motes.video.report import DEPTH_SAMPLES, Reader, Report, Stamped

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.packet import Packet
    from av.video.frame import VideoFrame
    from av.video.stream import VideoStream

MAX_BAD_PACKETS = 64
"""Unreadable packets in a row that are skipped; one more ends the reading with an error."""
OPEN_TIMEOUT = 5.0
READ_TIMEOUT = 5.0
"""Seconds within which a camera or server must answer, and must send the next packet."""
DEPTH_REACH = 32
"""Pictures after a key picture that are decoded at most to reach one whose depth is found."""
PACKETS_AHEAD = 2000
"""Packets of a live source that are received before they are used: about one minute."""
REMEDY = "give a video, an image, or a folder of images."

LIVE_FORMATS = ("hls", "mpjpeg", "rtsp")
"""FFmpeg's names of formats that have no end unless they give a duration."""

ONE_THREAD = 1
"""To start threads for each picture takes longer than they save."""
# A title may be in any encoding; PyAV 19 accepts that by itself.
TITLE_OPTIONS: dict[str, Any] = (
    {"metadata_errors": "replace"} if int(av.__version__.split(".")[0]) < 19 else {}
)


class Decoder(Reader):
    """The first video of a file, a stream or a camera.

    Raises a SourceError when it is opened, if there is no video to read. Later, if it ends in an
    error, is too damaged, or is live and ends. The address is in FFmpeg's form; or a pipe, which is
    closed with the decoder. Messages begin with `name` and end with `advice`, what to do if it
    cannot be read. One that is `remote` is not waited for longer than `OPEN_TIMEOUT` and
    `READ_TIMEOUT`.

    Attributes
    ----------
    keys
        The time stamps of the key pictures so far: those that need no others.
    matrices
        The display matrices so far, by the angles of the pictures.
    """

    def __init__(
        self,
        address: str | Pipe,
        name: str,
        advice: str,
        *,
        format_name: str | None = None,
        options: dict[str, str] | None = None,
        remote: bool = False,
    ) -> None:
        self._name, self._advice, self._remote = name, advice, remote
        self._pipe = address if isinstance(address, Pipe) else None
        self._address = "" if self._pipe is not None else str(address)
        self._depth: int | None = None
        self._pace = Pace()
        self._container = self._open(address, format_name, options)
        self._stream = self._best_stream()
        # Several threads are faster, but a damaged file would be decoded differently each time.
        self._stream.thread_type = "NONE"
        self._reformatter = VideoReformatter()
        self._failures_in_row = 0
        self._owner = os.getpid()  # a child of it would move on in the same file
        self._reached = 0.0
        self.keys: list[float] = []
        self._goal = 0.0
        self.matrices: dict[int, NDArray[np.int32]] = {}

        kind = self._container.format.name
        # This format sends JPEG images without times; their times of arrival are used.
        self._untimed = remote and kind == "mpjpeg"
        self._camera = format_name is not None or kind in LIVE_FORMATS
        self._in_pieces = kind == "hls"  # of some seconds each, which arrive at once
        size: int | None = self._container.size  # PyAV 19 has None, others a number below one
        self._unknown_length = remote and (size is None or size <= 0)
        self._read_error: av.FFmpegError | None = None
        self.fps = None if self._untimed else _rate(self._stream)
        # Without a start time there are no time stamps, and FFmpeg guesses the duration from the
        # bit rate. Matroska is an exception: cut off after its first picture, it still has the
        # duration in its header.
        length: int | None = self._container.duration
        begin: int | None = self._container.start_time
        known = begin is not None or "matroska" in kind
        self.duration = length / av.time_base if length and known else None
        self.live = self.duration is None and (self._unknown_length or (remote and self._camera))
        self.count = self._stream.frames or None
        if self.count is None and self.duration and self.fps:
            self.count = round(self.duration * self.fps)

    def _open(
        self, address: str | Pipe, format_name: str | None, options: dict[str, str] | None
    ) -> InputContainer:
        opening: Callable[[], InputContainer] = partial(
            av.open,
            address,
            format=format_name,
            options=options,
            timeout=(OPEN_TIMEOUT, READ_TIMEOUT) if self._remote else None,
            **TITLE_OPTIONS,
        )
        try:
            container = opening() if self._pipe is None else self._pipe.in_thread(opening)
        except (av.FFmpegError, ValueError) as error:
            raise self._failure(error) from error
        if container.format.name == "tty":  # FFmpeg draws any text file as a video
            container.close()
            raise SourceError(f"{self._name} is a text file; {REMEDY}")
        return container

    def _failure(self, error: Exception) -> SourceError:
        if isinstance(error, av.error.ExitError):
            return SourceError(f"{self._name} does not answer; {self._advice}")
        if isinstance(error, av.error.InvalidDataError):
            return SourceError(f"{self._name} is not a video, or a badly damaged one; {REMEDY}")
        reason = getattr(error, "strerror", None) or str(error)
        return SourceError(f"{self._name} cannot be read: {reason}; {self._advice}")

    def _best_stream(self) -> VideoStream:
        """Return the first video stream that is not the cover picture of an album."""
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

    def close(self) -> None:
        """Close the file or connection."""
        self._container.close()
        if self._pipe is not None:
            self._pipe.close()

    def stop(self) -> None:
        """Stop waiting for a pipe."""
        if self._pipe is not None:
            self._pipe.stop()

    def seek(self, stamp: float) -> None:
        """Go to the last key picture up to a time stamp, or near it; then call `pictures`.

        Raises a SourceError if this file cannot be read from the middle.
        """
        unit = self._stream.time_base or Fraction(1, av.time_base)
        try:
            self._container.seek(round(stamp / unit), stream=self._stream)
        except av.FFmpegError as error:
            raise self._failure(error) from error

    def index(self) -> list[tuple[float, bool]] | None:
        """Return the time stamp of each picture, in order, and whether it is a key picture.

        Nothing is decoded, so damage is not found. Then open the file anew. None if pictures have
        no stamps.
        """
        found = []
        try:
            for packet in self._container.demux(self._stream):
                if not packet.size or packet.is_discard:
                    continue
                if packet.pts is None or packet.time_base is None:
                    return None
                found.append((float(packet.pts * packet.time_base), packet.is_keyframe))
        except av.FFmpegError:
            return None
        return sorted(found)

    def pictures_from(self, stamp: float, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures from a time stamp on, after `seek`, quickly; count errors in `report`.

        Earlier pictures that no other one needs are not decoded: where the file is damaged, pixels
        may differ from those of `pictures`. `skip_to` moves the stamp on.
        """
        self._goal = stamp
        for packet in self._container.demux(self._stream):
            if packet.pts is not None and packet.time_base is not None:
                early = float(packet.pts * packet.time_base) < self._goal
                self._stream.codec_context.skip_frame = "NONREF" if early else "DEFAULT"
            before = report.damaged
            for found, load in self._decoded(packet if packet.size else None, report):
                if found is not None and found >= self._goal:
                    yield found, load
                else:
                    report.damaged = before  # it may need pictures from before the seek
            check_reader(self._owner)

    def skip_to(self, stamp: float) -> None:
        """Let `pictures_from` go on with a later time stamp."""
        self._goal = stamp

    @property
    def seekable(self) -> bool:
        """Whether the source is a file, of which later pictures can be had at any time."""
        return not self._remote and self._pipe is None

    @property
    def recorded(self) -> bool:
        """Whether the source is known to have an end; without a duration, `Pace` decides."""
        return not self.live or (not self._camera and self._pace.recorded)

    @property
    def realtime(self) -> bool:
        """Whether pictures certainly arrive in real time, so that old ones may be left out."""
        decided = self._camera or self._pace.settled
        return self.live and not self._in_pieces and not self.recorded and decided

    def pictures(self, report: Report) -> Generator[Stamped, None, None]:
        """Yield the pictures in order; count errors in `report`.

        Close this iterator before the decoder: a thread may be reading.
        """
        report.aspect = float(self._stream.codec_context.sample_aspect_ratio or 1)
        packets = self._packets(report)
        waiting: AbstractContextManager[Iterator[Packet[Any]]] = contextlib.nullcontext(packets)
        if self.live or self._pipe is not None:
            waiting = prefetch(packets, PACKETS_AHEAD if self.live else QUEUE_SIZE)
        with waiting as ready, contextlib.ExitStack() as reading:
            reading.callback(self.stop)
            for packet in ready:
                if packet.stream.index == self._stream.index:
                    yield from self._decoded(packet, report)
                else:  # other streams count too: sound may go on after the last picture
                    self._extend_end(packet)
        if (error := self._read_error) is not None:
            yield from self._decoded(None, report)  # pictures that the decoder still holds back
        self._check_index(report)
        # An answer over HTTP without a length may end with this error; it is no failure.
        if error is not None and not (self._unknown_length and error.errno == errno.EIO):
            raise self._failure(error) from error
        if not self.recorded:
            raise SourceError(f"{self._name} ended.")
        tolerance = 2 / self.fps if self.fps else 2 * FRAME_INTERVAL
        if self.duration is not None and self._reached < self.duration - tolerance:
            report.ended, report.expected = self._reached, self.duration

    def _extend_end(self, part: Packet[Any] | VideoFrame) -> None:
        """Move the end reached so far to the end of a packet or picture."""
        if part.pts is not None and part.time_base:
            stop = (part.pts + (part.duration or 0)) * part.time_base
            self._reached = max(self._reached, float(stop))

    def _decoded(self, packet: Packet[Any] | None, report: Report) -> Iterator[Stamped]:
        """Yield the pictures that a packet completes; None means the end of the source."""
        try:
            frames = packet.decode() if packet is not None else self._stream.decode(None)
        except av.FFmpegError as error:
            self._count_failure(report, error)
            return
        for frame in frames:
            self._failures_in_row = 0
            report.damaged += frame.is_corrupt
            if packet is None:  # a packet would have given the unit of time
                frame.time_base = self._stream.time_base
            self._extend_end(frame)
            if frame.key_frame and frame.time is not None:
                self.keys.append(frame.time)
            yield frame.time, partial(self._pixels, frame, report)

    def _packets(self, report: Report) -> Iterator[Packet[Any]]:
        """Yield the packets of all streams; go on after damaged ones."""
        demux = self._container.demux()
        while True:
            check_reader(self._owner)
            try:
                packet = next(demux)
            except (StopIteration, IndexError):
                # At the end, PyAV raises an IndexError for streams that first appeared midway in
                # a damaged file.
                return
            except (av.error.InvalidDataError, av.error.BlockingIOError) as error:
                self._count_failure(report, error)
                demux = self._container.demux()
                continue
            except av.FFmpegError as error:
                self._read_error = error
                return
            ours = packet.stream.index == self._stream.index
            report.breaks += ours and packet.is_corrupt
            if ours and packet.size and packet.time_base:
                stamp = None if packet.dts is None else float(packet.dts * packet.time_base)
                elapsed = self._pace.note(stamp)
                if self._untimed:
                    packet.time_base = Fraction(1, 1000)
                    packet.pts = packet.dts = round(elapsed * 1000)
            yield packet

    def _count_failure(self, report: Report, error: Exception) -> None:
        report.skipped += 1
        self._failures_in_row += 1
        if self._failures_in_row > MAX_BAD_PACKETS:
            self._check_index(report)
            where = (
                f"after frame {report.decoded - 1}; choose an end before that."
                if report.decoded
                else f"at its beginning; {REMEDY}"
            )
            raise SourceError(
                f"{self._name} is damaged: {self._failures_in_row} packets in a row cannot be read "
                f"{where}"
            ) from error

    def _check_index(self, report: Report) -> None:
        """Raise a SourceError if an MP4 file has its index at the end, and no picture was read.

        Its packets have passed when the index comes. A pipe has no way back; nor has a server that
        sends no ranges of a file, from which not even a damaged packet comes then.
        """
        if report.decoded or "mp4" not in self._container.format.name:
            return
        lost = self._remote and self._read_error is not None and self._read_error.errno == errno.EIO
        if self._pipe is not None and report.skipped:
            where = "a pipe; give the file, or send MPEG-TS or Matroska."
        elif lost and not report.skipped:
            where = "a server without ranges; download it, or put the index first."
        else:
            return
        raise SourceError(
            f"{self._name} sends an MP4 file with its index at the end, which cannot be read from "
            f"{where}"
        )

    def _pixels(self, frame: VideoFrame, report: Report) -> NDArray[np.uint8]:
        # FFmpeg scales other depths by itself, as pictures say how many bits they have.
        if max(each.bits for each in frame.format.components) == DEPTHS[-1]:
            self._depth = self._depth or self._found_depth() or depth_of(self._deep(frame))
            report.depth = self._depth
            if self._depth < DEPTHS[-1]:
                values = self._deep(frame)
                report.count_depth(values, self._depth)
                return as_rgb(upright(values, self._matrix(frame)), self._depth)
        return as_rgb(upright(self._values(frame, "rgb24"), self._matrix(frame)))

    def _found_depth(self) -> int:
        """Return the bits of 16 that pictures all over a film use; 0 if it is read only once."""
        if not self.seekable:
            return 0
        found = 0
        number = self._container.streams.video.index(self._stream)
        with contextlib.suppress(av.FFmpegError), av.open(self._address, **TITLE_OPTIONS) as film:
            for place in np.linspace(0, film.duration or 0, DEPTH_SAMPLES, endpoint=False).tolist():
                film.seek(round(place))
                reached = None
                for reached in itertools.islice(film.decode(video=number), DEPTH_REACH):
                    if (reached.time or 0) * av.time_base >= place:
                        break
                found = max(found, depth_of(self._deep(reached)) if reached else 0)
        return found

    def _deep(self, frame: VideoFrame) -> NDArray[np.uint16]:
        """Return the pixels of a picture of 16 bits: gray or RGB."""
        return self._values(frame, "gray16le" if len(frame.format.components) < 3 else "rgb48le")

    def _values(self, frame: VideoFrame, kind: str) -> NDArray[Any]:
        """Return the pixels of a picture in a format of FFmpeg's."""
        try:
            converted = self._reformatter.reformat(frame, format=kind, threads=ONE_THREAD)
        except av.FFmpegError as error:
            raise SourceError(
                f"{self._name} has pixels in the format {frame.format.name}, which cannot be "
                f"converted; convert the video."
            ) from error
        pixels = converted.to_ndarray()
        if converted is frame:  # the decoder owns this memory and may still need it
            pixels = pixels.copy()
        return pixels

    def _matrix(self, frame: VideoFrame) -> NDArray[np.int32]:
        """Return the display matrix of a picture, which is read once for each angle.

        PyAV's frame and its side data refer to each other, so reading them keeps the memory of each
        picture until Python's next search for such cycles: hundreds of megabytes.
        """
        if frame.rotation not in self.matrices:
            self.matrices[frame.rotation] = display_matrix(frame)
        return self.matrices[frame.rotation]


def camera(number: int) -> Decoder:
    """Return the decoder of a camera of this computer, given its number from 0.

    Raises a SourceError if there is no such camera, or it cannot be read.
    """
    system = platform.system()
    name, options = f"camera {number}", {}
    if system == "Windows":
        found = [d.name for d in av.enumerate_input_devices("dshow") if "video" in d.media_types]
        if number >= len(found):
            raise SourceError(f"There is no camera {number}, only {len(found)}; connect it.")
        format_name, address = "dshow", f"video={found[number]}"
    elif system == "Darwin":
        # Cameras refuse FFmpeg's default of 29.97 frames per second.
        format_name, address, options = "avfoundation", f"{number}:none", {"framerate": "30"}
    else:
        format_name, address = "v4l2", f"/dev/video{number}"
    advice = "connect it, or choose another number."
    return Decoder(address, name, advice, format_name=format_name, options=options, remote=True)


def _rate(stream: VideoStream) -> float | None:
    """Return the nominal frame rate: FFmpeg's round guess if it agrees with the average."""
    guessed, average = stream.guessed_rate, stream.average_rate
    timed = stream.start_time is not None  # otherwise the average is FFmpeg's default
    if guessed and average and timed and abs(guessed / average - 1) > 0.05:
        guessed = average
    return float(guessed) if guessed else None


def display_matrix(frame: VideoFrame) -> NDArray[np.int32]:
    """Return the display matrix, (2, 2): the pixel at (x, y) is shown at (x, y) @ matrix."""
    try:
        side_data: Mapping[Any, Any] = frame.side_data
    except ValueError:  # side data of a kind that PyAV does not know; only the angle is given
        cos, sin = round(math.cos(angle := math.radians(-frame.rotation))), round(math.sin(angle))
        return np.array([[cos, sin], [-sin, cos]], np.int32)
    found = side_data.get(SideData.DISPLAYMATRIX)
    if found is None:
        return np.eye(2, dtype=np.int32)
    return np.frombuffer(bytes(found), np.int32).reshape(3, 3)[:2, :2]


def upright(pixels: NDArray[Any], matrix: NDArray[np.int32]) -> NDArray[Any]:
    """Return a picture rotated and mirrored by a display matrix, to the nearest 90 degrees."""
    across, along = matrix.diagonal().tolist(), matrix[::-1].diagonal().tolist()
    if abs(along[1]) > abs(across[0]):
        pixels, across = pixels.swapaxes(0, 1), along
    if across[0] < 0:
        pixels = pixels[:, ::-1]
    return pixels[::-1] if across[1] < 0 else pixels
