"""What several commands share: options, the configuration they make, and checks."""

from __future__ import annotations

import contextlib
import difflib
import inspect
import itertools
import os
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any
from urllib.parse import urlsplit

from cyclopts import Group, Parameter, Token

from motes.errors import ConfigError, FormatError, SourceError, clear
from motes.files import leftovers, same_file

if TYPE_CHECKING:
    from motes.presets import TrackerConfig
    from motes.target import Target

TARGET = Group("Target (one of these)", sort_key=1)
DATASET = Group("Dataset", sort_key=1)
RUN = Group("Run", sort_key=2)
FRAMES = Group("Frames", sort_key=2)
OUTPUT = Group("Output", sort_key=3)
CONFIGURATION = Group("Configuration", sort_key=4)

MOST = 1_000_000
"""Seeds, frames to render, or rounds: nobody can wait for more of them."""
CONFIG_FLAGS = """\
  --particles 100
  --motion.type constant_velocity
  --motion.noise.position 0.6
  --motion.noise.size 0.05
  --motion.noise.size_return 0.05
  --motion.noise.aspect 0.003
  --motion.noise.angle 0.0
  --motion.velocity 0.5
  --motion.persistence 0.8
  --color.space rgb
  --color.bins 8,8,8
  --color.kernel radial
  --color.sampling.type lattice
  --color.sampling.points 256
  --fusion.type adaptive
  --fusion.floor 0.5
  --likelihood.type gaussian
  --likelihood.sigma 0.1
  --likelihood.epsilon 0.0
  --resampling.scheme multinomial
  --resampling.threshold 1.0
  --presence.fraction 0.1
  --presence.frames 5
  --presence.deviations 2.0
  --presence.margin 0.7
  --presence.ceiling 0.9
  --presence.step 1
  --presence.places 400000
  --calibration.middle 0.34
  --calibration.width 0.08
  --adaptation.type forgetting
  --adaptation.rate 0.0
  --adaptation.anchor 0.0
"""
"""Preset nummiaro, written down here as well: to get it means to load the whole tracker."""

CONFIG_HELP = f"""\
Every key of the configuration is an option too. The preset comes first, then the file of \
--config, then these options. Preset nummiaro has

{CONFIG_FLAGS}
--motion.type may also be random_walk, second_order, ellipse_walk or autoregressive, --color.space \
hsv or hsv+v, --color.sampling.type checkerboard or every_pixel, --fusion.type fixed or product, \
--likelihood.type best_particle or exponential, --adaptation.type kalman, gaussian or by_cue. \
A cue is added by naming a key of it, as --orientation.bins 36, --edges.bins 8, --hog.cells 3, \
--correlation.rate 0.02 or --posterior.rate 0.04. \
--dump-config shows all keys and values of a preset, as a file for --config.
"""


def _read_setting(_: Any, tokens: Any) -> Any:
    """Return what cyclopts gathered under a key, a list of tokens or a nest of such lists."""
    return _read_nest(tokens, 1)


def _read_nest(tokens: Any, depth: int) -> Any:
    from motes.config import DEEPEST, from_flag

    if depth > DEEPEST:
        raise ConfigError(f"An option has no more than {DEEPEST} parts.")
    if isinstance(tokens, dict):
        return {key: _read_nest(inner, depth + 1) for key, inner in tokens.items()}
    token: Token = tokens[-1]
    return from_flag("value", token.value)["value"]


Settings = Annotated[Any, Parameter(converter=_read_setting, show=False)]
Init = Annotated[
    str | None, Parameter(group=TARGET, allow_leading_hyphen=True, help="Box: x,y,width,height.")
]
Ellipse = Annotated[
    str | None,
    Parameter(
        group=TARGET,
        allow_leading_hyphen=True,
        help="Center, half-axes, angle from the x axis towards y in radians: x,y,a,b,theta.",
    ),
]
Preset = Annotated[
    str,
    Parameter(
        group=CONFIGURATION,
        help="nummiaro, nummiaro:adaptive, maggio, ng_delp, zhao_pei, mean_shift or "
        "mean_shift:kalman; or a variant: ng_delp:color, ng_delp:edges, zhao_pei:fixed, "
        "zhao_pei:72, zhao_pei:color, zhao_pei:hog, maggio:C, maggio:O-FOH, maggio:O-ROH, "
        "maggio:C+O-SS-FOH, maggio:C+O-SS-ROH, "
        "maggio:C+O-A-FOH, maggio:C+O-A-ROH, maggio:C+O-A&SS-FOH, maggio:C+O-A&SS-ROH.",
    ),
]
ConfigFile = Annotated[
    Path | None, Parameter(group=CONFIGURATION, help="TOML file laid over the preset.")
]
DumpConfig = Annotated[
    bool,
    Parameter(
        group=CONFIGURATION,
        negative=(),
        show_default=False,
        help="Print the whole configuration as TOML and exit.",
    ),
]
Workers = Annotated[
    int | None, Parameter(group=RUN, help="Processes; one for each core by default.")
]
FirstPixel = Annotated[
    list[str] | None,
    Parameter(
        group=DATASET,
        negative=(),
        help="What the truth calls the first pixel, 0 or 1, or 'GLOB=0' for some sequences; by "
        "default as the layout has it.",
    ),
]
Label = Annotated[
    str | None,
    Parameter(
        group=OUTPUT,
        help="Name of the objects' class in a .json or .xml document. [default: object]",
    ),
]
Overwrite = Annotated[
    bool,
    Parameter(group=OUTPUT, negative=(), show_default=False, help="Replace what is there already."),
]


def say(message: str) -> None:
    """Print a line for people."""
    print(f"motes: {clear(message)}", file=sys.stderr)


def region_of(init: str | None, ellipse: str | None) -> Sequence[float] | None:
    """Return the region that a user gave as numbers with commas, as box or as ellipse.

    Raises
    ------
    ConfigError
        If the text is none.
    """
    for flag, text, form in (
        ("--init", init, "x,y,width,height"),
        ("--ellipse", ellipse, "x,y,a,b,theta"),
    ):
        if text is not None:
            return numbers_of(flag, text, form)
    return None


def numbers_of(flag: str, text: str, form: str) -> list[float]:
    """Return the numbers of an option that takes them in a form such as x,y,width,height.

    Raises
    ------
    ConfigError
        If the text does not have that form.
    """
    try:
        numbers = [float(number) for number in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != len(form.split(",")):
        raise ConfigError(f"{flag} takes {form}, numbers with commas; got {text!r}.")
    return numbers


def first_pixels(texts: Sequence[str]) -> dict[str, int]:
    """Return what --first-pixel says, by the pattern of the sequences that it is for.

    Raises
    ------
    ConfigError
        If a text is not of its form.
    """
    pixels = {}
    for text in texts:
        pattern, _, number = text.rpartition("=")
        if number not in ("0", "1"):
            raise ConfigError(f"--first-pixel takes 0, 1 or GLOB=0, as in 'seg-*=0'; got {text!r}.")
        pixels[pattern or "*"] = int(number)
    return pixels


def worker_count(workers: int | None) -> int:
    """Return how many processes --workers asks for; raise a ConfigError for none."""
    if workers is not None and workers < 1:
        raise ConfigError(f"--workers is {workers}; give 1 or more.")
    return workers or os.cpu_count() or 1


def check_counts(**counts: int) -> None:
    """Check numbers of seeds, frames or rounds; raise a ConfigError for none and for too many."""
    for name, count in counts.items():
        if count < 1:
            raise ConfigError(f"--{name} is {count}; give 1 or more.")
        if count > MOST:
            raise ConfigError(f"--{name} is {count}; give {MOST} or fewer.")


def tracker_config(
    command: Callable[..., object],
    preset: str,
    file: Path | None,
    settings: dict[str, Any],
    target: Target | None = None,
) -> TrackerConfig:
    """Return the preset, with the target's cue, the file and the settings laid over it in turn.

    An unknown setting may be a misspelled option of the command, whose parameters name them.

    Raises
    ------
    ConfigError
        For what is unknown or makes no sense.
    SourceError
        If the file cannot be read.
    """
    from motes import presets
    from motes.config import from_toml, to_dict

    base = presets.preset(preset)
    if target is not None:
        base = presets.configure(base, {"color": to_dict(target.cue)})
    if file is not None:
        with named(file):
            base = presets.configure(base, from_toml(read_text(file), "this file"))
    check_settings(command, to_dict(base), settings)
    return presets.configure(base, settings)


def check_settings(
    command: Callable[..., object], known: Iterable[str], settings: dict[str, Any]
) -> None:
    """Check that settings are known keys: an unknown one may be a misspelled option of the command.

    Raises
    ------
    ConfigError
        With the nearest known key or option.
    """
    known = list(known)
    unknown = [key for key in settings if key not in known]
    if unknown and "type" not in settings:
        raise ConfigError(no_such_option(command, f"--{unknown[0]}", known))


def no_such_option(command: Callable[..., object], flag: str, known: Iterable[str]) -> str:
    """Return that a command has no such option, with the nearest of its own and of known keys."""
    options = [name.replace("_", "-") for name in inspect.signature(command).parameters]
    near = difflib.get_close_matches(flag.lstrip("-"), [*known, *options], n=1)
    hint = f"did you mean --{near[0]}?" if near else f"see motes {command.__name__} --help."
    return f"There is no option {flag} with this preset; {hint}"


@contextlib.contextmanager
def named(where: Path | str) -> Iterator[None]:
    """Say of a configuration's error which file or option it is in."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}") from None


def read_text(path: Path) -> str:
    """Return the text of an input file.

    Raises
    ------
    SourceError
        If it cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise SourceError(f"{path} cannot be read: {error.strerror}; check the name.") from None
    except UnicodeDecodeError:
        raise SourceError(f"{path} is not a text; check the name.") from None


def load_target(path: Path) -> Target:
    """Return the target in a histogram file; raise a SourceError where there is none."""
    from motes.target import Target

    try:
        return Target.load(path)
    except FormatError as error:
        raise SourceError(str(error)) from None


def default_output(source: str) -> str:
    """Return where rows go if nobody says so."""
    if not sys.stdout.isatty():
        return "-"
    path = urlsplit(source).path if "://" in source else os.path.abspath(source)
    stem = re.sub(r"[^\w .+-]+", "-", Path(path).stem).strip("-") or "tracks"
    say(f"Writing {stem}.csv; choose another name with -o.")
    return f"{stem}.csv"


def check_not_source(source: str, *outputs: Path | None) -> None:
    """Check that no two of these are the same file, by its name or by a link.

    Raises
    ------
    ConfigError
        If an output is the source, or another output.
    """
    paths = [path for path in outputs if path is not None]
    if any(same_file(source, path) for path in paths):
        raise ConfigError(f"{source} is the source and cannot be an output; choose another name.")
    if any(same_file(*pair) for pair in itertools.combinations(paths, 2)):
        raise ConfigError("Two outputs are the same file; give each its own.")


def point_out_leftovers(*outputs: Path | None) -> None:
    """Name the partial files that runs with the same outputs have left."""
    for path in outputs:
        for left in leftovers(path) if path is not None else []:
            say(f"{left} is an unfinished {path} of a run that was cut short, or still goes on.")


def check_label(label: str | None, output: str | None) -> None:
    """Check the class that a user names for the objects of an output.

    Raises
    ------
    ConfigError
        If no tool would take the name, or the output has no classes.
    """
    from motes.documents import is_document

    if label is None:
        return
    if output is None or not is_document(output):
        raise ConfigError(
            "--label is for documents, which end in .json or .xml; rows have no class: omit it."
        )
    if not (label.strip() and label.isprintable()):
        raise ConfigError(f"--label is {label!r}; give a name in letters that can be printed.")


def prepare_folder(out: Path, files: Iterable[str], overwrite: bool) -> None:
    """Make a folder, and check that each of these files can be made there.

    Raises
    ------
    FormatError
        If one cannot.
    """
    from motes.formats import check_writable

    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FormatError(
            f"The folder {out} cannot be made: {error.strerror}; choose another with --out."
        ) from None
    for name in files:
        check_writable(out / name, overwrite)
        point_out_leftovers(out / name)


def announce_compiling() -> None:
    """Tell the user why a start takes long, if kernels must be compiled in it."""
    from motes.kernels import compiling

    folder = compiling.FOLDER
    writable = folder is not None and os.access(folder, os.W_OK)
    kept = "once for this machine; later starts are quick."
    lost = "there is no folder to keep them in (see motes doctor)."
    why = kept if writable else lost
    compiling.when_compiling(lambda: say(f"Compiling kernels, {why}"))
    if writable:
        advice = "make room there, or every start compiles."
        compiling.when_unkept(
            lambda error: say(f"{folder} cannot keep them: {error.strerror}; {advice}")
        )
