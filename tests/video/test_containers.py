"""Damaged files of every kind: read whole, read in part, or refused in one line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.slow
def test_damaged_files_cause_no_traceback_no_crash_and_no_hang() -> None:
    """In a process of its own, which a file that takes too long ends."""
    command = [sys.executable, "-m", "fuzzing.containers", "150"]
    done = subprocess.run(command, cwd=Path(__file__).parents[1], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    outcomes = {line.split()[1] for line in done.stdout.splitlines()}
    assert outcomes == {"whole", "part", "stopped", "refused"}
