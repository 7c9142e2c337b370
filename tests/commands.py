"""Commands of motes, run in this process."""

import csv
from collections.abc import Callable
from pathlib import Path

import pytest

from motes.cli import main

Go = Callable[[str], tuple[int, str, str]]


def running(capfd: pytest.CaptureFixture[str], first: str = "", **names: object) -> Go:
    """Return what runs a command: exit code, standard output, standard error.

    Commands begin with `first`; in the rest of the line, names stand for their values.
    """

    def run(line: str) -> tuple[int, str, str]:
        for name, value in names.items():
            line = line.replace(name, str(value))
        capfd.readouterr()
        code = main([*first.split(), *line.split()])
        return code, *capfd.readouterr()

    return run


class Tell:
    """Runs commands: exit code, and all that each has said."""

    def __init__(self, capfd: pytest.CaptureFixture[str], **names: object) -> None:
        self._run = running(capfd, "", **names)

    def __call__(self, line: str) -> tuple[int, str]:
        """Run a command."""
        code, out, error = self._run(line)
        return code, out + error

    def says(self, line: str, code: int, text: str, *, told: bool = True, lines: int = 0) -> str:
        """Assert how a command ends, and whether it says a text; return all that it has said.

        That is so many `lines`, if any are given.
        """
        found, said = self(line)
        assert (found, text in said) == (code, told), said
        assert lines in (0, len(said.splitlines())), said
        return said


def read_csv(path: str | Path) -> list[dict[str, str]]:
    """Return the rows of a file of CSV."""
    with Path(path).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
