"""Occlusions on film: found from the truth's boxes, and identities kept or not."""

from pathlib import Path

import numpy as np
import pytest

from commands import read_csv
from crowds import rows, write_crowd
from in_process import work_here
from motes_lab.cli import main
from motes_lab.datasets.mot_rows import MotRows
from motes_lab.papers import real_occlusions
from motes_lab.papers.real_occlusions import Counts, Occlusion, count, identities, occlusions_of

FRAMES = 40
STANDING = (100.0, 40.0, 20.0, 60.0)
"""The nearer one: its lower edge is at 100."""


def truth(lefts: list[float], top: float = 30.0, height: float = 60.0) -> MotRows:
    """Return who stands, 1, and who walks behind: 2, at these places from frame 1 on."""
    lines = [(float(f), 1.0, *STANDING) for f in range(1, FRAMES + 1)]
    lines += [(f + 1.0, 2.0, x, top, 20.0, height) for f, x in enumerate(lefts) if np.isfinite(x)]
    return rows(*lines)


PASSING = [40.0 + 3 * f for f in range(FRAMES)]
"""Touches 1 in the frames 15 to 27: at 82 and at 118."""


def aside(frames: int) -> list[float]:
    """Return the way of one who is elsewhere for some frames."""
    return [*PASSING[:20], *[200.0] * frames, *PASSING[20 : 40 - frames]]


@pytest.mark.parametrize(
    ("lefts", "top", "found"),
    [
        (PASSING, 30.0, [Occlusion(2, 1, range(5, 15), range(28, 38))]),
        (
            PASSING,
            45.0,
            [Occlusion(1, 2, range(5, 15), range(28, 38))],
        ),  # it passes before the other
        (PASSING, -20.0, []),  # never half covered
        ([200.0] * FRAMES, 30.0, []),  # never touched
        ([90.0 + 3 * f for f in range(FRAMES)], 30.0, []),  # no frames before
        ([float("nan")] * 12 + PASSING[12:], 30.0, []),  # too few frames before
        (aside(4), 30.0, [Occlusion(2, 1, range(5, 15), range(32, 41))]),  # no end
    ],
)
def test_occlusions(lefts: list[float], top: float, found: list[Occlusion]) -> None:
    assert occlusions_of(truth(lefts, top), FRAMES) == found
    assert len(occlusions_of(truth(aside(6)), FRAMES)) == 2


@pytest.mark.parametrize(
    ("hidden", "front", "counts"),
    [
        ((7, 7), (3, 3), Counts(1, 0, 0, 1)),
        ((7, 7), (3, 4), Counts(1, 0, 0, 0)),
        ((7, 7), (None, None), Counts(1, 0, 0, 0)),
        ((7, 8), (3, 3), Counts(0, 1, 0, 0)),
        ((7, None), (3, 3), Counts(0, 0, 1, 0)),
        ((None, None), (3, 3), Counts(0, 0, 1, 0)),
    ],
)
def test_identities_are_kept_or_changed(
    hidden: tuple[int | None, ...], front: tuple[int | None, ...], counts: Counts
) -> None:
    occlusion = Occlusion(2, 1, range(1, 6), range(8, 13))
    names: dict[tuple[int, int], int] = {}
    for who, pair in ((2, hidden), (1, front)):
        for name, frames in zip(pair, occlusion[2:], strict=True):
            if name is not None:
                names |= {(frame, who): name for frame in frames}
                names[frames[1], who] = 99  # the most frequent one counts
    assert count([occlusion], names) == counts


def test_a_box_is_the_person_that_it_overlaps_by_half() -> None:
    there = truth(PASSING)
    moved = rows(*[(1.0, 5.0, 41.0, 30.0, 20.0, 60.0), (2.0, 6.0, 60.0, 30.0, 20.0, 60.0)])
    assert identities(there, moved) == {(1, 2): 5}


@pytest.mark.slow
def test_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    film = write_crowd(tmp_path / "data" / "film", frames=FRAMES)
    there = truth(PASSING)
    for name, first, flag in (("gt", 0, 1), ("kept", 0, 0.9), ("swapped", 20, 0.9)):
        lines = []
        for f, who, box in zip(there.frames, there.ids, there.boxes.tolist(), strict=True):
            mine = 3 - who if first and f > first else who
            lines.append(",".join(map(str, (f, mine, *box, flag))) + "\n")
        path = film / "gt" / "gt.txt" if name == "gt" else tmp_path / name / "film.txt"
        path.parent.mkdir(exist_ok=True)
        path.write_text("".join(lines))
    saved = [f"results={tmp_path / name}" for name in ("kept", "swapped")]
    line = ["experiment", "real-occlusions", str(film.parent), "--out", str(tmp_path / "out")]
    monkeypatch.setattr(real_occlusions, "TRACKERS", saved)
    work_here(monkeypatch)
    assert main(line) == 0, capfd.readouterr().err
    table = read_csv(tmp_path / "out" / "real-occlusions.csv")
    columns = ("sequence", "occlusions", "kept", "changed", "not followed", "both kept")
    found = [(row["tracker"], *(row[name] for name in columns)) for row in table]
    assert found == [
        (saved[0], "film", "1", "1", "0", "0", "1"),
        (saved[1], "film", "1", "0", "1", "0", "0"),
        (saved[0], "all", "1", "1", "0", "0", "1"),
        (saved[1], "all", "1", "0", "1", "0", "0"),
    ]
