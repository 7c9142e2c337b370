"""What a pass is worth, results.csv, and means over sequences and seeds."""

import math
from pathlib import Path

import numpy as np
import pytest

from commands import read_csv
from evaluations import Floats, outcome, sequence, shifted, trace
from motes import Ellipse, FormatError
from motes.core import iou
from motes_lab.aggregate import Evaluation
from motes_lab.protocols.trace import save_trace
from motes_lab.report.sections import comparisons
from motes_lab.scores import COLUMNS, Outcome, score, write_results


def test_score_frame_by_frame() -> None:
    """A second implementation, a frame at a time."""
    rng = np.random.default_rng(0)
    there = sequence(frames=60, absent=[5, 6, 30])
    boxes = shifted(rng.normal(0, 12, 60).tolist()) + rng.uniform(-3, 3, (60, 4))
    confidence, lost = rng.uniform(0, 1, 60), rng.uniform(size=60) < 0.3
    found = score(trace(boxes, confidence.tolist(), lost.tolist()), there)
    overlaps, distances, hits, said, missed = [], [], 0, 0, 0
    for i in range(60):
        gone = bool(np.isnan(there.boxes[i, 0]))
        overlap = 0.0 if gone else float(iou(boxes[i], there.boxes[i]))
        if not gone:
            overlaps.append(overlap)
            ours, true = Ellipse.from_box(boxes[i]), Ellipse.from_box(there.boxes[i])
            distances.append(math.dist(ours[:2], true[:2]))
        wrong = overlap < 0.1
        hits, said, missed = hits + (lost[i] and wrong), said + lost[i], missed + wrong
    assert found["iou"] == pytest.approx(sum(overlaps) / 57)
    assert found["auc"] == pytest.approx(
        sum(overlap > k / 20 for overlap in overlaps for k in range(21)) / 21 / 57
    )
    assert found["precision_20"] == pytest.approx(sum(d <= 20 for d in distances) / 57)
    assert found["lost_recall"] == pytest.approx(hits / missed)
    assert found["lost_precision"] == pytest.approx(hits / said)


# results.csv


def test_results(tmp_path: Path) -> None:
    book = sequence()
    said = trace(shifted([0.0] * 13 + [90.0] * 7), 0.75)
    write_results(tmp_path, [outcome("a,b", book, said), outcome("c", book, "It broke,\nso.")])
    first, second = read_csv(tmp_path / "results.csv")
    assert tuple(first) == COLUMNS
    assert first["tracker"] == "a,b"
    assert (first["sequence"], first["protocol"], first["start"]) == ("Book", "ope", "")
    assert (first["seed"], first["frames"], first["lost_frame"]) == ("0", "20", "13")
    assert (first["auc"], first["ece"], first["fps"]) == ("0.619048", "0.1", "500")
    assert first["error"] == ""
    assert second["error"] == "It broke, so."
    assert {second[name] for name in COLUMNS[5:-1]} == {""}
    assert [path.name for path in tmp_path.iterdir()] == ["results.csv"]


def test_order_of_results(tmp_path: Path) -> None:
    """Trackers and sequences as they came first; the rest does not depend on who was ready when."""
    book, ant = sequence("Book"), sequence("Ant")
    said = trace(shifted([0.0] * 20))
    given = [
        outcome("z", book, said),
        outcome("z", ant, said),
        *(outcome("z", book, said, 0, "pixel", f"{k:+d}", k) for k in (1, -1)),
        outcome("z", book, said, 1, "pixel", "-1", -1),
        outcome("a", ant, said, 1),
        outcome("a", ant, said, 0),
        outcome("a", book, said),
    ]
    write_results(tmp_path, given)
    text = (tmp_path / "results.csv").read_bytes()
    rows = read_csv(tmp_path / "results.csv")
    assert [tuple(row[name] for name in COLUMNS[:5]) for row in rows] == [
        ("z", "Book", "ope", "", "0"),
        ("z", "Book", "pixel", "-1", "0"),
        ("z", "Book", "pixel", "-1", "1"),
        ("z", "Book", "pixel", "+1", "0"),
        ("z", "Ant", "ope", "", "0"),
        ("a", "Book", "ope", "", "0"),
        ("a", "Ant", "ope", "", "0"),
        ("a", "Ant", "ope", "", "1"),
    ]
    write_results(tmp_path, [*given[:2], *reversed(given[2:])])
    assert (tmp_path / "results.csv").read_bytes() == text


def fits(good: int, of: int = 20) -> Floats:
    """Return boxes of which so many fit, so that the AUC is their share times 20/21."""
    return shifted([0.0] * good + [90.0] * (of - good))


UNIT = 20 / 21


def two_trackers() -> list[Outcome]:
    book, ant, cow = sequence("Book"), sequence("Ant"), sequence("Cow")
    return [
        *(outcome("a", book, trace(fits(k)), seed) for seed, k in enumerate((10, 20))),
        *(outcome("a", ant, trace(fits(k)), seed) for seed, k in enumerate((10, 10))),
        *(outcome("a", cow, trace(fits(k)), seed) for seed, k in enumerate((4, 6))),
        outcome("b", book, trace(fits(18))),
        outcome("b", ant, trace(fits(10))),
        outcome("b", cow, "broken"),
    ]


def test_mean_over_sequences_then_seeds() -> None:
    found = Evaluation(two_trackers())
    assert (found.trackers, found.sequences) == (["a", "b"], ["Book", "Ant", "Cow"])
    assert found.protocols == ["ope"]
    first, second = UNIT * (0.5 + 0.5 + 0.2) / 3, UNIT * (1 + 0.5 + 0.3) / 3
    assert found.per_seed("a", "ope", "auc") == pytest.approx(np.array([first, second]))
    mean, deviation = found.mean("a", "ope", "auc")
    assert mean == pytest.approx((first + second) / 2)
    assert deviation == pytest.approx((second - first) / math.sqrt(2))
    assert found.mean("a", "ope", "auc", ["Ant"]) == pytest.approx((UNIT / 2, 0))


def test_a_sequence_with_one_failed_seed_is_not_finished() -> None:
    book = sequence("Book")
    found = Evaluation([outcome("a", book, trace(fits(9))), outcome("a", book, "broken", 1)])
    assert found.finished("a", "ope") == []
    assert math.isnan(found.mean("a", "ope", "auc").mean)
    assert found.seconds("a", "ope").size == 0


def test_mean_over_starts() -> None:
    """A sequence counts once, however many starts it has."""
    book, ant = sequence("Book"), sequence("Ant")
    found = Evaluation(
        [
            outcome("a", book, trace(fits(20)), 0, "pixel", "0"),
            outcome("a", book, trace(fits(5, 10), start=10), 0, "pixel", "+1", 10),
            outcome("a", ant, trace(fits(5)), 0, "pixel", "0"),
        ]
    )
    assert found.mean("a", "pixel", "auc").mean == pytest.approx(UNIT * (0.75 + 0.25) / 2)


def test_comparisons_are_over_common_sequences() -> None:
    (row,) = comparisons(Evaluation(two_trackers()), "ope").rows
    tracker, mean, interval, won, drawn = row
    assert (tracker.text, won.text, drawn.text) == ("b", "1 of 2", "1")
    assert mean.value == pytest.approx(UNIT * ((0.9 - 0.75) + 0) / 2)
    assert interval.text == f"+0.000 to {UNIT * 0.15:+.3f}"


def test_lost_status_is_over_all_frames() -> None:
    book, ant = sequence("Book"), sequence("Ant", 10)
    right = [True] * 4 + [False] * 6
    found = Evaluation(
        [
            outcome("a", book, trace(fits(20))),
            outcome("a", ant, trace(shifted([90.0] * 5 + [0.0] * 5), lost=right)),
        ]
    )
    shares = {
        ("missed", "judged"): 5 / 30,
        ("reported", "judged"): 4 / 30,
        ("both", "missed"): 0.8,
        ("both", "reported"): 1,
    }
    for of, expected in shares.items():
        assert found.share("a", "ope", *of).mean == pytest.approx(expected)
    assert found.lost_f1("a", "ope").mean == pytest.approx(8 / 9)


def test_recovery_and_coverage_are_over_all_passes_of_a_seed() -> None:
    long, short = sequence("Long", 90), sequence("Short", 32)
    often = trace(shifted([0.0, *[90.0] * 20, 0, *[90.0] * 20, 0, *[90.0] * 47]))
    never = trace(shifted([0.0, *[1.0] * 31]), covariance=(1.0, 0.0, 1.0))
    apart = trace(shifted([0.0, *[9.0] * 9]), covariance=(1.0, 0.0, 1.0))
    found = Evaluation(
        [
            outcome("a", long, often),
            outcome("a", short, never),
            outcome("a", sequence("Third", 10), apart),
            outcome("b", short, trace(shifted([0.0, *[90.0] * 31]))),
            outcome("b", short, trace(shifted([0.0, *[90.0] * 30, 0.0])), 1),
            outcome("c", short, trace(shifted([0.0] * 32))),
        ]
    )
    (a,), b, (c,) = (found.sums(name, "ope").to_dict("records") for name in "abc")
    assert (a["losses"], a["known"]) == (3, 31 + 9)
    assert found.share("a", "ope", "recovered", "losses").mean == pytest.approx(2 / 3)
    assert found.share("a", "ope", "covered", "known").mean == pytest.approx(31 / 40)
    share = found.share("b", "ope", "recovered", "losses")
    assert len(b) == 2
    assert share == pytest.approx((0.5, math.sqrt(0.5)))
    assert (c["losses"], c["known"]) == (0, 0)
    assert math.isnan(found.share("c", "ope", "recovered", "losses").mean)


@pytest.mark.parametrize("frames", [19, 21])
def test_a_track_of_another_length_is_refused(tmp_path: Path, frames: int) -> None:
    """A file may have been cut at the end of a line."""
    save_trace(tmp_path / "a.csv", trace(shifted([0.0] * frames)))
    with pytest.raises(FormatError, match=rf"a\.csv is for {frames} frames, .* has 20\."):
        Outcome.load(tmp_path / "a.csv", sequence(frames=20))
