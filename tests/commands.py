"""Commands of motes, run in this process."""

import csv
from collections.abc import Callable
from pathlib import Path

import pytest

from motes.cli import main

Go = Callable[[str], tuple[int, str, str]]
Tell = Callable[[str], tuple[int, str]]


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


def telling(capfd: pytest.CaptureFixture[str], **names: object) -> Tell:
    """Return what runs a command: exit code, and all that it has said."""
    run = running(capfd, "", **names)

    def tell(line: str) -> tuple[int, str]:
        code, out, error = run(line)
        return code, out + error

    return tell


def read_csv(path: str | Path) -> list[dict[str, str]]:
    """Return the rows of a file of CSV."""
    with Path(path).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
