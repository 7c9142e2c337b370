"""The start of the command line, and its end: errors become lines, and exit codes.

The imports here are quick: `main` soon handles interrupts, and none shows a traceback.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from motes.cli.exit_codes import DONE, FAULT, NO_MEMORY, USAGE
from motes.cli.streams import drop_output, finish_output, usable
from motes.core import interrupts
from motes.core.errors import clear

if TYPE_CHECKING:
    from cyclopts import App

LEAST_ADDRESSES = 1_000_000 * 1024
"""Least bytes of address space; with fewer, libraries abort or hang while they are loaded."""
LEAST_FILES = 32
"""Least open files; with fewer, libraries end with tracebacks of their own."""


def main(tokens: Sequence[str] | None = None) -> int:
    """Run motes with its arguments, those of the process by default; return the exit code."""
    return run("motes", _commands, tokens)


def call(tokens: Sequence[str]) -> int:
    """Do a command of motes within a program; return the exit code, and raise what it raises."""
    code: int | None = _commands(tokens)(tokens)
    return code or DONE


def run(
    program: str, commands: Callable[[Sequence[str]], App], tokens: Sequence[str] | None
) -> int:
    """Run a program of these commands, which are imported late; return the exit code.

    No exception leaves it: each becomes one line on standard error. MOTES_DEBUG=1 adds tracebacks.
    """
    try:
        with interrupts.raised(), usable():
            return _run(program, commands, sys.argv[1:] if tokens is None else tokens)
    except KeyboardInterrupt as interrupt:
        return interrupts.code(interrupt)


def _commands(tokens: Sequence[str]) -> App:
    from motes.cli.app import commands

    return commands(tokens)


def _run(program: str, commands: Callable[[Sequence[str]], App], tokens: Sequence[str]) -> int:
    narrow = _too_narrow()
    if narrow is not None:
        print(f"motes: error: {narrow}", file=sys.stderr)
        return USAGE
    try:
        code: int | None = commands(tokens)(tokens)
        finish_output()
        return code or DONE
    except BrokenPipeError:  # the reader has closed the pipe
        drop_output()
        return DONE
    except SystemExit as end:
        if isinstance(end.__context__, BrokenPipeError):  # rich ends the program with 1 then
            return DONE
        raise
    except Exception as error:
        if os.environ.get("MOTES_DEBUG"):
            raise
        try:
            from motes.cli.explain import explain

            message, code = explain(error, program)
        except MemoryError:  # the message needs memory too
            message, code = NO_MEMORY, USAGE
        except ImportError:  # and packages, one of which is missing
            message, code = f"The installation is not whole: {error}; install motes again.", FAULT
        drop_output()
        print("motes: error:", clear(" ".join(message.split())), file=sys.stderr)
        return code


def _too_narrow() -> str | None:
    """Return which limit of the system motes cannot work in; None if there is none."""
    from motes.core import platforms

    addresses, files = platforms.limits()
    if addresses < LEAST_ADDRESSES:
        return (
            f"Memory is limited to {int(addresses) >> 10} KB of addresses, and motes needs "
            f"{LEAST_ADDRESSES >> 10}; raise the limit (ulimit -v)."
        )
    if files < LEAST_FILES:
        return (
            f"{files} open files are allowed, and motes needs {LEAST_FILES}; raise the limit "
            f"(ulimit -n)."
        )
    return None
