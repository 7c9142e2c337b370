"""Write the values of the papers' presets into lab/docs/papers.md, beside what the papers print.

`python docs/generate/paper_values.py`; a test compares the page with what this would write. The
papers' column is typed by hand, the others are read from the presets.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from inspect import signature
from pathlib import Path
from typing import Any, NamedTuple

from motes.mot.scene_config import scene_config
from motes.sot.presets import PRESETS, preset

PAGE = Path(__file__).resolve().parents[2] / "lab" / "docs" / "papers.md"
START, END = "<!-- values of the presets -->\n\n", "\n<!-- values up to here -->"
OPEN = "not given"
"""What a paper says of a value that it needs and does not print."""


class Value(NamedTuple):
    """A value of a paper.

    Attributes
    ----------
    what, place
        What it is, and the paper's equation or section.
    paper
        The paper's value, as it prints it; `OPEN` if it prints none.
    key
        The value's key in a configuration.
    meant
        What the key has to be for the paper's value; None where the paper leaves it open.
    """

    what: str
    place: str
    paper: str
    key: str
    meant: Any = None


ALWAYS = Value("is the target there", "", "always", "presence.max_threshold", 0.0)
VALUES = {
    "nummiaro": (
        Value("samples", "N VII", "100", "particles", 100),
        Value("bins, RGB", "N III", "8x8x8", "color.bins", (8, 8, 8)),
        Value("pixels", "N 3", "every one", "color.sampling", {"type": "every_pixel"}),
        Value("sigma", "N 10", OPEN, "likelihood.sigma"),
        Value("velocity that is kept", "N 8, 9", "all", "motion.persistence", 1.0),
        Value("noise of the position", "N 9", OPEN, "motion.noise.position"),
        Value("common factor of the size", "N 8", "none", "motion.noise.size", 0.0),
        Value("return to the first size", "N 8", "none", "motion.noise.size_return", 0.0),
        Value("noise of each half-axis", "N 8", OPEN, "motion.noise.aspect"),
        Value("fraction f", "N V", "0.1", "presence.fraction", 0.1),
        Value("deviations above the mean", "N 13", "2", "presence.deviations", 2.0),
        Value("margin above the mean", "N 13", "none", "presence.margin", 0.0),
        Value("contrast", "N 13", "none", "presence.contrast", 0.0),
        Value("spread, half-axes", "N 13", "none", "presence.spread", 0.0),
        Value("highest threshold", "N 13", "none", "presence.max_threshold", 1.0),
        Value("lost after, frames", "N V", "a couple", "presence.frames", 2),
        Value("found after, frames", "N V", "1", "presence.found_frames", 1),
        Value("places of the background", "N 11, 12", "all", "presence.max_positions", 10**9),
        Value("centers in the picture alone", "N 11, 12", OPEN, "presence.in_frame"),
    ),
    "maggio": (
        Value("samples", "M 5", "150", "particles", 150),
        Value("bins, RGB", "M 5", "10x10x10", "color.bins", (10, 10, 10)),
        Value("bins of orientation", "M 5", "36", "orientation.bins", 36),
        Value("pixels", "M 1", "every one", "color.sampling", {"type": "every_pixel"}),
        Value("share of pixels above T", "M 3.2", OPEN, "orientation.kept_fraction"),
        Value("noise of x, y, pixels", "M 5", "5.5, faces 10", "motion.position", 5.5),
        Value("noise of h", "M 5", "0.05", "motion.size", 0.05),
        Value("noise of e", "M 5", "0.021", "motion.eccentricity", 0.021),
        Value("noise of the angle", "M 5", "10 degrees", "motion.angle", math.radians(10)),
        Value("sigma", "M 6", OPEN, "likelihood.sigma"),
        Value("fusion", "M 7 to 10", "adaptive sum", "fusion.type", "printed_mixture"),
        ALWAYS,
    ),
    "ng_delp": (
        Value("samples", "ND 2", OPEN, "particles"),
        Value("bins, HSV", "ND 3.1", "8x8x4", "color.bins", (8, 8, 4)),
        Value("threshold of edges", "ND 3.2", "100", "edges.threshold", 100.0),
        Value("pixels, color", "ND 16", "every one", "color.sampling", {"type": "every_pixel"}),
        Value("pixels, edges", "ND 17", "every one", "edges.sampling", {"type": "every_pixel"}),
        Value("color and edges", "ND 3", OPEN, "fusion.type"),
        Value("epsilon", "ND figure 3", "0.1", "likelihood.epsilon", 0.1),
        Value("least sigma", "ND 24", "none", "likelihood.floor", 0.001),
        ALWAYS,
    ),
    "zhao_pei": (
        Value("samples", "ZP 4", "400", "particles", 400),
        Value("bins, HSV", "ZP 4", "8x8+8", "color.bins", (8, 8, 8)),
        Value("bins of HOG", "ZP 4", "8", "hog.bins", 8),
        Value("pixels", "ZP 1, 2", "every one", "color.sampling", {"type": "every_pixel"}),
        Value("lambda", "ZP 2.3", OPEN, "likelihood.rate"),
        Value("update of color", "ZP 3 to 15", "Kalman", "adaptation.cues.color.type", "kalman"),
        Value("residuals L", "ZP 11", OPEN, "adaptation.cues.color.frames"),
        Value("alpha", "ZP 2.2", "0.1", "adaptation.cues.color.alpha", 0.1),
        Value("update of HOG", "ZP 16", "Gaussian", "adaptation.cues.hog.type", "gaussian"),
        Value("beta", "ZP 16", "0.1", "adaptation.cues.hog.beta", 0.1),
        Value("deviations of a bin", "ZP 16", "3", "adaptation.cues.hog.deviations", 3.0),
        ALWAYS,
    ),
}  # fmt: skip
"""The papers' values, by the preset that is shipped; PRESET:printed is the other column."""


def value_of(name: str, key: str) -> Any:
    """Return a value of a preset's configuration by its dotted key; None if it has no such key."""
    found: Any = preset(name).to_dict()
    for part in key.split("."):
        found = found.get(part) if isinstance(found, Mapping) else None
    return found


def as_text(value: Any) -> str:
    """Return a value as the table shows it."""
    if value is None:
        return "–"
    if isinstance(value, Mapping):
        kind, *numbers = value.values()
        return " ".join([str(kind).replace("_", " "), *map(str, numbers)])
    if isinstance(value, tuple):
        return "x".join(map(str, value))
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def table() -> str:
    """Return the table in Markdown; values that differ from the paper's are bold.

    What a paper prints and the shipped preset has too is left out.
    """
    lines = ["| value | place | paper | key | as printed | shipped |", "|---|---|---|---|---|---|"]
    for name, values in VALUES.items():
        lines.append(f"| **`{name}`** | | | | `{name}:printed` | `{name}` |")
        for each in values:
            printed, shipped = (value_of(key, each.key) for key in (f"{name}:printed", name))
            if printed == shipped and each.paper != OPEN:
                continue
            cells = []
            for found in (printed, shipped):
                same = each.paper == OPEN or found == each.meant
                cells.append(as_text(found) if same else f"**{as_text(found)}**")
            known, within, part = each.key.partition(".cues.")
            key = f"`{known}.cues.NAME`: {part}" if within else f"`{known}`"
            lines.append(f"| {' | '.join([each.what, each.place, each.paper, key, *cells])} |")
    return "\n".join(lines) + "\n"


def watched() -> str:
    """Return what `motes watch` follows with, which is another preset."""
    name = signature(scene_config).parameters["tracker"].default
    cues = ", ".join(PRESETS[name].cues)
    return (
        f"`motes watch` follows each object with `{name}`: {value_of(name, 'particles')} samples "
        f"and {cues} alone. `--preset zhao_pei` has the features of Zhao and Pei.\n"
    )


def generated() -> str:
    """Return all that stands between `START` and `END`."""
    return f"{table()}\n{watched()}"


def main() -> int:
    """Write the table into the page."""
    text = PAGE.read_text(encoding="utf-8")
    before, _, rest = text.partition(START)
    _, _, after = rest.partition(END)
    PAGE.write_text(f"{before}{START}{generated()}{END}{after}", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
