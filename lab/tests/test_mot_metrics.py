"""Metrics of many objects: by hand, and as TrackEval has them."""

from functools import reduce
from operator import add
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

from crowds import assert_equal, combined, from_files, perturbed, rows, theirs, trackeval
from motes_lab.datasets.distractors import DISTRACTORS, evaluated_rows
from motes_lab.datasets.mot_rows import MotRows, read_rows
from motes_lab.metrics.mot import Tally, errors, tally
from motes_lab.protocols.mot import write_rows

SEQUENCES = ("TUD-Campus", "TUD-Stadtmitte", "PETS09-S2L1-first200")


def ours(truth: MotRows, results: MotRows, frames: int, distractors: tuple[int, ...]) -> Tally:
    return tally(*evaluated_rows(truth, results, distractors), frames)


def line(identity: int, frames: range, x: float = 0, shift: float = 0) -> list[tuple[float, ...]]:
    """Return an object of 10x10 that stands still, as seen from `shift` pixels away."""
    return [(frame, identity, x + shift, 0, 10, 10) for frame in frames]


def test_errors_by_hand() -> None:
    """Tracks 5 and 6 change persons in frame 3, and back in frame 4; 7 is nobody, 8 on person 1."""
    truth = rows(*line(1, range(1, 6)), *line(2, range(1, 6), x=50), *line(3, range(1, 6), x=52))
    results = rows(
        *line(5, range(2, 3)), *line(5, range(3, 4), x=50), *line(5, range(4, 6)),
        *line(6, range(1, 3), x=50), *line(6, range(3, 4)), *line(6, range(4, 6), x=50),
        *line(7, range(2, 4), x=90), *line(8, range(5, 6), shift=1),
    )  # fmt: skip
    found = errors(truth, results)
    assert (found.handovers, found.exchanges) == (4, 2)
    assert (found.ghosts, found.doubled) == (2, 1)
    assert (found.merged, found.late) == (5, 1)  # 3 stands in the box of 2 or of 5
    assert errors(truth, rows(*line(5, range(1, 6)))).handovers == 0


FRAMES = 6


@st.composite
def crowds(draw: st.DrawFn, columns: st.SearchStrategy[tuple[int, int]]) -> MotRows:
    """Return some rows; boxes are whole numbers, so that there are ties."""
    side = st.sampled_from([4, 6, 8])
    box = st.tuples(st.integers(0, 12), st.integers(0, 4), side, side)
    keys = draw(st.sets(st.tuples(st.integers(1, FRAMES), st.integers(1, 4))))
    order = draw(st.permutations(sorted(keys)))
    return rows(*(key + draw(box) + draw(columns) for key in order))


PLAIN = crowds(st.just((1, 1)))
LABELED = crowds(st.tuples(st.sampled_from([0, 1, 1]), st.sampled_from([1, 1, 2, 3, 6, 7, 12])))
NOTHING = rows()


@pytest.mark.slow
@given(PLAIN, PLAIN)
@example(NOTHING, NOTHING)
@example(NOTHING, rows(*line(1, range(1, 4))))
@example(rows(*line(1, range(1, 4))), NOTHING)
@example(  # two that swap
    rows(*line(1, range(1, 7)), *line(2, range(1, 7), x=30)),
    rows(
        *line(1, range(1, 4)), *line(2, range(1, 4), x=30),
        *line(2, range(4, 7)), *line(1, range(4, 7), x=30),
    ),
)  # fmt: skip
@example(rows((1, 1, 0, 0, 0.6, 1)), rows((1, 1, 0.4, 0, 0.6, 1)))  # 0.2, but for rounding
def test_as_trackeval(truth: MotRows, results: MotRows) -> None:
    assert_equal(tally(truth, results, FRAMES), theirs(truth, results, FRAMES))


@pytest.mark.slow
@given(LABELED, PLAIN)
def test_what_counts_is_as_in_trackeval(truth: MotRows, results: MotRows) -> None:
    for benchmark, distractors in (("MOT17", DISTRACTORS), ("MOT20", (*DISTRACTORS, 6))):
        found = ours(truth, results, FRAMES, distractors)
        assert_equal(found, theirs(truth, results, FRAMES, benchmark))


@pytest.mark.slow
def test_real_sequences_as_trackeval(data: Path, tmp_path: Path) -> None:
    """Perturbed truth as results, through files."""
    trackeval()
    folder, found, other = tmp_path / "mine", [], []
    folder.mkdir()
    for seed, name in enumerate(SEQUENCES):
        home = data / "mot" / name
        frames = len(list((home / "img1").iterdir()))
        truth = read_rows(home / "gt" / "gt.txt", frames, "truth")
        results = perturbed(np.random.default_rng(seed), truth, frames)
        write_rows(folder / f"{name}.txt", results)
        results = read_rows(folder / f"{name}.txt", frames, "results")
        found.append(ours(truth, results, frames, DISTRACTORS))
        other.append(from_files(data / "mot", folder, name))
        assert_equal(found[-1], other[-1])
    total = reduce(add, found)
    assert_equal(total, combined(other))
    assert min(total.switches, total.fragmentations, total.false_positives) > 0
    assert 0.2 < total.hota.mean() < total.idf1 < total.mota + 0.4 < 1.4
