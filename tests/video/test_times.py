"""Times of pictures where stamps are wrong, and pictures that were lost."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from clips import clip, picture
from motes.core.errors import SourceError
from motes.video.report import Report
from motes.video.sources import open_source
from motes.video.times import AHEAD, timed

EVEN = [index / 25 for index in range(60)]
VARIABLE = np.cumsum(np.random.default_rng(0).uniform(0.01, 0.08, 60)).tolist()


def times(stamps: Sequence[float | None], ahead: int = AHEAD) -> tuple[list[float], int]:
    report = Report()
    pictures = ((stamp, lambda: picture(0)) for stamp in stamps)
    found = [moment for moment, _, _ in timed(pictures, 25, report, ahead=ahead)]
    assert report.decoded == len(stamps)
    assert (np.diff(found) > 0).all()
    return found, report.retimed


@pytest.mark.parametrize("stamps", [EVEN, VARIABLE], ids=["even", "variable"])
@pytest.mark.parametrize(
    "wrong",
    [
        {20: 10.0}, {20: -10.0}, {20: 10.0, 21: 10.0, 22: 10.0}, {0: 10.0}, {1: 10.0},
        {20: None}, {20: 10.0, 40: -0.5}, {57: 10.0}, {20: 1e9},
    ],
)  # fmt: skip
def test_wrong_stamps_are_replaced_and_no_other(
    stamps: list[float], wrong: dict[int, float | None]
) -> None:
    given: list[float | None] = [*stamps]
    for index, shift in wrong.items():
        given[index] = None if shift is None else stamps[index] + shift
    found, replaced = times(given)
    origin = stamps[1] - 1 / 25 if 0 in wrong else stamps[0]
    right = np.array([index not in wrong for index in range(60)])
    assert np.array(found)[right] == pytest.approx((np.array(stamps) - origin)[right])
    if stamps is EVEN:
        assert found == pytest.approx(EVEN)
    assert replaced <= len(wrong)  # one may fit by chance where steps vary
    assert replaced == len(wrong) or stamps is VARIABLE


def test_what_comes_live_is_not_waited_for() -> None:
    def coming() -> object:
        for stamp in EVEN:
            asked.append(stamp)
            yield stamp, lambda: picture(0)

    asked = list[float]()
    for count, _ in enumerate(timed(coming(), 25, Report()), start=1):  # type: ignore[arg-type]
        assert len(asked) == count


def test_an_error_comes_after_the_pictures_before_it() -> None:
    def broken() -> object:
        for stamp in EVEN[:5]:
            yield stamp, lambda: picture(0)
        raise SourceError("no more.")

    found = timed(broken(), 25, Report(), ahead=AHEAD)  # type: ignore[arg-type]
    assert len([*itertools.islice(found, 5)]) == 5
    with pytest.raises(SourceError):
        next(found)


def test_lost_pictures_count_as_lost(tmp_path: Path) -> None:
    path = clip(tmp_path / "whole.ts", 60)
    data = path.read_bytes()
    parts = [data[i : i + 188] for i in range(0, len(data), 188)]
    video = [number for number, part in enumerate(parts) if part[1] & 0x1F == 1 and part[2] == 0]
    gone = {*video[len(video) // 2 : len(video) // 2 + 9]}
    path.write_bytes(b"".join(part for number, part in enumerate(parts) if number not in gone))
    with open_source(path) as source:
        decoded = sum(1 for _ in source)
    assert decoded < 60
    assert source.report.lost == 60 - decoded
    assert f"{60 - decoded} picture(s) lost" in (source.report.problems or "")


def test_a_gap_of_an_undamaged_film_is_no_loss(tmp_path: Path) -> None:
    stamps = [40 * index for index in (0, 1, 2, 3, 9, 10, 11, 12)]
    with open_source(clip(tmp_path / "pause.mkv", len(stamps), times_ms=stamps)) as source:
        assert [frame.time for frame in source] == pytest.approx([each / 1000 for each in stamps])
    assert source.report.problems is None
