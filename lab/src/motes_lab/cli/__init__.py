"""The command line of the lab; its start, errors and exit codes are those of motes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from motes.cli import run

if TYPE_CHECKING:
    from cyclopts import App


def main(tokens: Sequence[str] | None = None) -> int:
    """Run motes-lab with its arguments, those of the process by default; return the exit code."""
    return run("motes-lab", _commands, tokens)


def _commands(_: Sequence[str]) -> App:
    from motes_lab.cli.app import app

    return app
