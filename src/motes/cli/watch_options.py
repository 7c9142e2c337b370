"""The objects, the counting and the outputs of `motes watch`, as options.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Group, Parameter

from motes.cli.input_checks import numbers_of
from motes.cli.option_groups import (
    FLAG,
    HYPHEN,
    LIVE,
    OUTPUT,
    REPEATED,
    FileName,
    OutputOptions,
    options,
)
from motes.cli.track_units import ground_of
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.mot.analytics.regions import Regions

SCHEMES = ("http", "https", "mqtt", "mqtts")
"""How the addresses begin that events are sent to."""
QUEUE = "motes-events.sqlite"
"""Default file in which events wait."""


@options(Group("Objects", sort_key=1))
class ObjectOptions:
    """The objects that are tracked."""

    detector: Annotated[FileName | None, Parameter(accepts_keys=False)] = None
    """Detector: background (what moves before one), people, faces, an .onnx file, MODULE:CALLABLE,
    or a .txt file of detections in the format of the MOTChallenge. The default is background."""
    classes: str | None = None
    """Track only objects of these classes of the detector: person,car,..."""
    least: Annotated[float | None, HYPHEN] = None
    """Lowest score of detections that are used."""
    camera: Literal["auto", "still", "moving"] | None = None
    """Whether the camera is still or moving. By default, auto, it is followed while it moves; but
    a background needs a still one, unless this is moving: then it moves along, as one plane."""

    def selection(self) -> dict[str, Any]:
        """Return the keys of the configuration that --classes, --least and --camera set."""
        keys: dict[str, Any] = {}
        if self.classes is not None:
            keys["classes"] = [name.strip() for name in self.classes.split(",") if name.strip()]
            if not keys["classes"]:
                raise ConfigError("--classes names no class; give some, such as person,car.")
        if self.least is not None:
            keys["least"] = self.least
        moves = {} if self.camera is None else {"camera": self.camera}
        return {"detections": keys, **moves} if keys else moves

    like: Annotated[str | None, HYPHEN] = None
    """Track only objects that look like the one in this box of the first frame, such as the players
    of a team: x,y,width,height. They are chosen from what --detector finds; without it, from what
    moves, and then the camera may move too."""
    histogram: Path | None = None
    """With a file of several cameras: search for the target in this file, which
    KnownTarget.save of Python has written. A camera that finds it reports its place to the others.
    """


@options(Group("Counting", sort_key=1))
class CountingOptions:
    """The lines and zones of counting, and the scale of speeds."""

    line: Annotated[list[str] | None, REPEATED, HYPHEN] = None
    """Count the objects that cross this line: x1,y1,x2,y2. May be repeated."""
    zone: Annotated[list[str] | None, REPEATED, HYPHEN] = None
    """Count the objects that enter and leave this polygon: x1,y1,x2,y2,x3,y3,... May be repeated.
    """
    dwell: float | None = None
    """Count the objects that stay in a zone for this time, in seconds. A dwell of the zone in
    --places has priority."""
    places: Path | None = None
    """TOML file with [[line]] and [[zone]], each with points and name, a zone also with dwell; and
    [ground], for speeds in metres per second: scale, homography (three rows of three), or points
    (four or more [x, y, X, Y])."""
    scale: float | None = None
    """Pixels per metre, for places in metres and speeds in metres per second."""
    turns: Annotated[bool, FLAG] = False
    """Count the objects that go from each line to each other one, and print a table of them at the
    end."""

    def regions(self) -> "Regions":
        """Return the lines, the zones and the ground of the options and of the file.

        Raises a ConfigError for a value that does not fit, or options that contradict each other;
        and a SourceError if the file cannot be read.
        """
        from msgspec.structs import replace

        from motes.mot.analytics.regions import SETTLED, Line, Regions, Zone

        given = Regions() if self.places is None else Regions.load(self.places)
        if self.places is not None and given == Regions():
            raise ConfigError(f"{self.places} has no [[line]], [[zone]] or [ground]; add one.")
        lines = (numbers_of("--line", text, "x1,y1,x2,y2") for text in self.line or ())
        added = Regions(
            tuple(Line(tuple(points)) for points in lines),  # type: ignore[arg-type]
            tuple(Zone(tuple(_corners(text))) for text in self.zone or ()),
        )
        ground = given.ground
        if self.scale is not None:
            if ground is not None:
                raise ConfigError(f"--scale and [ground] in {self.places} contradict each other.")
            ground = ground_of(self.scale)
        lines_given = given.line + added.line
        if self.turns and len(lines_given) < 2:
            raise ConfigError("--turns counts from line to line; give two with --line or --places.")
        zones = given.zone + added.zone
        if self.dwell is not None:
            if not zones:
                raise ConfigError("--dwell is for zones; give one with --zone or --places.")
            if not SETTLED <= self.dwell <= 1e9:
                raise ConfigError(f"--dwell is {self.dwell:g}; give seconds, {SETTLED:g} to 1e9.")
            zones = tuple(replace(zone, dwell=zone.dwell or self.dwell) for zone in zones)
        return Regions(lines_given, zones, ground)


def _corners(text: str) -> list[float]:
    """Return the numbers of --zone, those of at least three corners."""
    form = ",".join("xy"[i % 2] for i in range(max(6, text.count(",") + 1)))
    return numbers_of("--zone", text, form)


@options(OUTPUT)
class WatchOutputs(OutputOptions):
    """The outputs of `motes watch`."""

    events: Annotated[list[FileName] | None, REPEATED, HYPHEN] = None
    """Events as they happen: a file of JSON Lines, - for standard output, an https:// address that
    they are posted to, or mqtt://HOST/TOPIC. An object appears, disappears, crosses, enters, stays
    or leaves. May be repeated."""
    queue: Annotated[
        Path | None,
        Parameter(
            group=LIVE,
            help="File in which events wait until a server or broker has confirmed them, also "
            f"after the run. [default: {QUEUE}]",
        ),
    ] = None
    slit: Path | None = None
    """Picture of the pixels under each line over time, .png. A row is a frame, and each counted
    crossing is marked. With several lines, a file for each."""
    heatmap: Path | None = None
    """Picture of the time that feet of objects spent at each place, .png."""
    paths: Path | None = None
    """Picture of the path of each object's foot, .png."""

    @property
    def queue_file(self) -> Path:
        """The file in which events wait."""
        return self.queue or Path(QUEUE)

    def destinations(self) -> tuple[list[str], list[str]]:
        """Return the files of --events, and the addresses; raise a ConfigError if they clash."""
        events = self.events or []
        sent = [name for name in events if is_sent(name)]
        for name in events:
            if name.lower().endswith(".csv"):
                raise ConfigError(f"--events {name}: events are lines of JSON; name it .jsonl.")
            if ("://" in name or is_sent(name.replace(":", "://", 1))) and name not in sent:
                raise ConfigError(
                    f"--events {name}: such addresses are not known; give a file, -, or an address "
                    f"with https://, http://, mqtts:// or mqtt://."
                )
        if self.queue is not None and not sent:
            raise ConfigError("--queue is for events that are sent; give --events an address.")
        return [name for name in events if not is_sent(name)], sent


def is_sent(address: str) -> bool:
    """Return whether events to this address are sent, not written into a file."""
    scheme, separated, _ = address.partition("://")
    return bool(separated) and scheme.lower() in SCHEMES
