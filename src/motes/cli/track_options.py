"""The target and the outputs of `motes track`, as options.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from motes.cli.input_checks import error_context, read_text, region_of
from motes.cli.load_config import load_target
from motes.cli.options import (
    FLAG,
    HYPHEN,
    OUTPUT,
    REPEATED,
    TARGET,
    OutputOptions,
    options,
)
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.core.frame import Frame
    from motes.core.track import Track
    from motes.sot.known_target import KnownTarget
    from motes.sot.places import Place
    from motes.sot.tracker import Tracker

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
        return [region_of("--init", text) for text in self.init or []]

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
            return lambda tracker, frame: tracker.init(frame, region)
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
            read_text(self.places)  # a file that is missing is an error of its own
            with error_context(self.places):
                places = load_places(self.places)
        background = None if self.background is None else read_image(self.background)
        return lambda tracker, frame: tracker.search(frame, known, places, background)


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
