"""Messages to the user, on standard error."""

from __future__ import annotations

import sys

from motes.core.errors import clear


def log(message: str) -> None:
    """Print a line on standard error."""
    print(f"motes: {clear(message)}", file=sys.stderr)


def counted(number: int, noun: str) -> str:
    """Return `1 frame` or `2 frames`."""
    return f"{number} {noun}{'s' * (number != 1)}"
