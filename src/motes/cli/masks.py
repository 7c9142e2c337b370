"""Masks of one target: a folder of PNG files, or a document of COCO."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec.structs import replace

from motes.cli.moment import Moment, Sink
from motes.cli.pictures import png
from motes.cli.watch_outputs import LABEL, DocumentOutput
from motes.core.errors import ConfigError, FormatError
from motes.core.files import PartialFolder
from motes.core.track import Status
from motes.formats import runs
from motes.formats.registry import check_folder
from motes.formats.shapes import frame_name
from motes.rows.journal import FrameRow, ObjectRow
from motes.rows.writer import check_writable
from motes.sot.segmentation import Mask, Segmenter

if TYPE_CHECKING:
    from motes.video.sources import Source


def masks_output(path: Path, film: Source, label: str | None, *, overwrite: bool) -> Sink:
    """Return the output of masks: of a document if the name ends in .json, else of a folder.

    Parameters
    ----------
    path, film, label
        The name, the film, and the class of the target in a document.
    overwrite
        Whether existing masks may be replaced.

    Raises
    ------
    ConfigError
        If the name has another ending.
    FormatError
        If it exists and must not be overwritten, or cannot be made.
    """
    if path.suffix.lower() == ".json":
        return DocumentMasks(str(path), "coco", film, label or LABEL, overwrite, None)
    if path.suffix:
        raise ConfigError(f"--masks {path}: give a folder for PNG files, or a .json of COCO.")
    return FolderMasks(path, film, overwrite=overwrite)


def _mask(segmenter: Segmenter, moment: Moment) -> Mask:
    """Return the mask of a frame; it is empty where the target is not tracked."""
    track, pixels = moment.track, moment.frame.pixels
    if track is None or track.status is not Status.TRACKING:
        return np.zeros(pixels.shape[:2], np.bool_)
    return segmenter.update(pixels, track.ellipse)


class FolderMasks(Sink):
    """A PNG file for each frame, white where the target is; the name is that of the image.

    The folder gets its name at the end of the run, also of one that Ctrl-C ended.
    """

    def __init__(self, folder: Path, film: Source, *, overwrite: bool) -> None:
        self._path, self._film, self._count = folder, film, 0
        self._segmenter = Segmenter()
        self._folder: PartialFolder | None = None
        self._done = False
        try:
            folder.parent.mkdir(parents=True, exist_ok=True)
            there = [*folder.iterdir()] if folder.exists() else []
        except OSError as error:
            raise self._failure(error) from None
        check_writable(folder / "masks" if folder.is_dir() else folder)
        if there and not overwrite:
            raise FormatError(f"{folder} has files; choose another, or overwrite it (--overwrite).")
        check_folder(folder, (".png",), "mask")

    def write(self, moment: Moment) -> None:
        """Write the file of a frame."""
        mask = _mask(self._segmenter, moment)
        file = self._film.file_of(moment.frame.index)
        stem = Path(file).stem if file else frame_name(moment.frame.index)
        try:
            if self._folder is None:
                self._folder = PartialFolder(self._path)
            self._folder.add(f"{stem}.png", png(mask.astype(np.uint8) * 255))
        except OSError as error:
            raise self._failure(error) from error
        self._count += 1

    def _failure(self, error: OSError) -> FormatError:
        kept = f" The masks so far are in {self._folder.path}." if self._folder else ""
        return FormatError(
            f"{self._path} cannot be written: {error.strerror}; make room, or choose another "
            f"place.{kept}"
        )

    @property
    def result(self) -> str | None:
        """The folder, or the unfinished one that an error left."""
        if self._folder is None:
            return None
        if self._done:
            return f"{self._count} masks in {self._path}"
        return f"{self._count} masks in {self._folder.path} (unfinished)"

    def __exit__(self, *exception: object) -> None:
        """Give the folder its name; what an error ends stays a partial folder."""
        ended = exception[1] is None or isinstance(exception[1], KeyboardInterrupt)
        if self._folder is None or not ended:
            return
        try:
            self._folder.finish()
        except OSError as error:
            raise self._failure(error) from error
        self._done = True


class DocumentMasks(DocumentOutput):
    """A document of COCO whose objects have masks in place of outlines."""

    def __init__(self, *arguments: Any) -> None:
        super().__init__(*arguments)
        self._segmenter = Segmenter()

    def write(self, moment: Moment) -> None:
        """Add the object of a frame, if its mask is not empty."""
        mask, objects = _mask(self._segmenter, moment), tuple[ObjectRow, ...]()
        if moment.track is not None and mask.any():
            objects = (replace(ObjectRow.of_target(moment.track), mask=runs.encode(mask)),)
        self.add(FrameRow(moment.frame.index, moment.frame.time, objects))
