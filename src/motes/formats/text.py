"""Text, JSON and numbers from files, and where in a file an error is."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec

from motes.core.errors import FormatError
from motes.core.files import read_text
from motes.core.geometry import FARTHEST

_SPACED = re.compile(r"[^\s,;]\s+[^\s,;]")
"""Two fields with nothing but space between them."""


def read_json(path: Path, kind: Any) -> Any:
    """Return the content of a JSON file as a type of msgspec; raise a FormatError otherwise."""
    try:
        return msgspec.json.decode(read_text(path, FormatError), type=kind)
    except (msgspec.MsgspecError, RecursionError) as error:
        raise FormatError(f"{path.name}: {error}") from None


def unread(attributes: Iterable[str]) -> list[str]:
    """Return in words which attributes of objects are left out, as users define them."""
    names = sorted(attributes)
    return [f"the attributes {', '.join(names)[:80]}"] if names else []


@contextmanager
def at(where: str) -> Iterator[None]:
    """Turn errors into FormatErrors that name their place in a file: a line, an annotation."""
    try:
        yield
    except KeyError as error:
        raise FormatError(f"{where}: it has no {error.args[0]}") from None
    except (ValueError, TypeError, OverflowError, FormatError) as error:
        raise FormatError(f"{where}: {error}") from None


def fields_of(line: str) -> list[str]:
    """Return the fields of a line: between commas, or semicolons, or tabs and spaces.

    Raises a ValueError if a line has two of these: one may be a decimal sign.
    """
    marks = [mark for mark in ",;" if mark in line]
    if len(marks) > 1 or (marks and _SPACED.search(line)):
        raise ValueError(
            f"its numbers are separated in two ways, {line[:40]!r}, as with decimal commas; write "
            f"decimal points"
        )
    return [field.strip() for field in line.split(marks[0])] if marks else line.split()


def number(field: str) -> float:
    """Return the number that a text holds; raise a ValueError if it is none, or of no picture."""
    value = any_number(field)
    if not math.isfinite(value):
        raise ValueError(f"{field[:20]} is not finite")
    return value


def any_number(field: str) -> float:
    """Return the number that a text holds, as `number` does, also one that is not finite."""
    try:
        value = float(field.replace("_", "?"))  # Python alone reads 1_0 as 10
    except ValueError:
        raise ValueError(f"{field[:20]!r} is not a number") from None
    if FARTHEST < abs(value) < math.inf:
        raise ValueError(f"{field[:20]} is too large a number")
    return value


def angle(degrees: float) -> float:
    """Return an angle in radians; raise a ValueError for more than a turn, which is no angle."""
    if not abs(degrees) <= 360:
        raise ValueError(f"its rotation is {degrees:g}; it is an angle in degrees, up to 360")
    return math.radians(degrees)


def whole(field: str) -> int:
    """Return the whole number that a text holds, as `number` does."""
    value = number(field)
    if not value.is_integer():
        raise ValueError(f"{field[:20]!r} is not a whole number")
    return int(value)
