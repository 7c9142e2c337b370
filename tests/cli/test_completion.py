"""Completion in bash: names of files and presets where they are asked for."""

import subprocess
from pathlib import Path

import pytest

from motes.cli.app import commands

FUNCTION = """
complete_line() {
    COMP_WORDS=("$@")
    COMP_CWORD=$(($# - 1))
    COMPREPLY=()
    _motes
    echo "${COMPREPLY[@]}"
}
"""


@pytest.mark.slow
def test_files_and_presets_are_completed(tmp_path: Path) -> None:
    (tmp_path / "film.mp4").touch()
    lines = [
        "track f", "watch f", "draw f", "check f", "refine f", "check film.mp4 f", "batch f",
        "track film.mp4 -o f", "watch --detector f", "watch --events f", "smooth a.csv -o f",
        "track film.mp4 --preset nummiaro:a", "watch --preset nummiaro:a", "config nummiaro:a",
    ]  # fmt: skip
    calls = "\n".join(f"complete_line motes {line}" for line in lines)
    script = commands([]).generate_completion(shell="bash") + FUNCTION + calls
    done = subprocess.run(["bash", "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert done.stderr == ""
    said = done.stdout.splitlines()
    assert said == ["film.mp4"] * 11 + ["nummiaro:adaptive"] * 3, [*zip(lines, said, strict=True)]
