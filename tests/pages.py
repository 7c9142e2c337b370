"""Runs a page of the documentation: its commands, its code, and what it says they print."""

import re
import shlex
import textwrap
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from motes.cli import main
from motes_lab.cli import main as lab

PROGRAMS = {"motes": main, "motes-lab": lab}
NUMBER = re.compile(r"\d*\.\d+|\d{2,}")
"""Measured numbers, whose last digits depend on the processor; counts below ten must agree."""
OTHERS = ("make", "pip", "cd", "python", "docker")
"""Programs in blocks of commands that are not run here."""
SHORTER = {
    "motes demo --out demo": "motes demo --out demo --frames 12",
    "--at 150=": "--at 10=",
    "--places places.toml -o": "--places places.toml --end 70 -o",
}
"""What would take long is run on fewer frames."""


class Block(NamedTuple):
    """A fenced block: its language, the file that it is (title), its text and its first line."""

    language: str
    title: str | None
    text: str
    line: int


def blocks(page: Path) -> list[Block]:
    """Return a page's fenced blocks, in order, those in lists too."""
    source = page.read_text(encoding="utf-8")
    found = []
    for fence in re.finditer(
        r'^( *)```(\w+)(?: title="(.+?)")?\n(.*?)^\1```$', source, re.DOTALL | re.MULTILINE
    ):
        line = source.count("\n", 0, fence.start(4))
        found.append(Block(fence[2], fence[3], textwrap.dedent(fence[4]), line))
    return found


def commands(block: Block) -> list[str]:
    """Return the commands of motes and of its lab in a block for the shell, without comments."""
    text = block.text.replace("\\\n", "")
    lines = [line.split("#")[0].strip() for line in text.splitlines()]
    strange = [line for line in lines if line and line.split()[0] not in (*PROGRAMS, *OTHERS)]
    assert not strange, f"neither run nor known: {strange}"
    return [line for line in lines if line.startswith(("motes ", "motes-lab "))]


def run(command: str) -> int:
    """Run a command of motes or of its lab; return the exit code."""
    for usual, shorter in SHORTER.items():
        command = command.replace(usual, shorter)
    program, *words = shlex.split(command)
    return PROGRAMS[program](words)


def run_page(page: Path, capfd: pytest.CaptureFixture[str]) -> int:
    """Run all blocks of a page in the current folder; return how many pieces of code ran.

    A block with a title is written into that file. Commands of motes must end with exit code 0.
    All Python shares one namespace. Every line of a text block must be in what was printed since
    the last such block, but for its measured numbers. What Python printed just above it must be
    there as a whole, with numbers near to its own.
    """
    names: dict[str, Any] = {}
    output, own, ran = "", "", 0
    for block in blocks(page):
        where = f"{page.name}:{block.line}"
        if block.title:
            Path(block.title).write_text(block.text, encoding="utf-8")
        elif block.language == "sh":
            for command in commands(block):
                code = run(command)
                output += "".join(capfd.readouterr())
                assert code == 0, (where, command, output)
                own = ""
                ran += 1
        elif block.language == "python":
            exec(compile("\n" * block.line + block.text, str(page), "exec"), names)
            ran += 1
            own, error = capfd.readouterr()
            output += own + error
        elif block.language == "text":
            there = NUMBER.sub("#", output).splitlines()
            for line in block.text.splitlines():
                assert NUMBER.sub("#", line) in there, (where, line, output)
            if own:
                said, printed = (NUMBER.sub("#", text) for text in (block.text, own))
                assert said == printed, where
                for one, other in zip(*map(NUMBER.findall, (block.text, own)), strict=True):
                    near = 0.1 if "." in one else 3
                    assert float(one) == pytest.approx(float(other), rel=0.1, abs=near), where
            output = own = ""
    return ran
