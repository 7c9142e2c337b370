"""The container file: the rules that its steps keep. Its own last step tries the command."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent


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


def test_the_build_has_what_the_wheels_are_made_of() -> None:
    """And nothing that was compiled elsewhere: kernels are compiled in the image."""
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    rules = [line for line in lines if line and not line.startswith("#")]
    kept = {line.removeprefix("!") for line in rules if line.startswith("!")}
    left_out = {line for line in rules if line.startswith("**/")}
    assert rules[0] == "*"
    assert len(kept) + len(left_out) + 1 == len(rules)
    assert "**/*.so" in left_out
    assert all((ROOT / name).exists() for name in kept)
    (wheels,) = (step.text for step in stages()[0] if " pip wheel " in step.text)
    folders = {Path(word).name for word in wheels.split("--wheel-dir /wheels ")[1].split()}
    assert folders == {"", "studio", "fleet", "lab"}
    assert kept == {"LICENSE", "README.md", "pyproject.toml", "setup.py", "src", *folders} - {""}


def test_the_image_installs_these_wheels_and_tries_the_command() -> None:
    build, final = stages()
    assert ("COPY", ". .") in build
    install, user, doctor = (step.text for step in final if step.instruction == "RUN")
    assert "from=build,source=/wheels,target=/wheels" in install
    assert install.split("pip install")[1].split() == [
        "--no-cache-dir", "--find-links", "/wheels", "/wheels/motes-*.whl", "$PACKAGES",
    ]  # fmt: skip
    assert user.split()[-1] == last("USER")
    assert doctor == "motes doctor"
