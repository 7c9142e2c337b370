"""The container file: its steps, run as a script where no builder is.

Left out is what needs root or a network: Debian's packages, the user, and what pip downloads.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

import motes
from motes.synthetic.clips import still
from motes.video.writer import VideoWriter

ROOT = Path(__file__).parent.parent
FOLDERS = re.compile(r"(?<![\w.])/(source|wheels|data)\b")
"""Folders that the container file makes in the root of the image."""

COMPILER = f"""#!{sys.executable}
import shutil, sys
from pathlib import Path

words = sys.argv[1:]
target = Path(words[words.index("-o") + 1])
if "-c" in words:
    assert Path(words[words.index("-c") + 1]).is_file()
    target.touch()
else:
    shutil.copy(Path({str(Path(motes.__file__).parent / "kernels")!r}) / target.name, target)
"""
"""A stand-in that knows what it compiles: the kernels that this motes has. To compile them once
more would take most of the time; they were compiled with the same setup.py."""


class Step(NamedTuple):
    """An instruction of the container file, and all that follows it."""

    instruction: str
    text: str


def steps() -> list[Step]:
    """Return the instructions, with continued lines joined."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    lines = re.sub(r"^#.*\n", "", text, flags=re.MULTILINE).replace("\\\n", " ").splitlines()
    return [Step(*line.split(maxsplit=1)) for line in lines if line.strip()]


def stages() -> list[list[Step]]:
    """Return the instructions of each stage, which begins with FROM; those before are left out."""
    found: list[list[Step]] = []
    for step in steps():
        if step.instruction == "FROM":
            found.append([])
        if found:
            found[-1].append(step)
    return found


def last(instruction: str) -> str:
    """Return what follows the last instruction of a kind."""
    return [step.text for step in steps() if step.instruction == instruction][-1]


def copied(folder: Path) -> None:
    """Copy what .dockerignore leaves, into a folder."""
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    rules = [line for line in lines if line and not line.startswith("#")]
    assert rules[0] == "*"
    left_out = [line.removeprefix("**/") for line in rules if line.startswith("**/")]
    kept = [line.removeprefix("!") for line in rules if line.startswith("!")]
    assert len(kept) + len(left_out) + 1 == len(rules)
    folder.mkdir(parents=True)
    for name in kept:
        path = ROOT / name
        if path.is_dir():
            shutil.copytree(path, folder / name, ignore=shutil.ignore_patterns(*left_out))
        else:
            shutil.copy(path, folder)


def test_it_is_slim_and_not_root() -> None:
    build, final = stages()
    assert build[0].text == "python:${PYTHON}-slim AS build"
    assert final[0].text == "python:${PYTHON}-slim"
    assert not any("apt-get" in step.text for step in final)
    assert all(step.instruction != "COPY" for step in final)  # no sources, and no layer of wheels
    instructions = [step.instruction for step in final]
    assert last("USER") not in ("root", "0")
    assert instructions.index("USER") < instructions.index("ENTRYPOINT")
    assert json.loads(last("ENTRYPOINT")) == ["motes"]
    assert json.loads(last("CMD")) == ["--help"]


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="a container is Linux")
def test_its_steps_lead_to_a_command(tmp_path: Path) -> None:
    pytest.importorskip("setuptools")
    installed = tmp_path / "installed"
    compiler = tmp_path / "c++"
    compiler.write_text(COMPILER)
    compiler.chmod(0o755)
    environment = os.environ | {
        "CC": str(compiler),
        "CXX": str(compiler),
        "PACKAGES": "",
        "PATH": os.pathsep.join(
            [str(installed / "bin"), str(Path(sys.executable).parent), os.environ["PATH"]]
        ),
        "PYTHONPATH": str(installed),
        "PIP_NO_BUILD_ISOLATION": "0",  # pip reads this as: take the setuptools that is here
        "PIP_NO_INDEX": "1",
        "PIP_NO_DEPS": "1",
        "PIP_TARGET": str(installed),
    }

    def shell(command: str, folder: Path) -> str:
        done = subprocess.run(
            ["sh", "-ec", command], cwd=folder, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, (command, done.stdout, done.stderr)
        return done.stdout

    folder, ran = tmp_path, []
    for stage in stages():
        for instruction, text in stage:
            here = FOLDERS.sub(rf"{tmp_path}/\1", text)
            if instruction == "WORKDIR":
                folder = Path(here)
                folder.mkdir(exist_ok=True)
            elif (instruction, text) == ("COPY", ". ."):
                folder.rmdir()
                copied(folder)
                assert not [*folder.rglob("*.so")]  # kernels are compiled in the image
            elif instruction == "RUN":
                command = re.sub(r"--mount=\S+\s+", "", here)
                if not command.startswith(("apt-get", "useradd")):
                    ran.append(command)
                    out = shell(command, folder)
    assert [command.split()[0] for command in ran] == ["python", "python", "motes"]
    assert f"in {installed}" in out
    assert [*installed.glob("motes/kernels/_baseline*.so")]

    clip = still((320, 240), (30, 50), 5)
    with VideoWriter(tmp_path / "data" / "film.mp4", 25) as writer:
        for frame, _ in clip:
            writer.write(frame.pixels)
    box = ",".join(f"{value:.0f}" for value in clip[0][1][0].ellipse.box)
    entry = " ".join(json.loads(last("ENTRYPOINT")))
    shell(f"{entry} track film.mp4 --init {box} -o track.csv", folder)
    assert len((tmp_path / "data" / "track.csv").read_text().splitlines()) == 6
    assert "motes COMMAND" in shell(f"{entry} {' '.join(json.loads(last('CMD')))}", folder)


def test_what_is_published_is_made_by_actions_that_cannot_change() -> None:
    text = (ROOT / ".github/workflows/release.yml").read_text()
    actions = re.findall(r"uses: (\S+)", text)
    assert actions
    assert all(re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", each) for each in actions)
