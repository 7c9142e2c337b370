"""Pictures that a run leaves: slit scans, heatmap, paths of objects; figures and masks of one."""

from __future__ import annotations

import io
import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from motes.cli.annotated_video import NOWHERE
from motes.cli.frame_loop import Moment, Sink
from motes.cli.option_groups import OutputOptions
from motes.cli.outputs import DocumentOutput
from motes.core.callables import optional
from motes.core.errors import ConfigError
from motes.core.files import check_writable, write_whole, writing
from motes.core.frame import FRAME_INTERVAL
from motes.core.track import GROUND, Status, Track
from motes.core.types import Bytes
from motes.formats import masks
from motes.mot.analytics.regions import Regions
from motes.output.motion_charts import FIGURES, MotionSeries, style
from motes.output.overlay import png
from motes.output.scene_overlay import heatmap, paths
from motes.output.slit_scan import SlitScan
from motes.rows.schema import FrameRow
from motes.sot.segmentation import Segmenter
from motes.video.sources import Source


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
            x, y = (round(value) for value in each.box.foot)
            seen = each.status is Status.TRACKING
            if seen and 0 <= x < frame.width and 0 <= y < frame.height:
                self._seconds[y, x] += frame.time - self._last
        self._last = frame.time

    def pictures(self) -> Iterator[tuple[str, bytes]]:
        """Yield the heatmap over the first frame."""
        if self._first is not None:
            yield "", png(heatmap(self._first, self._seconds))


class Paths(_Pictures):
    """A picture of the path of each object's foot, interrupted where it is not seen."""

    def __init__(self, path: Path, *, overwrite: bool) -> None:
        super().__init__({"": path}, overwrite)
        self._first: Bytes | None = None
        self._feet: dict[int, list[tuple[float, float]]] = {}

    def write(self, moment: Moment) -> None:
        """Add a frame's feet."""
        if self._first is None:
            self._first = moment.frame.pixels.copy()
        seen = {each.identity for each in moment.tracks if each.status is Status.TRACKING}
        for identity in self._feet.keys() - seen:
            if self._feet[identity][-1] is not NOWHERE:
                self._feet[identity].append(NOWHERE)
        for each in moment.tracks:
            if each.status is Status.TRACKING:
                feet = self._feet.setdefault(each.identity, [])
                place, (x, y) = each.box.foot, feet[-1] if feet else NOWHERE
                if not max(abs(place[0] - x), abs(place[1] - y)) < 1:
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
        track, nothing = moment.target, math.nan
        sizes = nothing, nothing, nothing, nothing
        if GROUND[0] in track.further:  # it is seen
            _, _, a_std, b_std, _ = np.sqrt(track.covariance.diagonal()).tolist()
            sizes = track.ellipse.a, track.ellipse.b, a_std, b_std
        self._rows.append((moment.frame.time, *map(track.number, GROUND), *sizes))

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


class Masks(DocumentOutput):
    """The pixels of one target: a document if the name ends in .json, else a folder."""

    hint = ""  # motes draw has no such option

    def __init__(self, path: Path, film: Source, label: str | None, *, overwrite: bool) -> None:
        if path.suffix and path.suffix.lower() != ".json":
            raise ConfigError(f"--masks {path}: give a folder for PNG files, or a .json of COCO.")
        form = "coco" if path.suffix else "masks"
        super().__init__(str(path), form, film, OutputOptions(label=label, overwrite=overwrite))
        self._segmenter = Segmenter()

    def write(self, moment: Moment) -> None:
        """Add the object of a frame with its mask; one without a mask is searched for."""
        frame, track = moment.frame, moment.target
        absent = track.status is Status.ABSENT
        each = Track.nowhere(frame.index, frame.time, Status.ABSENT if absent else Status.SEARCHING)
        if track.status is Status.TRACKING:
            mask = self._segmenter.update(frame.pixels, track.ellipse)
            if mask.any():
                label = track.label or self._options.label
                each = replace(track, label=label, mask=masks.encode(mask))
        self.add(FrameRow(frame.index, frame.time, (each,)))
