"""Frames from video files, images, cameras and streams.

`open_source` takes the name that a user gives and returns a `Source`, an iterator of frames. Its
`Report` counts what could not be read.
"""

from __future__ import annotations

import glob
import itertools
import os
import re
import sys
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Self

import numpy as np

from motes.core.addresses import without_password
from motes.core.errors import ConfigError, SourceError
from motes.core.files import as_path
from motes.core.frame import FRAME_INTERVAL, NUMBER, WHOLE, Frame
from motes.core.log import LOG
from motes.video.decoder import REMEDY, Decoder, camera
from motes.video.image_files import IMAGE_ENDINGS, ImageFiles, files_in
from motes.video.pipe import Pipe
from motes.video.reconnect import Persistent
from motes.video.report import Reader, Report
from motes.video.times import AHEAD, timed

LIST_BEGINNINGS = (b"#EXTM3U", b"ffconcat", b"<?xml", b"<MPD", b"[playlist]")
LIST_ENDINGS = (".m3u8", ".m3u", ".mpd", ".pls", ".ffconcat", ".concat", ".txt")
"""How such files begin, and how their names end where they do not pass for a film."""
LIST_HEAD = 4096
"""Bytes of a file in which such a beginning is looked for."""


def is_playlist(path: Path) -> bool:
    """Return whether a file begins like one that names others."""
    try:
        with path.open("rb") as file:
            head = file.read(LIST_HEAD)
    except OSError:  # whoever opens it as a film says why
        return False
    return head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(LIST_BEGINNINGS)


SCHEMES = ("http", "https", "rtsp", "rtsps")

LEAST_RATE = 1e-5
"""Least number of frames per second that may be given: a picture a day; the inverse is the most."""

_URL = re.compile(r"([a-z][a-z0-9+.-]+)://", re.IGNORECASE)


class Source:
    """An iterator of frames, and a context manager that closes what it reads; see `open_source`.

    It is read once: to loop over it again after its end is a SourceError.

    Attributes
    ----------
    name
        The name of the source in messages, without the password of an address.
    width, height
        Size of every frame, in pixels.
    fps
        Nominal frames per second, None if unknown.
    duration
        Length of the whole source in seconds, None if unknown.
    frame_count
        Estimated number of frames in the chosen range, None if unknown.
    live
        Whether frames arrive in real time, without an end.
    report
        Counts of what was read and of errors; complete after the last frame.
    """

    def __init__(
        self, name: str, reader: Reader, start: int, end: int | None, stride: int, fps: float | None
    ) -> None:
        self.name, self._rate = name, fps
        self.fps, self.duration, self.live = fps or reader.fps, reader.duration, reader.live
        if fps is not None:
            self.duration = None if reader.count is None else reader.count / fps
        self.report = Report()
        self._logged: str | None = None
        self._reader = reader
        ends = [stop for stop in (end, reader.count) if stop is not None]
        self.frame_count = len(range(start, min(ends), stride)) if ends else None
        # This is closed before the reader, since a thread may be using the reader.
        self._pictures = reader.pictures(self.report)
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
            frames.close()
            self._pictures.close()
            reader.close()
            raise
        self.width, self.height = first.width, first.height
        self._frames: Iterator[Frame] | None = itertools.chain([first], frames)
        """None when it is closed."""
        self._ended = False
        if assumption := self.report.assumption:
            LOG.warning("%s: %s", name, assumption)

    def _select(self, start: int, end: int | None, stride: int) -> Generator[Frame, None, None]:
        size = None
        pictures = itertools.islice(self._pictures, end)
        ahead = AHEAD if isinstance(self._reader, Decoder) and self._reader.seekable else 0
        even = self._rate is not None
        moments = timed(pictures, self.fps, self.report, even=even, ahead=ahead)
        for index, (moment, _, load) in enumerate(moments):
            if index < start or (index - start) % stride:
                continue
            arrived = time.monotonic() if self.live else None
            pixels = load()
            height, width, _ = pixels.shape
            size = size or (width, height)
            if size != (width, height):
                raise SourceError(
                    f"Frame {index} of {self.name} has {width}x{height} pixels, those before "
                    f"{size[0]}x{size[1]}; split or rescale it so that all have one size."
                )
            yield Frame(index, moment, pixels, arrived=arrived)

    def __iter__(self) -> Self:
        if self._ended:
            raise SourceError(f"{self.name} is read to its end; open it again to read it anew.")
        return self

    def __next__(self) -> Frame:
        if self._frames is None:
            raise SourceError(f"{self.name} is closed; open it again.")
        try:
            return next(self._frames)
        except StopIteration:
            self._ended = True
            self._log()
            raise

    def _log(self) -> None:
        """Log the errors that have not been logged."""
        problems = self.report.problems
        if problems and problems != self._logged:
            LOG.warning("%s: %s.", self.name, problems)
        self._logged = problems

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file, camera or connection; to ask for a frame is a SourceError after that."""
        self._frames = None
        self._log()
        self._pictures.close()
        self._reader.close()

    @property
    def even_rate(self) -> float | None:
        """Frames per second that give the times; None where the file has times of its own."""
        return even_rate(self._reader, self._rate, self.report)

    @property
    def realtime(self) -> bool:
        """Whether frames certainly arrive in real time, so that old ones may be left out."""
        return self._reader.realtime

    @property
    def files(self) -> Sequence[str]:
        """The paths of all image files in the folder that holds them, by frame; none of a video."""
        return self._reader.files

    def stop(self) -> None:
        """Stop waiting for a live source that dropped, or for a pipe: there are no more frames.

        Any thread may call this.
        """
        self._reader.stop()


def open_source(
    source: str | int | Path,
    *,
    start: int = 0,
    end: int | None = None,
    stride: int = 1,
    fps: float | None = None,
    on_drop: Callable[[str], None] | None = None,
    patience: float | None = None,
) -> Source:
    """Open a source of frames and read up to its first chosen frame.

    Parameters
    ----------
    source
        One of these:

        - a video file;
        - an image file: all pictures of an animation or of a TIFF with several pages;
        - a folder of images or a pattern such as "dir/*.jpg": the first picture of each file, in
          the natural order of their names (img2 before img10);
        - the number of a camera, 0 or "0" (write "./0" for a file of that name);
        - an http, https, rtsp or rtsps address.
    start, end, stride
        The frames with index start, start + stride, ... below end. `Frame.index` counts in the
        source: start 10 and stride 2 give 10, 12, ...
    fps
        Frames per second, in place of the times in the file; for images without a rate. By default,
        that of their seqinfo.ini (see `rate_in` of `motes.video.image_files`), else 25.
    on_drop
        Called with one line of text when a live source ends or fails, and when it is back. Such a
        source is opened again after growing pauses, and its frames go on. Without `on_drop`, the
        end of a live source is an error. Live sources are cameras, rtsp addresses, streams of
        JPEGs and HLS, unless they give a duration; and any address that gives neither a duration
        nor a length, unless it sends faster than real time (see `motes.video.pace`): then it is a
        recording, with an end.
    patience
        Seconds for which such a source is tried again, before its end is an error after all; by
        default without end.

    Returns
    -------
    Source
        Its frames are upright (rotation marks are applied), RGB uint8, all of one size. Their
        times are those of the file, in seconds since the first frame of the source, and strictly
        increase.

    Raises
    ------
    SourceError
        If there is nothing to read; while iterating, if a frame cannot be read, or the source is
        closed.
    ConfigError
        If start, end or stride is not a possible range of frames, or fps is no rate or given for
        a live source.
    """
    check_rate(fps)
    for what, number in (("start", start), ("end", end), ("stride", stride)):
        if number is not None or what != "end":
            _check_whole(what, number)
    if start < 0:
        raise ConfigError(f"start is {start}; the first frame has index 0.")
    if stride < 1:
        raise ConfigError(f"stride is {stride}; give 1 for every frame, 2 for every other.")
    if end is not None and end <= start:
        raise ConfigError(f"end is {end}, start {start}; end must be greater.")
    if patience is not None and not patience >= 0:
        raise ConfigError(f"patience is {patience}; give seconds, 0 or more.")
    if not isinstance(source, WHOLE):  # the number of a camera
        as_path(source)
    # numpy's numbers become Python's: in 32 bits, times would run into each other.
    fps, start, stride = fps and float(fps), int(start), int(stride)
    name, reader = find_reader(str(source), on_drop, patience, fps)
    if fps is not None and reader.live:
        reader.close()
        raise ConfigError(f"{name} is live: its frames come at their own times; omit fps.")
    return Source(name, reader, start, end, stride, fps)


def check_rate(fps: float | None) -> None:
    """Raise a ConfigError if a rate is no possible number of frames per second."""
    number = isinstance(fps, NUMBER)
    if fps is not None and not (number and LEAST_RATE <= fps <= 1 / LEAST_RATE):
        raise ConfigError(
            f"fps is {f'{float(fps):g}' if number else repr(fps)}; give frames per second from "
            f"{LEAST_RATE:g} to {1 / LEAST_RATE:g}."
        )


def _check_whole(name: str, number: object) -> None:
    """Raise a ConfigError unless a value is a whole number of frames."""
    whole = isinstance(number, int | np.integer) and not isinstance(number, bool)
    if not whole or number > sys.maxsize:  # type: ignore[operator]
        raise ConfigError(f"{name} is {number!r}; give a whole number of frames below 2**63.")


def is_recorded(source: str | int | Path) -> bool:
    """Return whether a source is a local file or pictures, whose frames can be read twice."""
    name = str(source)
    return not (is_remote(name) or name.isdigit() or _is_pipe(name))


def _is_pipe(name: str) -> bool:
    """Return whether a file is a pipe or a terminal, which can be read once."""
    try:
        return Path(name).is_fifo() or Path(name).is_char_device()
    except OSError:  # the name is too long for a file
        return False


def is_remote(source: str) -> bool:
    """Return whether a source is a camera or an address, which may answer at a later time."""
    url = _URL.match(source)
    return source.isdecimal() or bool(url and url[1].lower() in SCHEMES)


def even_rate(reader: Reader, fps: float | None, report: Report) -> float | None:
    """Return the frames per second that give the times, where no stamps of the film do.

    They are those that are given, or those of images; None for a film with its own times.
    """
    if fps is None and report.assumed:
        return 1 / FRAME_INTERVAL
    return reader.fps if fps is None and isinstance(reader, ImageFiles) else fps


def find_reader(
    source: str,
    on_drop: Callable[[str], None] | None = None,
    patience: float | None = None,
    fps: float | None = None,
) -> tuple[str, Reader]:
    """Return a source's name for messages, and its reader; `fps` is for images alone."""
    if source.isdecimal():
        name = f"camera {source}"
        return name, _persistent(partial(camera, int(source)), name, on_drop, patience)
    if url := _URL.match(source):
        if not is_remote(source):
            raise SourceError(f"{url[1]}:// is not known; use http, https, rtsp or rtsps.")
        name = without_password(source)
        # TCP, because UDP loses packets at a firewall or on a full link.
        options = {"rtsp_transport": "tcp"} if url[1].lower().startswith("rtsp") else {}
        advice = "check the address and the network."
        connect = partial(Decoder, source, name, advice, options=options, remote=True)
        return name, _persistent(connect, name, on_drop, patience)
    if os.path.isdir(source):
        return source, ImageFiles(source, files_in(source), fps)
    if not os.path.exists(source):
        if glob.has_magic(source):
            return source, ImageFiles(source, glob.glob(source, recursive=True), fps)
        advice = "a pattern has * or ?" if "%" in source else "check the name"  # as FFmpeg's %05d
        advice = "an option comes before --" if source.startswith("-") else advice
        raise SourceError(f"There is no file or folder {source}; {advice}.")
    if os.path.splitext(source)[1].lower() in IMAGE_ENDINGS:
        from motes.video.animation import Animation

        return source, Animation(source)
    if os.path.isfile(source) and not os.path.getsize(source):
        raise SourceError(f"{source} is empty; {REMEDY}")
    if _is_pipe(source):
        pipe = Pipe(source)
        try:
            return source, Decoder(pipe, source, "check what is sent.")
        except BaseException:
            pipe.close()
            raise
    if is_playlist(Path(source)) and not source.lower().endswith(LIST_ENDINGS):
        raise SourceError(
            f"{source} is a playlist, which names other files; give the film, or a name that ends "
            f"in .m3u8 or .ffconcat."
        )
    # Without "file:", FFmpeg would read a name with a colon as an address.
    return source, Decoder(f"file:{source}", source, "check the file.")


def _persistent(
    connect: Callable[[], Decoder],
    name: str,
    on_drop: Callable[[str], None] | None,
    patience: float | None,
) -> Reader:
    """Open a camera or an address; with `on_drop`, a live one is opened again when it drops."""
    decoder = connect()
    if on_drop is None or not decoder.live:
        return decoder
    return Persistent(connect, decoder, name, on_drop, patience)
