"""The target, its keyframes and the outputs of `motes track`, as options.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from motes.cli.input_checks import REGION, error_context, numbers_of, point_out_corners
from motes.cli.load_config import load_target
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
from motes.core.errors import ConfigError, InputError, MotesError

if TYPE_CHECKING:
    from motes.core.frame import Frame
    from motes.core.track import Track
    from motes.sot.known_target import KnownTarget
    from motes.sot.places import Place
    from motes.sot.tracker import Tracker

Marks = list[tuple[int, Sequence[float] | None]]
Begin = Callable[["Tracker", "Frame"], "Track | None"]
"""Tries to start a tracker on a frame; returns its track, or None if it has not started."""


@options(TARGET)
class TargetOptions:
    """The object that is tracked, given in one of three ways."""

    init: Annotated[list[str] | None, REPEATED, HYPHEN] = None
    """The target in the first frame: a box x,y,width,height, or an ellipse x,y,a,b,theta (center,
    half-axes, and the angle from the x axis towards y in radians). Repeat it to track several
    objects."""
    histogram: Path | None = None
    """Search for the target in this file, which --save-histogram has written."""
    detect: Literal["face"] | None = None
    """Wait for a face and track it."""
    places: Path | None = None
    """With --histogram: where the target may appear, a TOML file with [[place]], each with box or
    border."""
    background: Path | None = None
    """With --histogram: a picture without the target."""

    def regions(self) -> list[list[float]]:
        """Return the regions of --init; raise a ConfigError for a text that is none."""
        return [numbers_of("--init", text, *REGION) for text in self.init or []]

    def known(self) -> "KnownTarget | None":
        """Return the target of --histogram; raise a SourceError if it cannot be read."""
        return None if self.histogram is None else load_target(self.histogram)

    def region(self) -> list[float] | None:
        """Return the numbers of one --init, for a target with keyframes; None without it.

        Raises
        ------
        ConfigError
            If the target is given in another way, or there are several.
        """
        others = (self.histogram, self.detect, self.places, self.background)
        if any(other is not None for other in others):
            raise ConfigError("Keyframes go with --init; omit other targets.")
        regions = self.regions()
        if len(regions) > 1:
            raise ConfigError("Keyframes are of one object; give one --init.")
        return regions[0] if regions else None

    def begin(self, known: "KnownTarget | None") -> Begin:
        """Return how tracking begins.

        Parameters
        ----------
        known
            The target of --histogram.

        Raises
        ------
        ConfigError
            If the target is not given in exactly one way, or a value makes no sense.
        SourceError
            If a file cannot be read.
        """
        ways = {
            "--init": self.init or None,
            "--histogram": known,
            "--detect": self.detect,
        }
        given = [flag for flag, value in ways.items() if value is not None]
        if not given:
            raise ConfigError(
                f"The target is missing. Give one of {', '.join(ways)}, --at, --keyframes, "
                f"for example --init 300,200,60,80 (x, y, width, height in the first frame)."
            )
        if len(given) > 1:
            raise ConfigError(f"{' and '.join(given)} contradict each other; give one of them.")
        if known is None and (self.places or self.background):
            raise ConfigError(
                "--places and --background belong to --histogram; give it, or omit them."
            )
        if self.init:
            region = self.regions()[0]
            return partial(_begin_at, region)
        if known is None:
            from motes.mot.detection.pretrained import FaceDetector

            faces = FaceDetector()
            return lambda tracker, frame: tracker.detect(frame, faces)
        return self._search(known)

    def _search(self, known: "KnownTarget") -> Begin:
        """Return the search for a known target, in the places and before the background given."""
        from motes.sot.places import load_places
        from motes.video.image_files import read_image

        places: tuple[Place, ...] = ()
        if self.places is not None:
            with error_context(self.places):
                places = load_places(self.places)
        background = None if self.background is None else read_image(self.background)
        return lambda tracker, frame: tracker.search(frame, known, places, background)


def _begin_at(region: Sequence[float], tracker: "Tracker", frame: "Frame") -> "Track":
    """Start a tracker on a region, and say if it may be given by corners."""
    track = tracker.init(frame, region)
    point_out_corners(region, frame.width, frame.height)
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

    def marks(self, source: str) -> Marks:
        """Return the keyframes of these options for a source.

        Raises
        ------
        ConfigError
            If an option has another form.
        FormatError
            If the file cannot be read, or has keyframes of other films only.
        """
        from motes.correction.keyframes import ABSENT, keyframes_of, marks_of

        found: Marks = []
        if self.keyframes is not None:
            with other_format_named(self.keyframes):
                found += keyframes_of(self.keyframes, source).items()
        for text in self.at or []:
            frame, equals, region = text.partition("=")
            if not equals:
                raise ConfigError(f"--at takes FRAME=x,y,width,height; got {text!r}.")
            found += marks_of(frame, region)
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
    """Folder for the figures of the papers; motes draw makes those of rows."""
    save_histogram: Path | None = None
    """Save the target's color histogram in the first frame to this JSON file, for --histogram with
    the same preset, and track nothing."""
    resume: Annotated[bool, FLAG] = False
    """Continue the rows of an interrupted run. Give the same source, options and seed. The run is
    repeated up to the missing rows; overlay and figures are made again."""
