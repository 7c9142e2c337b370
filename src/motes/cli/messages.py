"""Messages to the user, on standard error."""

from __future__ import annotations

import sys

from motes.core.errors import clear


def log(message: str) -> None:
    """Print a line on standard error."""
    print(f"motes: {clear(message)}", file=sys.stderr)
