"""Lines, zones and ground of `motes watch`: their options, and the table of what was counted."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from motes.cli.input_checks import numbers_of, read_text
from motes.cli.load_config import error_context
from motes.cli.options import HYPHEN, REPEATED
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.mot.analytics.regions import Regions


@Parameter(name="*", group=Group("Counting", sort_key=1))
@dataclass(frozen=True, kw_only=True)
class CountingOptions:
    """The lines and zones of counting, and the scale of speeds."""

    line: Annotated[
        list[str] | None,
        REPEATED,
        HYPHEN,
        Parameter(help="Count the objects that cross this line: x1,y1,x2,y2. May be repeated."),
    ] = None
    zone: Annotated[
        list[str] | None,
        REPEATED,
        HYPHEN,
        Parameter(
            help="Count the objects that enter and leave this polygon: x1,y1,x2,y2,x3,y3,... May "
            "be repeated."
        ),
    ] = None
    dwell: Annotated[
        float | None,
        Parameter(
            help="Count the objects that stay in a zone for this time, in seconds. A dwell of "
            "the zone in --places has priority."
        ),
    ] = None
    places: Annotated[
        Path | None,
        Parameter(
            help="TOML file with [[line]] and [[zone]], each with points and name, a zone also "
            "with dwell; and [ground], for speeds in metres per second: scale, homography (9 "
            "numbers), or points (four or more [x, y, X, Y])."
        ),
    ] = None
    scale: Annotated[
        float | None, Parameter(help="Pixels per metre, for speeds in metres per second.")
    ] = None

    def regions(self) -> Regions:
        """Return the lines, the zones and the ground of the options and of the file.

        Raises
        ------
        ConfigError
            For a value that does not fit, or options that contradict each other.
        SourceError
            If the file cannot be read.
        """
        from msgspec.structs import replace

        from motes.mot.analytics.ground_plane import Ground
        from motes.mot.analytics.regions import Line, Regions, Zone

        given = Regions()
        if self.places is not None:
            text = read_text(self.places)
            with error_context(self.places):
                given = Regions.parse(text)
        lines = (numbers_of("--line", text, "x1,y1,x2,y2") for text in self.line or ())
        added = Regions(
            tuple(Line(tuple(points)) for points in lines),  # type: ignore[arg-type]
            tuple(Zone(tuple(_corners(text))) for text in self.zone or ()),
        )
        ground = given.ground
        if self.scale is not None:
            if ground is not None:
                raise ConfigError(f"--scale and [ground] in {self.places} contradict each other.")
            with error_context("--scale"):
                ground = Ground(self.scale)
        zones = given.zone + added.zone
        if self.dwell is not None:
            if not zones:
                raise ConfigError("--dwell is for zones; give one with --zone or --places.")
            with error_context("--dwell"):
                zones = tuple(replace(zone, dwell=zone.dwell or self.dwell) for zone in zones)
        return Regions(given.line + added.line, zones, ground)


def _corners(text: str) -> list[float]:
    """Return the numbers of --zone, those of at least three corners."""
    form = ",".join("xy"[i % 2] for i in range(max(6, text.count(",") + 1)))
    return numbers_of("--zone", text, form)


def table(counts: Counter[tuple[int, str, str, str, str]]) -> list[str]:
    """Return a line for each minute with events: the number of events of each kind."""
    minutes: dict[int, list[str]] = {}
    for (minute, *parts), count in sorted(counts.items()):
        what = " ".join(part for part in parts if part)
        minutes.setdefault(minute, []).append(f"{what} {count}")
    return [f"minute {minute}: {', '.join(whats)}" for minute, whats in minutes.items()]
