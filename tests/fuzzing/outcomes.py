"""What may come of an input: it is read, or refused in one clear line."""

import atexit
import math
import shutil
import tempfile
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

from motes.core.errors import MotesError

READ, REFUSED = "read", "refused"
LONGEST = 1500
"""Characters of an error; more is no clear line, but a part of the input."""


class DefectError(Exception):
    """What must not come of an input."""


def outcome(read: Callable[[], object]) -> str:
    """Return what comes of reading; raise a DefectError if it is refused without a clear line."""
    try:
        read()
    except MotesError as error:
        check_message(str(error))
        return REFUSED
    return READ


def check_message(text: str) -> None:
    """Raise a DefectError if a text is no clear line for people."""
    line = " ".join(text.split())
    if not line or len(line) > LONGEST:
        raise DefectError(f"The error has {len(line)} characters: {line[:200]}")
    if not line.isprintable():
        raise DefectError(f"The error has characters that cannot be shown: {line[:200]!r}")


def check_finite(values: Iterable[float | None]) -> None:
    """Raise a DefectError if one of these numbers is NaN or infinite; None is none."""
    for value in values:
        if value is not None and not math.isfinite(value):
            raise DefectError(f"A result is {value}.")


@cache
def scratch() -> Path:
    """Return a folder of this process for the files of inputs; it is removed when that ends."""
    folder = tempfile.mkdtemp(prefix="inputs-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def put(name: str, data: bytes) -> Path:
    """Return a file with this name that holds an input."""
    path = scratch() / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)  # what replaces a file's content waits for the disk
    path.write_bytes(data)
    return path
