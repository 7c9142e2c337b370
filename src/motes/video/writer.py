"""Writing video such that no picture is lost when the program is killed or the disk is full."""

from __future__ import annotations

import contextlib
import math
import os
from fractions import Fraction
from pathlib import Path
from typing import Any, Self

import av
import numpy as np
from av.container import OutputContainer
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray

from motes.core.errors import ConfigError, FormatError
from motes.core.files import PartialFile, as_path, check_writable, is_special
from motes.core.frame import NUMBER, Frame
from motes.video.decoder import ONE_THREAD

# With a fragment or cluster for each picture, the file of a killed program can be read. On closing,
# the fragments become an ordinary video file with an index.
_FRAGMENTS = {"movflags": "hybrid_fragmented+empty_moov+frag_every_frame+default_base_moof"}
_CONTAINERS = {
    ".m4v": ("ipod", _FRAGMENTS),
    ".mkv": ("matroska", {"cluster_time_limit": "1"}),
    ".mov": ("mov", _FRAGMENTS),
    ".mp4": ("mp4", _FRAGMENTS),
}
ENDINGS = tuple(_CONTAINERS)

_MILLISECOND = Fraction(1, 1000)
_BT601 = 6  # the number in ITU-T H.273 of the color matrix that swscale uses by default


class VideoWriter:
    """Write RGB pictures as H.264 video; use it as a context manager.

    The pictures go to a partial file in the target's folder, which is renamed to the target at the
    end (see `motes.core.files`). If the program is killed, or an exception leaves the `with` block,
    the partial file stays and has all pictures except the last one or two; the target is untouched.
    Without a picture, no file is made.

    Parameters
    ----------
    path
        The target; its ending gives the container: .m4v, .mkv, .mov or .mp4.
    fps
        Nominal frames per second, used for pictures without a time.
    overwrite
        Whether an existing target may be replaced.

    Raises
    ------
    FormatError
        When it is created, if the target exists or cannot be written. Later, if a picture cannot
        be written.
    ConfigError
        If the ending is unknown or the rate is not a positive number.
    """

    def __init__(self, path: str | Path, fps: float, overwrite: bool = False) -> None:
        self.path = as_path(path)
        if self.path.suffix.lower() not in ENDINGS:
            raise ConfigError(f"{path} does not end like a video; use {', '.join(ENDINGS)}.")
        if not (isinstance(fps, NUMBER) and math.isfinite(fps) and fps > 0):
            raise ConfigError(f"A video cannot have {fps!r} frames per second; give more than 0.")
        check_writable(path, overwrite)
        if is_special(path):
            raise FormatError(f"{path} is no plain file; choose another name.")
        self._fps = float(fps)
        self._overwrite = overwrite
        self._file: PartialFile | None = None
        self._container: OutputContainer | None = None
        self._shape: tuple[int, ...] = ()
        self._frames, self._owner = 0, os.getpid()
        self._last = -1
        self._reformatter = VideoReformatter()

    def write(self, pixels: NDArray[Any], time: float | None = None) -> None:
        """Append a picture.

        Parameters
        ----------
        pixels
            RGB uint8 of shape (height, width, 3), the same for all pictures. H.264 has no odd
            sizes: they grow by one row or column that repeats the edge.
        time
            Seconds since the start, rounded to milliseconds. Give it for all pictures or none.

        Raises
        ------
        FormatError
            If the picture has another shape or type, or the disk is full; earlier pictures stay in
            the partial file.
        """
        if isinstance(pixels, Frame):
            raise FormatError("Write a Frame's pixels, as write(frame.pixels, frame.time).")
        pixels = np.asarray(pixels)
        if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
            raise FormatError(
                f"A picture is uint8 (height, width, 3); got {pixels.dtype} {pixels.shape}."
            )
        if time is not None and not (isinstance(time, NUMBER) and math.isfinite(time)):
            raise FormatError(f"Picture {self._frames} has the time {time!r}; give it seconds.")
        if os.getpid() != self._owner:  # which has the encoder's threads
            raise FormatError(
                f"{self.path.name} is written by another process, of which this one is a child; "
                f"write a file of its own in each."
            )
        if self._container is None and self._file is not None:
            raise FormatError(f"{self.path} is closed; write to it before.")
        if self._container is None:
            self._shape = pixels.shape
            self._container = self._begin(pixels.shape[0], pixels.shape[1])
        if pixels.shape != self._shape:
            raise FormatError(
                f"Picture {self._frames} of {self.path.name} has shape {pixels.shape}, those "
                f"before {self._shape}; give all the same size."
            )
        height, width, _ = pixels.shape
        if height % 2 or width % 2:
            pixels = np.pad(pixels, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
        seconds = self._frames / self._fps if time is None else time
        self._last = max(round(seconds * 1000), self._last + 1)
        try:
            frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")
            frame = self._reformatter.reformat(frame, format="yuv420p", threads=ONE_THREAD)
            frame.pts, frame.time_base = self._last, _MILLISECOND
            self._container.mux(self._stream.encode(frame))
        except (av.FFmpegError, OSError) as error:
            if not self._frames:
                self._give_up()
            raise self._failure(error) from error
        self._frames += 1

    def _begin(self, height: int, width: int) -> OutputContainer:
        rate = Fraction(self._fps)
        format_name, muxing = _CONTAINERS[self.path.suffix.lower()]
        try:
            self._file = PartialFile(self.path, self.path.suffix)
        except OSError as error:
            raise self._failure(error) from error
        options = {**muxing, "flush_packets": "1"}
        container = av.open(self._file, "w", format=format_name, options=options)
        # With zerolatency the encoder holds back no picture. Without a look ahead it spends more
        # bits on still parts. At crf 24 superfast takes two thirds of the time of veryfast at crf
        # 22, for files of about the same size. Threads share each picture, and take longer
        # together: where each core has a program, one is enough.
        threads = "1" if os.environ.get("MOTES_THREADS") == "1" else "auto"
        self._stream = container.add_stream(
            "libx264",
            rate=rate.limit_denominator(1001) or rate.limit_denominator(10**6),
            options={"preset": "superfast", "crf": "24", "tune": "zerolatency", "threads": threads},
        )
        self._stream.width, self._stream.height = width + width % 2, height + height % 2
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.time_base = _MILLISECOND
        self._stream.codec_context.colorspace = _BT601
        return container

    @property
    def result(self) -> Path | None:
        """The file with the pictures: the target when it is complete, the partial file before."""
        if self._file is None:
            return None
        return self.path if self._file.whole else self._file.path

    def _failure(self, error: av.FFmpegError | OSError) -> FormatError:
        kept = f" What there is so far is in {self.result}." if self.result else ""
        return FormatError(
            f"{self.path} cannot be written: {error.strerror}; make room there.{kept}"
        )

    def close(self) -> None:
        """Finish the video and rename it to the target.

        Raises
        ------
        FormatError
            If it cannot be written or the target appeared meanwhile; the partial file stays.
        """
        try:
            self._finish(named=True)
        except FileExistsError as error:
            raise FormatError(
                f"{self.path} appeared while it was written; the video is in {self.result}."
            ) from error
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error

    def _finish(self, *, named: bool) -> None:
        if os.getpid() != self._owner:  # to close the encoder would wait for its threads
            return
        container, self._container = self._container, None
        if container is None or self._file is None:
            return
        with contextlib.closing(self._file):
            try:
                container.mux(self._stream.encode(None))
            finally:
                container.close()
            self._file.settle()
            if named:
                self._file.finish(overwrite=self._overwrite)

    def _give_up(self) -> None:
        """Keep the partial file as complete as possible; remove it if it has no picture."""
        with contextlib.suppress(av.FFmpegError, OSError):
            self._finish(named=False)
        if self._file is not None and not self._frames:
            self._file.drop()
            self._file = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        else:  # the first exception explains more than one that would follow from it
            self._give_up()
