"""What several commands share: options, the configuration they make, and checks."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter, Token

from motes.core.errors import ConfigError, clear

if TYPE_CHECKING:
    pass

TARGET = Group("Target (one of these)", sort_key=1)
DATASET = Group("Dataset", sort_key=1)
RUN = Group("Run", sort_key=2)
FRAMES = Group("Frames", sort_key=2)
OUTPUT = Group("Output", sort_key=3)
CONFIGURATION = Group("Configuration", sort_key=4)

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
  --presence.max_threshold 0.9
  --presence.stride 1
  --presence.max_positions 400000
  --calibration.middle 0.34
  --calibration.width 0.08
  --adaptation.type forgetting
  --adaptation.learning_rate 0.0
  --adaptation.anchor 0.0
"""
"""Preset nummiaro, written down here as well: to get it means to load the whole tracker."""

CONFIG_HELP = f"""\
Every key of the configuration is an option too. The preset comes first, then the file of \
--config, then these options. Preset nummiaro has

{CONFIG_FLAGS}
--motion.type may also be random_walk, second_order, ellipse_walk or autoregressive, --color.space \
hsv or hsv+v, --color.sampling.type checkerboard or every_pixel, --fusion.type fixed or product, \
--likelihood.type best_particle or exponential, --adaptation.type kalman, gaussian or per_cue. \
A cue is added by naming a key of it, as --orientation.bins 36, --edges.bins 8, --hog.cells 3, \
--correlation.learning_rate 0.02 or --posterior.learning_rate 0.04. \
--dump-config shows all keys and values of a preset, as a file for --config.
"""


def _read_setting(_: Any, tokens: Any) -> Any:
    """Return what cyclopts gathered under a key, a list of tokens or a nest of such lists."""
    return _read_nest(tokens, 1)


def _read_nest(tokens: Any, depth: int) -> Any:
    from motes.core.config import DEEPEST, from_flag

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


def log(message: str) -> None:
    """Print a line for people."""
    print(f"motes: {clear(message)}", file=sys.stderr)
