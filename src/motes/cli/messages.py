"""Messages to the user, on standard error."""

from __future__ import annotations

import os
import sys

from motes.core.errors import clear


def log(message: str) -> None:
    """Print a line on standard error."""
    print(f"motes: {clear(message)}", file=sys.stderr)


def counted(number: int, noun: str) -> str:
    """Return `1 frame` or `2 frames`."""
    return f"{number} {noun}{'s' * (number != 1)}"


def announce_compiling() -> None:
    """Print why the start is slow, if kernels have to be compiled."""
    from motes.kernels import compiling

    folder = compiling.FOLDER
    writable = folder is not None and os.access(folder, os.W_OK)
    kept = "once for this machine; later starts are quick."
    lost = "there is no folder to keep them in (see motes doctor)."
    why = kept if writable else lost
    compiling.when_compiling(lambda: log(f"Compiling kernels, {why}"))
    if writable:
        advice = "make room there, or every start compiles."
        compiling.when_unkept(
            lambda error: log(f"{folder} cannot keep them: {error.strerror}; {advice}")
        )
