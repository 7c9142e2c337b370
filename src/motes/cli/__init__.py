"""The command line: one file per command, and the frame around all of them.

Nothing here takes time to import: from then on no interrupt shows a traceback.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from motes import interrupts
from motes.cli.streams import usable

DONE, FAULT, USAGE, UNREADABLE, NOT_FOUND, UNWRITABLE, PARTIAL = range(7)


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
    try:
        from motes.cli.app import app

        code: int | None = app(tokens)
        sys.stdout.flush()
        return code or DONE
    except BrokenPipeError:
        # The reader of a pipe has seen enough. Python's own flush on exit shall not complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except Exception as error:
        if os.environ.get("MOTES_DEBUG"):
            raise
        from motes.cli.explain import explain

        message, code = explain(error)
        print("motes: error:", " ".join(message.split()), file=sys.stderr)
        return code
