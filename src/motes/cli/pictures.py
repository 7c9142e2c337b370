"""Pictures that a run leaves: slit scans, heatmap, paths of objects; figures and masks of one."""

from __future__ import annotations

import io
import math
import time
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace

from motes.cli.frame_loop import Moment, Sink
from motes.cli.input_checks import prepare_folder
from motes.cli.watch_outputs import LABEL, DocumentOutput
from motes.core.errors import ConfigError, FormatError
from motes.core.files import PartialFolder, write_whole, writing
from motes.core.frame import FRAME_INTERVAL
from motes.core.optional import optional
from motes.core.track import Status
from motes.core.types import Bytes
from motes.formats import runs
from motes.formats.registry import check_folder
from motes.formats.shapes import frame_name
from motes.mot.analytics.regions import Regions
from motes.mot.boxes import foot_of
from motes.output.figures import Recorder
from motes.output.motion_charts import FIGURES, MotionSeries, style
from motes.output.path_pictures import heatmap, paths
from motes.output.slit_scan import SlitScan
from motes.rows.journal import FrameRow, ObjectRow
from motes.rows.writer import check_writable
from motes.sot.presets import TrackerConfig
from motes.sot.segmentation import Mask, Segmenter
from motes.sot.tracker import Tracker
from motes.video.sources import Source

DPI = 110
"""Dots per inch of the figures of the papers."""


def png(pixels: Bytes) -> bytes:
    """Return a picture as a PNG file."""
    from PIL import Image

    data = io.BytesIO()
    Image.fromarray(pixels).save(data, "PNG")
    return data.getvalue()


class _Pictures(Sink):
    """Files that are written at the end, also of an interrupted run."""

    ending = ".png"

    def __init__(self, names: Mapping[str, Path], overwrite: bool) -> None:
        for path in names.values():
            if path.suffix.lower() != self.ending:
                raise ConfigError(f"{path} does not end in {self.ending}; rename it.")
            check_writable(path, overwrite)
        self._names, self._written = names, list[Path]()

    @abstractmethod
    def pictures(self) -> Iterator[tuple[str, bytes]]:
        """Yield the files' contents with their keys; nothing if there was no frame."""

    @property
    def result(self) -> str | None:
        """The files."""
        return ", ".join(map(str, self._written)) or None

    def __exit__(self, *exception: object) -> None:
        for key, data in self.pictures():
            with writing(self._names[key]):
                write_whole(self._names[key], data)
            self._written.append(self._names[key])


class Slits(_Pictures):
    """A slit scan of each line; with several lines, the name of each is part of its file's name."""

    def __init__(self, path: Path, places: Regions, *, overwrite: bool) -> None:
        if not places.lines:
            raise ConfigError("--slit shows lines; give one with --line or --places.")
        self._lines = places.lines
        self._scans = {
            name: SlitScan(line.points, line.label) for name, line in self._lines.items()
        }
        super().__init__(slit_files(path, places), overwrite)
        self._begun = False

    def write(self, moment: Moment) -> None:
        """Add a frame's pixels, and its crossings."""
        self._begun = True
        for scan in self._scans.values():
            scan.add(moment.frame, moment.tracks)
        for event in moment.events:
            if event.event == "crosses" and event.place is not None:
                second = event.direction == self._lines[event.place].label[1]
                place = event.x, event.y
                self._scans[event.place].mark(event.frame, place, event.identity, second=second)

    def pictures(self) -> Iterator[tuple[str, bytes]]:
        """Yield the scans."""
        for name, scan in self._scans.items() if self._begun else ():
            yield name, png(scan.picture())


def slit_files(path: Path, places: Regions) -> dict[str, Path]:
    """Return the file of each line's slit scan."""
    if len(places.lines) == 1:
        return dict.fromkeys(places.lines, path)
    names = {name: "".join(c if c.isalnum() else "-" for c in name) for name in places.lines}
    return {
        name: path.with_name(f"{path.stem}-{text}{path.suffix}") for name, text in names.items()
    }


class Heatmap(_Pictures):
    """A picture of how long feet have been at each place."""

    def __init__(self, path: Path, *, overwrite: bool) -> None:
        super().__init__({"": path}, overwrite)
        self._first: Bytes | None = None
        self._last = 0.0

    def write(self, moment: Moment) -> None:
        """Add a frame's feet."""
        frame = moment.frame
        if self._first is None:
            self._first = frame.pixels.copy()
            self._seconds = np.zeros(frame.pixels.shape[:2])
            self._last = frame.time - FRAME_INTERVAL
        for each in moment.tracks:
            x, y = (round(value) for value in foot_of(each.box))
            seen = each.track.status is Status.TRACKING
            if seen and 0 <= x < frame.width and 0 <= y < frame.height:
                self._seconds[y, x] += frame.time - self._last
        self._last = frame.time

    def pictures(self) -> Iterator[tuple[str, bytes]]:
        """Yield the heatmap over the first frame."""
        if self._first is not None:
            yield "", png(heatmap(self._first, self._seconds))


class Paths(_Pictures):
    """A picture of the path of each object's foot."""

    def __init__(self, path: Path, *, overwrite: bool) -> None:
        super().__init__({"": path}, overwrite)
        self._first: Bytes | None = None
        self._feet: dict[int, list[tuple[float, float]]] = {}

    def write(self, moment: Moment) -> None:
        """Add a frame's feet."""
        if self._first is None:
            self._first = moment.frame.pixels.copy()
        for each in moment.tracks:
            if each.track.status is Status.TRACKING:
                feet = self._feet.setdefault(each.identity, [])
                place = foot_of(each.box)
                if not feet or max(abs(place[0] - feet[-1][0]), abs(place[1] - feet[-1][1])) >= 1:
                    feet.append(place)

    def pictures(self) -> Iterator[tuple[str, bytes]]:
        """Yield the paths over the first frame."""
        if self._first is not None:
            yield "", png(paths(self._first, self._feet))


class MotionFigures(_Pictures):
    """Figures of one target's path, speed and size, as PDF; `stem` begins their names."""

    ending = ".pdf"

    def __init__(self, stem: Path, unit: str, *, overwrite: bool) -> None:
        optional("matplotlib", "Drawing figures needs matplotlib", "motes[report]")
        names = {name: stem.with_name(f"{stem.name}.{name}.pdf") for name in FIGURES}
        super().__init__(names, overwrite)
        self._unit = unit
        self._rows: list[tuple[float, ...]] = []

    def write(self, moment: Moment) -> None:
        """Record a frame."""
        place, track = moment.place, moment.track
        if track is None or place is None:  # it is not seen
            self._rows.append((moment.frame.time, *[math.nan] * 10))
            return
        _, _, a_std, b_std, _ = np.sqrt(track.covariance.diagonal()).tolist()
        self._rows.append(
            (
                moment.frame.time, place.x_m, place.y_m, place.x_m_std, place.y_m_std, place.speed,
                place.speed_std, track.ellipse.a, track.ellipse.b, a_std, b_std,
            )
        )  # fmt: skip

    def pictures(self) -> Iterator[tuple[str, bytes]]:
        """Yield the figures."""
        if not self._rows:
            return
        series = MotionSeries(*np.array(self._rows).T)
        with style():
            for name, draw in FIGURES.items():
                data = io.BytesIO()  # without a date in it, equal runs give equal files
                draw(series, self._unit).savefig(
                    data, format="pdf", metadata={"CreationDate": None}
                )
                yield name, data.getvalue()


class Figures(_Pictures):
    """The figures of the papers, in a folder."""

    def __init__(self, folder: Path, config: TrackerConfig, *, overwrite: bool) -> None:
        self._recorder, self._folder = Recorder(config), folder
        prepare_folder(folder, self._recorder.files, overwrite)
        super().__init__({name: folder / name for name in self._recorder.files}, overwrite)
        self._companion = Tracker("mean_shift")
        self._accompanied = False

    def write(self, moment: Moment) -> None:
        """Record a frame."""
        if moment.info is not None:
            self._recorder.add(moment.frame, moment.info, moment.seconds, self._compared(moment))

    def _compared(self, moment: Moment) -> float | None:
        """Return the time of a mean-shift tracker beside the one that runs, in seconds.

        It starts on the frame in which the target is first tracked, and has no time before.
        """
        if self._accompanied:
            clock = time.perf_counter()
            self._companion.update(moment.frame)
            return time.perf_counter() - clock
        if moment.track is not None and moment.status is Status.TRACKING:
            self._companion.init(moment.frame, moment.track.box)
            self._accompanied = True
        return None

    def pictures(self) -> Iterator[tuple[str, bytes]]:
        """Yield the figures."""
        for name, figure in self._recorder.figures():
            data = io.BytesIO()
            figure.savefig(data, dpi=DPI)
            yield name, data.getvalue()

    @property
    def result(self) -> str | None:
        """The number of files, and their folder."""
        return f"{len(self._written)} figures in {self._folder}" if self._written else None


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
