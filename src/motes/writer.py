"""Annotated video out: nothing is lost when the program is killed or the disk fills up."""

from __future__ import annotations

import contextlib
import math
import os
from fractions import Fraction
from pathlib import Path
from typing import Self

import av
import numpy as np
from av.video.reformatter import VideoReformatter
from numpy.typing import NDArray

from motes.decoder import ONE_THREAD
from motes.errors import ConfigError, FormatError

ENDINGS = (".m4v", ".mkv", ".mov", ".mp4")

_MILLISECOND = Fraction(1, 1000)
_BT601 = 6  # the matrix, in the numbers of ITU-T H.273, that swscale uses unless told otherwise


class VideoWriter:
    """Write RGB pictures as H.264 video; use it as a context manager.

    The pictures go to `<name>.partial.mkv` beside the target. When all is well in the end, that
    file becomes the target, in the container that the target's ending names (.m4v, .mkv, .mov or
    .mp4). If the program is killed, or an exception passes through the `with`, the partial file
    stays, and can be watched up to within a second of that moment; the target is untouched.
    Without a picture there is no file at all.

    Parameters
    ----------
    path
        The target.
    fps
        Nominal frames per second; pictures without a time of their own follow each other at this
        rate.
    overwrite
        Whether an existing target may be replaced.

    Raises
    ------
    FormatError
        Here, if the target exists or cannot be written; later, if a picture cannot be written.
    ConfigError
        If the ending is unknown or the rate is not a positive number.
    """

    def __init__(self, path: str | Path, fps: float, overwrite: bool = False) -> None:
        self.path = Path(path)
        self.partial = self.path.with_name(self.path.name + ".partial.mkv")
        if self.path.suffix.lower() not in ENDINGS:
            raise ConfigError(f"{path} does not end like a video; use {', '.join(ENDINGS)}.")
        if not (math.isfinite(fps) and fps > 0):
            raise ConfigError(f"A video cannot have {fps} frames per second; give more than 0.")
        folder = self.path.parent
        if not folder.is_dir():
            raise FormatError(f"There is no folder {folder} for {self.path.name}; make it first.")
        if not os.access(folder, os.W_OK):
            raise FormatError(f"Nothing can be written to {folder}; choose another folder.")
        if self.path.is_dir() or (self.path.exists() and not overwrite):
            raise FormatError(f"{path} exists; choose another name, or allow it to be overwritten.")
        self._fps = fps
        self._shape: tuple[int, ...] | None = None
        self._frames = 0
        self._last = -1
        self._reformatter = VideoReformatter()

    def write(self, pixels: NDArray[np.uint8], time: float | None = None) -> None:
        """Append a picture.

        Parameters
        ----------
        pixels
            RGB, shape (height, width, 3), the same for all pictures. Odd sizes, which H.264 does
            not have, grow by one row or column that repeats the edge.
        time
            Seconds since the start; kept to the millisecond. Give it for all pictures or none.

        Raises
        ------
        FormatError
            If the picture does not fit or the disk is full; what was written before stays in the
            partial file.
        """
        if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
            raise FormatError(
                f"A picture is uint8 (height, width, 3); got {pixels.dtype} {pixels.shape}."
            )
        if self._shape is None:
            self._open(pixels.shape[0], pixels.shape[1])
            self._shape = pixels.shape
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
        frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format="rgb24")
        frame = self._reformatter.reformat(frame, format="yuv420p", **ONE_THREAD)
        frame.pts, frame.time_base = self._last, _MILLISECOND
        try:
            self._container.mux(self._stream.encode(frame))
        except av.FFmpegError as error:
            raise self._failure(error) from error
        self._frames += 1

    def _open(self, height: int, width: int) -> None:
        # A cluster is what a killed program leaves readable: many small ones, each written at once.
        options = {"cluster_time_limit": "200", "flush_packets": "1"}
        try:
            self._container = av.open(_local(self.partial), "w", format="matroska", options=options)
            # B-frames would hold back pictures and shuffle the times on their way to the target.
            self._stream = self._container.add_stream(
                "libx264",
                rate=Fraction(self._fps).limit_denominator(1001),
                options={"preset": "veryfast", "crf": "20", "bf": "0"},
            )
            self._stream.width, self._stream.height = width + width % 2, height + height % 2
            self._stream.pix_fmt = "yuv420p"
            self._stream.codec_context.time_base = _MILLISECOND
            self._stream.codec_context.colorspace = _BT601
        except av.FFmpegError as error:
            raise self._failure(error) from error

    def _failure(self, error: av.FFmpegError | OSError) -> FormatError:
        return FormatError(
            f"{self.path} cannot be written: {error.strerror}; make room there. "
            f"What there is so far is in {self.partial}."
        )

    def close(self) -> None:
        """Finish the video and give it its name.

        Raises
        ------
        FormatError
            If that cannot be written; the partial file stays.
        """
        if self._shape is None:
            return
        self._shape = None
        try:
            self._finish()
            if self.path.suffix.lower() == ".mkv":
                os.replace(self.partial, self.path)
            else:
                self._remux()
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error

    def _finish(self) -> None:
        try:
            self._container.mux(self._stream.encode(None))
        finally:
            self._container.close()

    def _remux(self) -> None:
        """Copy the packets from the partial file to the target's container."""
        unnamed = self.path.with_name(self.path.name + ".partial" + self.path.suffix)
        try:
            with (
                av.open(_local(self.partial)) as partial,
                av.open(_local(unnamed), "w", options={"movflags": "+faststart"}) as whole,
            ):
                video = partial.streams.video[0]
                stream = whole.add_stream_from_template(video)
                for packet in partial.demux(video):
                    if packet.dts is not None:  # the last one is empty
                        packet.stream = stream
                        whole.mux(packet)
            os.replace(unnamed, self.path)
        finally:
            unnamed.unlink(missing_ok=True)
        self.partial.unlink()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.close()
        elif self._shape is not None:
            # The exception on its way says more than one that would follow from it.
            with contextlib.suppress(av.FFmpegError):
                self._finish()


def _local(path: Path) -> str:
    """Return a file's name for FFmpeg, which would take one with a colon for an address."""
    return f"file:{path}"
