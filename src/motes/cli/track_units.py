"""Real units of `motes track`: its options, places on the ground, and figures of the motion."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Self

from cyclopts import Group, Parameter

from motes.cli.input_checks import read_text
from motes.cli.load_config import error_context
from motes.cli.messages import counted, log
from motes.core.errors import ConfigError, FormatError
from motes.core.optional import optional

if TYPE_CHECKING:
    from motes.cli.moment import Moment, Moments
    from motes.core.frame import Frame
    from motes.mot.analytics.real_units import RealUnits
    from motes.video.film import Film
    from motes.video.sources import Source

MOTION = ("path", "speed", "size")
"""Figures of the motion."""


@Parameter(name="*", group=Group("Real units", sort_key=2))
@dataclass(frozen=True, kw_only=True)
class UnitOptions:
    """How pixels become metres."""

    scale: Annotated[
        float | None,
        Parameter(help="Pixels per metre: rows get x_m, y_m and speed, with deviations."),
    ] = None
    ground: Annotated[
        Path | None,
        Parameter(
            help="TOML file with [ground]: scale, homography (9 numbers), or points (four or more "
            "[x, y, X, Y]), as for motes watch --places."
        ),
    ] = None
    lens: Annotated[
        Path | None,
        Parameter(
            help="With --scale or --ground: distortion of the lens, the YAML or XML file of "
            "OpenCV's calibration."
        ),
    ] = None

    @property
    def given(self) -> dict[str, object]:
        """The value of each option by its name; None if it is not given."""
        return {"--scale": self.scale, "--ground": self.ground, "--lens": self.lens}

    def units(self) -> RealUnits | None:
        """Return the units of the options; None if there are none.

        Raises
        ------
        ConfigError
            If options contradict each other, or a file does not describe the ground or a lens.
        SourceError
            If a file cannot be read.
        """
        if self.scale is None and self.ground is None and self.lens is None:
            return None
        from motes.mot.analytics.ground_plane import Ground
        from motes.mot.analytics.lens import Lens
        from motes.mot.analytics.real_units import RealUnits
        from motes.mot.analytics.regions import Regions

        if (self.scale is None) == (self.ground is None):
            raise ConfigError("Give either --scale or --ground; --lens needs one of them.")
        plane: Ground | None = None
        if self.ground is not None:
            text = read_text(self.ground)
            with error_context(self.ground):
                plane = Regions.parse(text).ground
                if plane is None:
                    raise ConfigError("it has no [ground]; add scale, homography or points.")
        else:
            if not 1e-9 <= self.scale <= 1e9:  # type: ignore[operator]
                raise ConfigError(
                    f"--scale is {self.scale:g}; give pixels per metre, from 1e-9 to 1e9."
                )
            plane = Ground(self.scale)
        lens: Lens | None = None
        if self.lens is not None:
            text = read_text(self.lens)
            with error_context(self.lens):
                lens = Lens.parse(text)
        return RealUnits(plane, lens)


def check_size(units: RealUnits | None, film: Source | Film) -> None:
    """Check that the lens is of this film, and say where it has no places.

    Raises
    ------
    ConfigError
        If it was calibrated with pictures of another size, or maps nothing to their middle.
    """
    if units is None or units.lens is None:
        return
    lens, size = units.lens, units.lens.size
    if size is not None and size != (film.width, film.height):
        raise ConfigError(
            f"The lens was calibrated at {size[0]}x{size[1]}, and {film.name} has {film.width}x"
            f"{film.height} pixels; give the calibration of this film's camera."
        )
    units.corrected()  # which needs the ground's points
    right, low = film.width - 1.0, film.height - 1.0
    if lens.undistorted((right / 2, low / 2)) is None:
        raise ConfigError(
            f"The lens maps nothing to the middle of {film.name}; its numbers are damaged, or of "
            f"another camera: calibrate again."
        )
    corners = [(x, y) for x in (0.0, right) for y in (0.0, low)]
    if lost := sum(lens.undistorted(corner) is None for corner in corners):
        log(f"The lens has no places for {counted(lost, 'corner')} of {film.name}; rows have no "
            f"metres there.")  # fmt: skip


def measured(units: RealUnits, moments: Moments) -> Moments:
    """Return the same moments, each with its place on the ground."""
    from motes.mot.analytics.real_units import GroundMotion

    def located(frames: Iterator[Frame]) -> Generator[Moment, None, None]:
        motion = GroundMotion(units)
        with closing(moments(frames)) as made:
            for moment in made:
                yield replace(moment, place=motion.update(moment.track))

    return located


def motion_names(figures: str | None) -> tuple[str, ...]:
    """Return the figures of the motion that --figures names; none if it names a folder.

    Raises
    ------
    ConfigError
        If it names figures of the motion and others.
    """
    names = tuple(figures.split(",")) if figures is not None else ()
    unknown = [name for name in names if name not in MOTION]
    if unknown and len(unknown) < len(names):
        raise ConfigError(
            f"--figures {figures}: There is no {unknown[0]!r}; known are {', '.join(MOTION)}."
        )
    return () if unknown else names


class MotionFigures:
    """Figures of the motion, as PDF beside the rows, made at the end, also when interrupted.

    Parameters
    ----------
    stem
        The path of the files without `.path.pdf` and so on.
    names
        The figures.
    unit
        The unit of length.
    overwrite
        Whether existing files may be replaced.
    """

    def __init__(self, stem: Path, names: Sequence[str], unit: str, *, overwrite: bool) -> None:
        from motes.rows.writer import check_writable

        optional("matplotlib", "Drawing figures needs matplotlib", "motes[report]")
        self._files = {name: stem.with_name(f"{stem.name}.{name}.pdf") for name in names}
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

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if not self._rows or not (kind is None or issubclass(kind, KeyboardInterrupt)):
            return
        import numpy as np

        from motes.output.motion_charts import FIGURES, MotionSeries, style

        series = MotionSeries(*np.array(self._rows).T)
        with style():
            for name, path in self._files.items():
                try:
                    # Without a date, equal runs give equal files.
                    FIGURES[name](series, self._unit).savefig(path, metadata={"CreationDate": None})
                except OSError as error:
                    raise FormatError(
                        f"The figure {path} cannot be written: {error.strerror}; make room, or "
                        f"choose another place for -o."
                    ) from None
        self._done = True
