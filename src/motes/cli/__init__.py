"""The command line: its start, its errors and its exit codes; each command has its own file.

The imports here are quick: `main` soon handles interrupts, and none shows a traceback.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from motes.cli.exit_codes import DONE, NO_MEMORY, USAGE
from motes.cli.streams import drop_output, finish_output, usable
from motes.core import interrupts
from motes.core.errors import clear

LEAST_ADDRESSES = 1_000_000 * 1024
"""Least bytes of address space; with fewer, libraries abort or hang while they are loaded."""


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the program with its arguments, those of the process by default; return the exit code.

    No exception leaves it: each becomes one line on standard error. MOTES_DEBUG=1 adds tracebacks.
    """
    try:
        with interrupts.raised(), usable():
            return _run(sys.argv[1:] if tokens is None else tokens)
    except KeyboardInterrupt as interrupt:
        return interrupts.code(interrupt)


def _run(tokens: Sequence[str]) -> int:
    limit = _address_limit()
    if limit is not None and limit < LEAST_ADDRESSES:
        print(
            f"motes: error: Memory is limited to {limit >> 10} KB of addresses, and motes needs "
            f"{LEAST_ADDRESSES >> 10}; raise the limit (ulimit -v).",
            file=sys.stderr,
        )
        return USAGE
    try:
        from motes.cli.app import app

        code: int | None = app(tokens)
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

            message, code = explain(error)
        except MemoryError:  # the message needs memory too
            message, code = NO_MEMORY, USAGE
        drop_output()
        print("motes: error:", clear(" ".join(message.split())), file=sys.stderr)
        return code


def _address_limit() -> int | None:
    """Return the limit of the address space in bytes; None without a limit."""
    try:
        import resource
    except ImportError:  # on Windows
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if limit == resource.RLIM_INFINITY else limit
