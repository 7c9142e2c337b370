"""Figures of one target's motion: its path, speed and size."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from motes.cli.moment import Moment, Sink
from motes.core.errors import FormatError
from motes.core.optional import optional
from motes.output.motion_charts import FIGURES, MotionSeries, style
from motes.rows.writer import check_writable


class MotionFigures(Sink):
    """Figures of the motion, as PDF, made at the end, also when interrupted.

    Parameters
    ----------
    stem
        The path of the files without `.path.pdf` and so on.
    unit
        The unit of length.
    overwrite
        Whether existing files may be replaced.
    """

    def __init__(self, stem: Path, unit: str, *, overwrite: bool) -> None:
        optional("matplotlib", "Drawing figures needs matplotlib", "motes[report]")
        self._files = {name: stem.with_name(f"{stem.name}.{name}.pdf") for name in FIGURES}
        for path in self._files.values():
            check_writable(path, overwrite)
        self._unit, self._done = unit, False
        self._rows: list[tuple[float, ...]] = []

    def write(self, moment: Moment) -> None:
        """Record a frame."""
        place, track = moment.place, moment.track
        nothing = (math.nan,) * 10
        if track is None or place is None:  # it is not seen
            self._rows.append((moment.frame.time, *nothing))
            return
        deviations = [math.sqrt(each) for each in track.covariance.diagonal().tolist()]
        ellipse = track.ellipse
        self._rows.append(
            (
                moment.frame.time, place.x_m, place.y_m, place.x_m_std, place.y_m_std, place.speed,
                place.speed_std, ellipse.a, ellipse.b, deviations[2], deviations[3],
            )
        )  # fmt: skip

    @property
    def result(self) -> str | None:
        """The files."""
        return ", ".join(map(str, self._files.values())) if self._done else None

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if not self._rows or not (kind is None or issubclass(kind, KeyboardInterrupt)):
            return
        series = MotionSeries(*np.array(self._rows).T)
        with style():
            for name, path in self._files.items():
                try:
                    # Without a date, equal runs give equal files.
                    FIGURES[name](series, self._unit).savefig(path, metadata={"CreationDate": None})
                except OSError as error:
                    raise FormatError(
                        f"The figure {path} cannot be written: {error.strerror}; make room, or "
                        f"choose another folder."
                    ) from None
        self._done = True
