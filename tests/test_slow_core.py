"""The measurement on a part of a core: its variants, its limits, its table."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from motes.cues.sampling import Checkerboard, EveryPixel
from motes.sot.presets import NG_DELP
from motes.synthetic.clips import still
from motes.video.writer import VideoWriter
from scripts import script


@pytest.fixture(name="slow_core", scope="module")
def _slow_core() -> ModuleType:
    return script("benchmarks/slow_core.py")


def test_the_variants_are_the_papers(slow_core: Any) -> None:
    both = slow_core.config_of("half", "color and edges")
    assert both.color.sampling == both.edges.sampling == Checkerboard(share="half")
    assert list(slow_core.config_of("all", "color").cues) == ["color"]
    assert slow_core.config_of("all", "edges").edges.sampling == EveryPixel()
    shipped = slow_core.config_of("lattice, as shipped", "color and edges")
    assert (shipped.color, shipped.edges) == (NG_DELP.color, NG_DELP.edges)


def test_frames_after_the_start_are_counted(
    slow_core: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slow_core, "STARTING_FRAMES", 2)
    monkeypatch.setattr(slow_core, "FRAMES", 6)
    now = iter([10.0, 12.0])
    monkeypatch.setattr(slow_core.time, "perf_counter", lambda: next(now))
    used = iter([1.0, 1.5])
    monkeypatch.setattr(slow_core.time, "process_time", lambda: next(used))
    clip = still((160, 120), (20, 30), 6)
    with VideoWriter(tmp_path / "film.mp4", 25) as writer:
        for frame, _ in clip:
            writer.write(frame.pixels)
    target = tuple(clip[0][1][0].ellipse)
    run = slow_core.follow(str(tmp_path / "film.mp4"), target, "quarter", "color")
    assert (run.frames_per_second, run.seconds) == (2.0, 0.125)
    assert run.memory > 10_000


@pytest.mark.parametrize("version", [1, 2])
def test_the_limits(slow_core: Any, version: int, tmp_path: Path) -> None:
    if version == 2:
        (tmp_path / "cgroup.controllers").touch()
    for folder in ("cpu", "memory"):
        (tmp_path / folder).mkdir()
    with slow_core.limited(0.1, 128, tmp_path) as groups:
        limits = {file.name: file.read_text() for group in groups for file in group.iterdir()}
    if version == 2:
        assert limits["cpu.max"] == "1000 10000"
        assert limits["memory.max"] == "134217728"
        assert limits["memory.swap.max"] == "0"
    else:
        assert (limits["cpu.cfs_quota_us"], limits["cpu.cfs_period_us"]) == ("1000", "10000")
        assert limits["memory.limit_in_bytes"] == "134217728"


def test_without_the_right_to_limit_there_is_one_clear_line(slow_core: Any, tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="run this as root"), slow_core.limited(0.1, 1, tmp_path):
        pass


def test_the_table_has_medians_and_names_what_needs_more_memory(slow_core: Any) -> None:
    runs = [slow_core.Run(rate, 0.01 * rate, 2048) for rate in (2.0, 1.0, 4.0)]
    whole, failed = slow_core.rows_of({("all", "color"): runs, ("half", "edges"): [runs[0], None]})
    assert [cell.text for cell in whole] == ["color", "all", "2.0 (1.0 to 4.0)", "20.00", "2"]
    assert failed[2].text == "not enough memory"
