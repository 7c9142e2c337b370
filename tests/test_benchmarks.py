"""The scripts in benchmarks/ run to their end, on little."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from motes.evaluation.synthetic.clips import still
from motes.video.writer import VideoWriter

SCRIPTS = Path(__file__).parents[1] / "benchmarks"
VALGRIND = f"""#!{sys.executable}
import itertools, subprocess, sys
command = [*itertools.dropwhile(lambda each: each.startswith("--"), sys.argv[1:])]
frames = int(command[-1])
code = subprocess.run(command).returncode
print(f"==1== Collected : {{1000000 * frames}}", file=sys.stderr)
sys.exit(code)
"""
"""A stand-in that counts a million instructions for a frame."""


def run(*command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a script with the Python of these tests."""
    line = [sys.executable, str(SCRIPTS / command[0]), *command[1:]]
    return subprocess.run(line, env=os.environ | environment, capture_output=True, text=True)


def cells(table: str) -> list[list[str]]:
    """Return the lines of a table below its head."""
    lines = [line for line in table.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


@pytest.mark.slow
def test_a_frame_from_file_to_file(tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    clip = still((160, 120), (30, 50), 12)
    with VideoWriter(film, 25) as writer:
        for frame, _ in clip:
            writer.write(frame.pixels)
    box = ",".join(f"{value:.0f}" for value in clip[0][1][0].ellipse.box)
    small = ["--frames", "12", "--rounds", "1", "--size", "320x240", "--preset", "nummiaro"]
    done = run("end_to_end.py", str(film), box, *small)
    assert done.returncode == 0, done.stderr
    ((size, preset, *numbers),) = cells(done.stdout)
    assert (size, preset, len(numbers)) == ("320x240", "nummiaro", 8)

    done = run("end_to_end.py", str(film), "500,500,9,9", *small)
    assert done.returncode == 1
    assert "motes track" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="the stand-in is a script")
def test_instructions_are_counted(tmp_path: Path) -> None:
    counter = tmp_path / "valgrind"
    counter.write_text(VALGRIND)
    counter.chmod(0o755)
    done = run("instructions.py", "12", PATH=f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    assert done.returncode == 0, done.stderr
    rows = cells(done.stdout)
    assert [row[0].split()[-1] for row in rows] == ["nummiaro", "ng_delp", "maggio", "nummiaro"]
    assert {row[1] for row in rows} == {"1.00"}
    assert rows[0][2] == "1050 to 2100"  # of 1,500 million cycles

    done = run("instructions.py", PATH=str(tmp_path / "empty"))
    assert "valgrind is not installed" in done.stderr
