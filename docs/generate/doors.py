"""Writes what programs may import into docs/api.md: `python docs/generate/doors.py`."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "api.md"
DOORS = ("core", "video", "sot", "mot", "rows", "correction", "formats", "cli")
"""Packages of motes with a door for programs; `motes.cues` is for users too."""
HEAD = "| package | names |\n|---|---|\n"


def table() -> str:
    """Return a row for each package, with its names as `__all__` has them."""
    rows = []
    for name in DOORS:
        names = importlib.import_module(f"motes.{name}").__all__
        rows.append(f"| `motes.{name}` | {', '.join(f'`{each}`' for each in names)} |\n")
    return HEAD + "".join(rows)


if __name__ == "__main__":
    text = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(re.sub(re.escape(HEAD) + r"(\|.*\n)*", table(), text), encoding="utf-8")
