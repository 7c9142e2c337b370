"""Texts of users in files: names of classes, which every format must hold, and cells of tables.

A spreadsheet must not take a cell for a formula, which may be anybody's name of a class or a film:
an apostrophe stands before it. https://owasp.org/www-community/attacks/CSV_Injection
"""

from __future__ import annotations

import re
from functools import lru_cache

from motes.core.errors import ConfigError

_UNFIT = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")
"""Control characters and line breaks, halves of characters, and what is no character of XML."""


@lru_cache(1000)
def check_label(label: str) -> str:
    """Return the name of a class; raise a ConfigError if it is empty or has an unfit character.

    JSON Lines, XML, YAML and CSV cannot hold all characters, or readers take some for line breaks.
    """
    if found := _UNFIT.search(label):
        raise ConfigError(
            f"the class {label[:60]!r} has the character U+{ord(found[0]):04X}, which is none of a "
            f"name; rename it"
        )
    if not label.strip():
        raise ConfigError(f"the class {label!r} has no letters; rename it")
    return label


MARKS = ("=", "+", "-", "@", "\t", "\r")
"""First characters of what spreadsheets take for a formula."""
GUARD = "'"


def guarded(text: str) -> str:
    """Return a text as it is written into a cell; numbers stay as they are."""
    if not text.lstrip(GUARD).startswith(MARKS):
        return text
    try:
        float(text)
    except ValueError:
        return GUARD + text
    return text


def unguarded(cell: str) -> str:
    """Return the text that `guarded` wrote into a cell."""
    if cell.startswith(GUARD) and cell.lstrip(GUARD).startswith(MARKS):
        return cell[1:]
    return cell
