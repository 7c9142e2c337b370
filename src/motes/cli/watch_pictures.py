"""The pictures of `motes watch`: slit scans of lines, a heatmap, and paths."""

from __future__ import annotations

import io
from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motes.cli.moment import Moment, Sink
from motes.core.errors import ConfigError
from motes.core.files import write_whole, writing
from motes.core.frame import FRAME_INTERVAL
from motes.core.track import Status
from motes.mot.analytics.regions import Regions
from motes.mot.boxes import foot_of
from motes.output.path_pictures import heatmap, paths
from motes.output.slit_scan import SlitScan
from motes.rows.writer import check_writable

Pixels = NDArray[np.uint8]


class _Pictures(Sink):
    """Pictures that are written at the end, also of an interrupted run."""

    def __init__(self, names: Mapping[str, Path], overwrite: bool) -> None:
        for path in names.values():
            if path.suffix.lower() != ".png":
                raise ConfigError(f"{path} does not end in .png; rename it.")
            check_writable(path, overwrite)
        self._names, self._written = names, list[Path]()

    @abstractmethod
    def pictures(self) -> Mapping[str, Pixels]:
        """Return the pictures by their keys; nothing if there was no frame."""

    @property
    def result(self) -> str | None:
        """The files."""
        return ", ".join(map(str, self._written)) or None

    def __exit__(self, *exception: object) -> None:
        from PIL import Image

        for key, pixels in self.pictures().items():
            data, path = io.BytesIO(), self._names[key]
            Image.fromarray(pixels).save(data, "PNG")
            with writing(path):
                write_whole(path, data.getvalue())
            self._written.append(path)


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
            scan.add(moment.frame.pixels, moment.frame.index, moment.frame.time)
        for event in moment.events:
            if event.event == "crosses" and event.place is not None:
                second = event.direction == self._lines[event.place].label[1]
                place = event.x, event.y
                self._scans[event.place].mark(event.frame, place, event.identity, second=second)

    def pictures(self) -> Mapping[str, Pixels]:
        """Return the scans."""
        return {name: scan.picture() for name, scan in self._scans.items()} if self._begun else {}


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
        self._first: Pixels | None = None
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

    def pictures(self) -> Mapping[str, Pixels]:
        """Return the heatmap over the first frame."""
        return {} if self._first is None else {"": heatmap(self._first, self._seconds)}


class Paths(_Pictures):
    """A picture of the path of each object's foot."""

    def __init__(self, path: Path, *, overwrite: bool) -> None:
        super().__init__({"": path}, overwrite)
        self._first: Pixels | None = None
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

    def pictures(self) -> Mapping[str, Pixels]:
        """Return the paths over the first frame."""
        return {} if self._first is None else {"": paths(self._first, self._feet)}
