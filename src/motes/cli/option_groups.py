"""Options that several commands share, in groups: frozen values that the parser makes; their help.

Annotations are evaluated here: the parser would look for their names in the module of a subclass.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, TypeVar, dataclass_transform

from cyclopts import Group, Parameter, Token

from motes.cli.streams import log
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel
    from rich.console import Console, ConsoleOptions

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

Kind = TypeVar("Kind", bound=type)


@dataclass_transform(frozen_default=True, kw_only_default=True)
def options(group: Group) -> Callable[[Kind], Kind]:
    """Make a class a group of options: each field is one, and the text below it is its help."""

    def made(kind: Kind) -> Kind:
        dataclass(frozen=True, kw_only=True)(kind)
        return Parameter(name="*", group=group)(kind)

    return made


def _as_written(kind: Any, tokens: Sequence[Token]) -> str:
    """Return the value of an option as it is: its type is for shells, which complete it."""
    return tokens[0].value


def _whole(kind: Any, tokens: Sequence[Token]) -> int:
    """Return a whole number: the parser itself would round a fraction."""
    value = tokens[0].value
    try:
        return int(value)
    except ValueError:
        time = " Frames count from 0: give the number of one, not a time." * (":" in value)
        raise ValueError(f"{value} is no whole number.{time}") from None


if TYPE_CHECKING:
    FileName: TypeAlias = str
    PresetName: TypeAlias = str
    Whole: TypeAlias = int
else:
    Whole = Annotated[int, Parameter(converter=_whole)]
    FileName = Annotated[Path, Parameter(converter=_as_written)]
    PresetName = Annotated[
        Literal[
            "default", "nummiaro", "nummiaro:adaptive", "nummiaro:printed", "mean_shift", "maggio",
            "maggio:printed", "maggio:C", "maggio:O-ROH", "ng_delp", "ng_delp:color",
            "ng_delp:edges", "ng_delp:printed", "zhao_pei", "zhao_pei:printed",
        ],
        Parameter(converter=_as_written, show_choices=False),
    ]  # fmt: skip
PRESETS = (
    "Preset: default, nummiaro, maggio, ng_delp, zhao_pei, mean_shift or a variant; motes config "
    "lists all."
)
ObjectPreset = Annotated[
    PresetName,
    Parameter(
        group=CONFIGURATION,
        help="Preset of the particle filter that tracks each object; motes config lists all.",
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
Changes = Annotated[
    list[str] | None,
    REPEATED,
    Parameter(
        name="--set",
        group=CONFIGURATION,
        help="Value of a key of the configuration, KEY=VALUE. May be repeated.",
    ),
]
ConfigFile = Annotated[
    Path | None,
    Parameter(group=CONFIGURATION, help="TOML file whose values replace those of the preset."),
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
Identity = Annotated[
    Whole | None, Parameter(group=TARGET, help="Of several objects, that with this identity.")
]
"""Which of several objects in rows is meant."""
OutputFile = Annotated[Path | None, Parameter(name=["--output", "-o"], group=OUTPUT)]
WithGuesses = Annotated[
    bool,
    FLAG,
    Parameter(
        group=OUTPUT,
        help="Write guesses into documents as if they were seen: rows that are interpolated, or "
        "have a confidence below 0.5. Otherwise labels leave them out, and COCO and CVAT have them "
        "as occluded.",
    ),
]
Overwrite = Annotated[bool, FLAG, Parameter(group=OUTPUT, help="Replace existing files.")]
OwnCode = Annotated[
    bool,
    FLAG,
    Parameter(
        group=CONFIGURATION,
        help="Run the Python code that a file names as its detector, MODULE:CALLABLE.",
    ),
]


@options(FRAMES)
class FrameOptions:
    """The frames that are read."""

    start: Whole = 0
    """First frame."""
    end: Whole | None = None
    """Stop before this frame."""
    stride: Whole = 1
    """Read every n-th frame."""
    fps: Fps = None
    reconnect: Annotated[float | None, Parameter(group=LIVE)] = None
    """If a live source fails, try to open it again for this many seconds, with growing pauses; then
    end with an error. The default is no limit."""

    def open(self, source: str, *, whole: bool = False) -> "Source":
        """Return the frames of a source, if `whole` also those from `end` on.

        Raises a SourceError if it cannot be read.
        """
        from motes.video.sources import is_remote, open_source

        if self.reconnect is not None and not self.reconnect >= 0:
            raise ConfigError(f"--reconnect is {self.reconnect:g}; give seconds, 0 or more.")
        if self.reconnect is not None and not is_remote(source):
            raise ConfigError(f"--reconnect is for live sources, which {source} is not; omit it.")
        return open_source(
            source,
            start=self.start,
            end=None if whole else self.end,
            stride=self.stride,
            fps=self.fps,
            on_drop=log,
            patience=self.reconnect,
        )


def say_rate(film: "Source | Film") -> None:
    """Print that a frame rate is assumed, if it is."""
    if film.report.assumption is not None:
        log(f"{film.name}: {film.report.assumption}")


@options(OUTPUT)
class OutputOptions:
    """The outputs of a run."""

    output: Annotated[FileName | None, HYPHEN, Parameter(name=["--output", "-o"])] = None
    """Rows of each frame: a .csv, .jsonl or .txt (MOTChallenge) file, or - for standard output; or
    a document for annotation tools: .json (COCO) or .xml (CVAT). motes convert --list has all
    formats."""
    format: str | None = None
    """Format of --output, whatever its ending is."""
    keyframe_error: KeyframeError = None
    with_guesses: WithGuesses = False
    label: str | None = None
    """Class of the objects whose detector tells none. [default: none in rows, object in
    documents]"""
    overlay: Path | None = None
    """Video with the tracks drawn: .mp4, .mkv, .mov or .m4v."""
    overwrite: Overwrite = False


@options(CONFIGURATION)
class ConfigOptions:
    """Changes of a preset."""

    config: ConfigFile = None
    changes: Changes = None
    seed: Whole = 0
    """Seed of the random numbers: 0 or more."""
    dump_config: Annotated[bool, FLAG] = False
    """Print the whole configuration as TOML and exit."""


HelpAll = Annotated[
    bool, FLAG, Parameter(group=CONFIGURATION, help="List all options of this command.")
]


class Help:
    """Shows the help of a command, with its texts from docstrings as running text.

    `usual` are the options that are shown, beside all arguments; by default all.
    """

    def __init__(self, *usual: str) -> None:
        self.usual = frozenset(usual)

    def __call__(self, console: "Console", options: "ConsoleOptions", panel: "HelpPanel") -> None:
        """Show a group of arguments or options, unless no usual one is among them."""
        from cyclopts.help import DefaultFormatter

        shown = [
            _running(entry)
            for entry in panel.entries
            if not (self.usual and entry.positive_names)
            or self.usual.intersection(entry.positive_names)
        ]
        DefaultFormatter()(console, options, panel.copy(entries=shown))

    def render_usage(self, console: "Console", options: "ConsoleOptions", usage: Any) -> None:
        """Show how the command is called."""
        from cyclopts.help import DefaultFormatter

        DefaultFormatter().render_usage(console, options, usage)


def _running(entry: "HelpEntry") -> "HelpEntry":
    """Return an entry whose text has no line breaks."""
    from rich.text import Text

    text = getattr(entry.description, "primary_renderable", None)
    if isinstance(text, Text):
        entry.description.primary_renderable = Text(" ".join(text.plain.split()), end=text.end)
    return entry
