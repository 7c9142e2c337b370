"""The command line: one file per command, and the frame around all of them.

Nothing here takes time to import: from then on no interrupt shows a traceback.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from motes import interrupts
from motes.cli.streams import drop_output, finish_output, usable

DONE, FAULT, USAGE, UNREADABLE, NOT_FOUND, UNWRITABLE, PARTIAL = range(7)
NO_MEMORY = "There is not enough memory; use fewer particles or a smaller picture."


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
        finish_output()
        return code or DONE
    except BrokenPipeError:  # the reader of a pipe has seen enough
        drop_output()
        return DONE
    except Exception as error:
        if os.environ.get("MOTES_DEBUG"):
            raise
        try:
            from motes.cli.explain import explain

            message, code = explain(error)
        except MemoryError:  # not even for this
            message, code = NO_MEMORY, USAGE
        drop_output()
        print("motes: error:", " ".join(message.split()), file=sys.stderr)
        return code
