"""A video with what was found drawn into its frames: what the overlays of all commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Self

from motes.core.frame import FRAME_INTERVAL
from motes.core.types import Bytes
from motes.output.track_rows import check_writable
from motes.video.writer import VideoWriter

if TYPE_CHECKING:
    from motes.video.film import Film
    from motes.video.sources import Source


class AnnotatedVideo:
    """A video that begins at 0; checks on construction that it can be written.

    Raises
    ------
    FormatError
        If the file exists and must not be overwritten, or cannot be made.
    """

    def __init__(self, path: Path, source: Source | Film, stride: int, *, overwrite: bool) -> None:
        check_writable(path, overwrite)
        self._writer = VideoWriter(path, (source.fps or 1 / FRAME_INTERVAL) / stride, overwrite)
        self._start: float | None = None

    def add(self, pixels: Bytes, time: float) -> None:
        """Add a picture, with the time of its frame."""
        if self._start is None:
            self._start = time
        self._writer.write(pixels, time - self._start)

    @property
    def result(self) -> str | None:
        """The video, or the unfinished file that an error left; None for nothing."""
        writer = self._writer
        if writer.result is None:
            return None
        return f"{writer.result}" + " (unfinished)" * (writer.result != writer.path)

    def __enter__(self) -> Self:
        self._writer.__enter__()
        return self

    def __exit__(self, *exception: object) -> None:
        """Close the video; one that Ctrl-C ended is complete up to its last frame."""
        self._writer.__exit__(*exception)  # type: ignore[arg-type]
