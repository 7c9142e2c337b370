"""Damaged files of every kind: read whole, read in part, or refused in one line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fuzzing.containers import check, damage, seed_files


def test_files_that_are_not_damaged_are_read_whole(tmp_path: Path) -> None:
    for path in seed_files(tmp_path):
        assert check(path) == ("part" if path.suffix == ".h264" else "whole"), path.name


def test_damage_is_the_same_for_the_same_seed() -> None:
    data = bytes(range(256)) * 10
    damaged = [damage(np.random.default_rng([0, seed]), data) for seed in range(50)]
    assert damaged == [damage(np.random.default_rng([0, seed]), data) for seed in range(50)]
    assert all(data != each for each in damaged[:5])
    for seed in range(50):
        assert isinstance(damage(np.random.default_rng(seed), b"x"), bytes)


@pytest.mark.slow
def test_damaged_files_cause_no_traceback_no_crash_and_no_hang() -> None:
    """In a process of its own, which a file that takes too long ends."""
    command = [sys.executable, "-m", "fuzzing.containers", "150"]
    done = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    outcomes = {line.split()[1] for line in done.stdout.splitlines()}
    assert outcomes == {"whole", "part", "stopped", "refused"}
