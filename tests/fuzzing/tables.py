"""Tables of speed that `motes-lab bench --against` reads."""

from __future__ import annotations

from pathlib import Path

from motes_lab.report.tables import Cell, Table
from motes_lab.speed.report import against, stored_ratios

from .outcomes import check_finite, outcome

HEAD = ("tracker", "target", "ms", "times cv2:kcf", "times cv2:csrt")
ROW = ("default", "60x60", "1.62", "0.41", "0.09")


def seeds() -> list[bytes]:
    """Return a page with a table."""
    rows = [HEAD, ("---",) * 5, ROW, ("cv2:kcf", "60x60", "3.9", "1", ""), ("nummiaro", *ROW[1:])]
    table = "".join(f"| {' | '.join(row)} |\n" for row in rows)
    return [f"# Speed\n\n{table}\nAnd so on.\n".encode()]


def check(data: bytes) -> str:
    """Read the ratios of a page, and compare others with them."""
    now = Table("Speed", HEAD, [tuple(map(Cell, ROW))])

    def read() -> None:
        stored = stored_ratios(data.decode(errors="replace"), Path("speed.md"))
        check_finite(stored.values())
        against(now, stored)

    return outcome(read)
