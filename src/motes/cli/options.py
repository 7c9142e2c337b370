"""Options that several commands share, in groups: frozen values that the parser makes.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from motes.cli.messages import log
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from motes.video.film import Film
    from motes.video.sources import Source

TARGET = Group("Target", sort_key=1)
KEYFRAMES = Group("Keyframes", sort_key=2)
RUN = Group("Run", sort_key=2)
FRAMES = Group("Frames", sort_key=2)
OUTPUT = Group("Output", sort_key=3)
CONFIGURATION = Group("Configuration", sort_key=4)
LIVE = Group("Live sources", sort_key=5)

FLAG = Parameter(negative=(), show_default=False)
"""An option without a value, off by default."""
REPEATED = Parameter(negative=())
"""An option that may be given several times."""
HYPHEN = Parameter(allow_leading_hyphen=True)
"""An option whose value may begin with a hyphen: a negative number, or - for standard output."""

PRESETS = (
    "Preset: default, nummiaro, maggio, ng_delp, zhao_pei, mean_shift or a variant; motes config "
    "lists all."
)
Preset = Annotated[str, Parameter(group=CONFIGURATION, help=PRESETS)]
TrackPreset = Annotated[
    str | None,
    Parameter(
        group=CONFIGURATION,
        help=f"{PRESETS} The default is the preset default, or nummiaro with --histogram.",
    ),
]
ObjectPreset = Annotated[
    str,
    Parameter(
        group=CONFIGURATION,
        help="Preset of the particle filter that tracks each object; motes config lists all.",
    ),
]
Workers = Annotated[
    int | None, Parameter(group=RUN, help="Number of processes; by default one for each core.")
]
Cluster = Annotated[
    str | None,
    Parameter(
        group=RUN,
        help="Run on a cluster of Ray instead of the processes of this machine: auto for the one "
        "that this machine belongs to, or HOST:PORT of its head.",
    ),
]
Fps = Annotated[
    float | None,
    Parameter(
        group=FRAMES,
        help="Frames per second of images, or of a film whose times are wrong. The default is what "
        "the film says, for images the frameRate in their seqinfo.ini, else 25.",
    ),
]
Seed = Annotated[int, Parameter(group=CONFIGURATION, help="Seed of the random numbers: 0 or more.")]
ConfigFile = Annotated[
    Path | None,
    Parameter(group=CONFIGURATION, help="TOML file whose values replace those of the preset."),
]
NetworkFiles = Annotated[
    str | None,
    Parameter(
        name="--network",
        group=CONFIGURATION,
        help="Trained network that joins the tracker: an ONNX file, or several of one network: "
        "backbone.onnx,head.onnx. docs/network.md says where to get one.",
    ),
]
KeyframeError = Annotated[
    float | None,
    Parameter(
        group=OUTPUT,
        help="Formats with keyframes (CVAT, Label Studio and keyframes): largest deviation of "
        "a box that is interpolated between them, in pixels; with 0, each frame is one. [default: "
        "1]",
    ),
]
Overwrite = Annotated[bool, FLAG, Parameter(group=OUTPUT, help="Replace existing files.")]


@Parameter(name="*", group=FRAMES)
@dataclass(frozen=True, kw_only=True)
class FrameOptions:
    """The frames that are read."""

    start: Annotated[int, Parameter(help="First frame.")] = 0
    end: Annotated[int | None, Parameter(help="Stop before this frame.")] = None
    stride: Annotated[int, Parameter(help="Read every n-th frame.")] = 1
    fps: Fps = None
    reconnect: Annotated[
        float | None,
        Parameter(
            group=LIVE,
            help="If a live source fails, try to open it again for this many seconds, with growing "
            "pauses; then end with an error. The default is no limit.",
        ),
    ] = None

    def open(self, source: str) -> "Source":
        """Return the frames of a source; raise a SourceError if it cannot be read."""
        from motes.video.sources import open_source

        if self.reconnect is not None and not self.reconnect >= 0:
            raise ConfigError(f"--reconnect is {self.reconnect:g}; give seconds, 0 or more.")
        return open_source(
            source,
            start=self.start,
            end=self.end,
            stride=self.stride,
            fps=self.fps,
            on_drop=log,
            patience=self.reconnect,
        )


def say_rate(film: "Source | Film") -> None:
    """Print that a frame rate is assumed, if it is."""
    if film.report.assumption is not None:
        log(f"{film.name}: {film.report.assumption}")


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class OutputOptions:
    """The outputs of a run."""

    output: Annotated[
        str | None,
        HYPHEN,
        Parameter(
            name=["--output", "-o"],
            help="Rows of each frame: a .csv, .jsonl or .txt (MOTChallenge) file, or - for "
            "standard output; or a document for annotation tools: .json (COCO) or .xml (CVAT). "
            "motes convert --list has all formats.",
        ),
    ] = None
    format: Annotated[str | None, Parameter(help="Format of --output, whatever its ending is.")] = (
        None
    )
    keyframe_error: KeyframeError = None
    label: Annotated[
        str | None,
        Parameter(help="Class of the objects in a .json or .xml document. [default: object]"),
    ] = None
    overlay: Annotated[
        Path | None, Parameter(help="Video with the tracks drawn: .mp4, .mkv, .mov or .m4v.")
    ] = None
    show: Annotated[
        bool,
        FLAG,
        Parameter(
            help="Show the tracks while they are made: in a window if OpenCV has one, else on a "
            "page for a browser on this computer, whose address is printed."
        ),
    ] = False
    overwrite: Overwrite = False


OwnCode = Annotated[
    bool,
    FLAG,
    Parameter(
        group=CONFIGURATION,
        help="Run the Python code that a file names as its detector, MODULE:CALLABLE.",
    ),
]


@Parameter(name="*", group=CONFIGURATION)
@dataclass(frozen=True, kw_only=True)
class ConfigOptions:
    """Changes of a preset, beside the keys of the configuration."""

    config: ConfigFile = None
    seed: Seed = 0
    dump_config: Annotated[
        bool, FLAG, Parameter(help="Print the whole configuration as TOML and exit.")
    ] = False
