"""The target, its keyframes and the outputs of `motes track`, as options.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from motes.cli.input_checks import REGION, error_context, numbers_of, point_out_meant
from motes.cli.option_groups import (
    FLAG,
    HYPHEN,
    KEYFRAMES,
    OUTPUT,
    REPEATED,
    TARGET,
    OutputOptions,
    options,
)
from motes.cli.streams import log
from motes.core.errors import ConfigError, InputError, MotesError

if TYPE_CHECKING:
    from motes.core.frame import Frame
    from motes.core.track import Track
    from motes.correction.keyframes import Mark
    from motes.sot.tracker import Tracker

Begin = Callable[["Tracker", "Frame"], "Track | None"]
"""Tries to start a tracker on a frame; returns its track, or None if it has not started."""


@options(TARGET)
class TargetOptions:
    """The object that is tracked, given in one of two ways."""

    init: Annotated[list[str] | None, REPEATED, HYPHEN] = None
    """The target in the first frame: a box x,y,width,height, or an ellipse x,y,a,b,theta (center,
    half-axes, and the angle from the x axis towards y in radians). Repeat it to track several
    objects."""
    detect: Literal["face"] | None = None
    """Wait for a face and track it."""

    def regions(self) -> list[list[float]]:
        """Return the regions of --init; raise a ConfigError for a text that is none, or twice."""
        regions: list[list[float]] = []
        for text in self.init or []:
            region = numbers_of("--init", text, *REGION)
            if region in regions:
                raise ConfigError(f"--init {text} is given twice; give each object once.")
            regions.append(region)
        return regions

    def region(self) -> list[float] | None:
        """Return the numbers of one --init, for a target with keyframes; None without it.

        Raises a ConfigError if the target is given in another way, or there are several.
        """
        if self.detect is not None:
            raise ConfigError("Keyframes go with --init; omit other targets.")
        regions = self.regions()
        if len(regions) > 1:
            raise ConfigError("Keyframes are of one object; give one --init.")
        return regions[0] if regions else None

    def begin(self) -> Begin:
        """Return how tracking begins; raise a ConfigError unless the target is given in one way."""
        if self.init and self.detect:
            raise ConfigError("--init and --detect contradict each other; give one of them.")
        if self.init:
            region = self.regions()[0]
            return partial(_begin_at, region)
        if self.detect is None:
            raise ConfigError(
                "The target is missing. Give one of --init, --detect, --at, --keyframes, for "
                "example --init 300,200,60,80 (x, y, width, height in the first frame)."
            )
        from motes.mot.detection.pretrained import FacesConfig

        faces = FacesConfig().detector()
        return lambda tracker, frame: tracker.detect(frame, faces)


def _begin_at(region: Sequence[float], tracker: "Tracker", frame: "Frame") -> "Track":
    """Start a tracker on a region, and say if it may be given by corners, or holds nothing."""
    track = tracker.init(frame, region)
    point_out_meant(region, frame.width, frame.height)
    if tracker.info.note is not None:
        log(tracker.info.note)
    return track


@options(KEYFRAMES)
class KeyframeOptions:
    """Where a target is known."""

    keyframes: Path | None = None
    """File with a keyframe in each row: frame,x,y,width,height, or frame,x,y,a,b,theta, or
    FIRST:LAST,absent. A row may begin with the name of its film: others are left out."""
    at: Annotated[list[str] | None, REPEATED, HYPHEN, Parameter(group=TARGET)] = None
    """The target in any frame: FRAME=x,y,width,height or FRAME=x,y,a,b,theta. It is tracked both
    ways from there, and between two such frames. Repeat it."""
    absent: Annotated[list[str] | None, REPEATED, HYPHEN] = None
    """Frames without the target: N or FIRST:LAST, the last one included. Repeat it."""

    @property
    def given(self) -> bool:
        """Whether any of these options is used."""
        return self.keyframes is not None or bool(self.at or self.absent)

    def marks(self, source: str) -> "list[Mark]":
        """Return the keyframes of these options for a source.

        Raises a ConfigError if an option has another form; and a FormatError if the file cannot be
        read, or has keyframes of other films only.
        """
        from motes.core.geometry import as_ellipse, check_angle
        from motes.correction.keyframes import ABSENT, keyframes_of, marks_of

        found: list[Mark] = []
        if self.keyframes is not None:
            with other_format_named(self.keyframes):
                known = keyframes_of(
                    self.keyframes, source, lambda note: log(f"{self.keyframes}: {note}")
                )
            found += known.items()
        for text in self.at or []:
            frame, equals, region = text.partition("=")
            if not equals:
                raise ConfigError(f"--at takes FRAME=x,y,width,height; got {text!r}.")
            marked = marks_of(frame, region)
            if marked[0][1] is not None:  # what is typed has not turned on and on
                with error_context(f"--at {text}"):
                    check_angle(as_ellipse(marked[0][1]).theta)
            found += marked
        for text in self.absent or []:
            found += marks_of(text, ABSENT)
        return found


@contextmanager
def other_format_named(file: Path) -> Iterator[None]:
    """Turn the error of a file that holds no keyframes into advice, if it has a known format."""
    from motes.formats.registry import recognized

    try:
        yield
    except InputError:
        try:
            form = recognized(file)
        except MotesError:
            form = "keyframes"
        if form != "keyframes":
            raise InputError(
                f"{file} holds no keyframes, but has the format {form}; make them with motes "
                f"convert {file} {file.stem}.keyframes.csv."
            ) from None
        raise


@options(OUTPUT)
class TrackOutputs(OutputOptions):
    """The outputs of `motes track`."""

    figures: Path | None = None
    """Folder for the figures of the papers, by motes-lab; motes draw makes those of rows."""
    resume: Annotated[bool, FLAG] = False
    """Continue the rows of an interrupted run. Give the same source, options and seed. The run is
    repeated up to the missing rows; overlay and figures are made again."""
