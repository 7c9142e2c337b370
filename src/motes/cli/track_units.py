"""Real units: their options, a check of the lens, and places of tracks in metres."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import Group

from motes.cli.option_groups import options
from motes.cli.streams import log
from motes.core.errors import ConfigError, counted
from motes.core.track import Track

if TYPE_CHECKING:
    from motes.mot.analytics.ground_plane import Ground
    from motes.mot.analytics.lens import Lens
    from motes.mot.analytics.real_units import GroundMotion, RealUnits


@options(Group("Real units", sort_key=2))
class UnitOptions:
    """How pixels become metres."""

    scale: float | None = None
    """Pixels per metre: rows get x_m, y_m and speed, with deviations."""
    ground: Path | None = None
    """TOML file with [ground]: scale, homography (three rows of three), or points (four or more
    [x, y, X, Y]), as for motes watch --places."""
    lens: Path | None = None
    """With --scale or --ground: distortion of the lens, the YAML or XML file of OpenCV's
    calibration."""

    @property
    def given(self) -> dict[str, object]:
        """The value of each option by its name; None if it is not given."""
        return {"--scale": self.scale, "--ground": self.ground, "--lens": self.lens}

    def units(self) -> RealUnits | None:
        """Return the units of the options; None if there are none.

        Raises a ConfigError if options contradict each other, or a file does not describe the
        ground or a lens; and a SourceError if a file cannot be read.
        """
        if self.scale is None and self.ground is None and self.lens is None:
            return None
        from motes.mot.analytics.lens import Lens
        from motes.mot.analytics.real_units import RealUnits
        from motes.mot.analytics.regions import Regions

        if (self.scale is None) == (self.ground is None):
            raise ConfigError("Give either --scale or --ground; --lens needs one of them.")
        if self.ground is not None:
            plane = Regions.load(self.ground).ground
            if plane is None:
                raise ConfigError(
                    f"{self.ground}: it has no [ground]; add scale, homography or points."
                )
        else:
            plane = ground_of(self.scale)  # type: ignore[arg-type]
        return RealUnits(plane, None if self.lens is None else Lens.load(self.lens))


def ground_of(scale: float) -> Ground:
    """Return the ground of --scale; raise a ConfigError if it is none."""
    from motes.mot.analytics.ground_plane import Ground

    if not 1e-9 <= scale <= 1e9:
        raise ConfigError(f"--scale is {scale:g}; give pixels per metre, from 1e-9 to 1e9.")
    return Ground(scale)


def check_size(units: RealUnits | None, film: str, width: int, height: int) -> None:
    """Say how large a scale makes the picture, if points may be exchanged, and what a lens lacks.

    Raises a ConfigError if the lens was calibrated with pictures of another size, or maps nothing
    to their middle.
    """
    if units is not None and units.lens is not None:
        _check_lens(units, units.lens, film, width, height)
    if units is not None and (scale := units.ground.scale) is not None:
        from numpy import format_float_positional  # never as 1.6e+03

        sides = (format_float_positional(side / scale, 3, fractional=False, trim="-")
                 for side in (width, height))  # fmt: skip
        log(f"With {scale:g} pixels per metre, the picture is {' x '.join(sides)} m.")
    if units is not None and (points := units.ground.points) is not None:
        spans = [max(numbers) - min(numbers) for numbers in zip(*points, strict=True)]
        pixels, metres = max(spans[:2]), max(spans[2:])
        if pixels < metres:
            log(
                f"The points of [ground] are {pixels:g} pixels apart, and {metres:g} metres; a "
                f"point is [x, y, X, Y], pixels first, and no shares of the picture."
            )


def _check_lens(units: RealUnits, lens: Lens, film: str, width: int, height: int) -> None:
    size = lens.size
    if size is not None and size != (width, height):
        raise ConfigError(
            f"The lens was calibrated at {size[0]}x{size[1]}, and {film} has {width}x"
            f"{height} pixels; give the calibration of this film's camera."
        )
    units.corrected()  # which needs the ground's points
    right, low = width - 1.0, height - 1.0
    if lens.undistorted((right / 2, low / 2)) is None:
        raise ConfigError(
            f"The lens maps nothing to the middle of {film}; its numbers are damaged, or of "
            f"another camera: calibrate again."
        )
    corners = [(x, y) for x in (0.0, right) for y in (0.0, low)]
    if lost := sum(lens.undistorted(corner) is None for corner in corners):
        log(f"The lens has no places for {counted(lost, 'corner')} of {film}; rows have no "
            f"metres there.")  # fmt: skip


def placed_by(motion: GroundMotion, tracks: Sequence[Track]) -> Sequence[Track]:
    """Return tracks with their places on the ground; log when the first one has none."""
    before, placed = motion.note, motion.update(tracks)
    if motion.note not in (None, before):
        log(motion.note)
    return placed
