"""Options that several commands of the lab share."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

from cyclopts import Group, Parameter

from motes.cli.options import HYPHEN, REPEATED, RUN
from motes.core.errors import ConfigError

DATASET = Group("Dataset", sort_key=1)
FirstPixel = Annotated[
    list[str] | None,
    Parameter(
        group=DATASET,
        negative=(),
        help="Coordinate of the first pixel in the ground truth: 0 or 1, or 'GLOB=0' for some "
        "sequences. The default is that of the dataset's layout.",
    ),
]
Only = Annotated[
    list[str] | None,
    REPEATED,
    Parameter(group=DATASET, help="Only these sequences, such as 'seg-*'; may be repeated."),
]
Seeds = Annotated[
    int, Parameter(group=RUN, help="Number of runs of each tracker that uses random numbers.")
]
Region = Annotated[
    str | None,
    HYPHEN,
    Parameter(help="The target in the first frame: a box x,y,width,height."),
]


def first_pixels(texts: Sequence[str]) -> dict[str, int]:
    """Return the values of --first-pixel, by the pattern of their sequences.

    Raises
    ------
    ConfigError
        If a text has another form.
    """
    pixels = {}
    for text in texts:
        pattern, _, number = text.rpartition("=")
        if number not in ("0", "1"):
            raise ConfigError(f"--first-pixel takes 0, 1 or GLOB=0, as in 'seg-*=0'; got {text!r}.")
        pixels[pattern or "*"] = int(number)
    return pixels
