"""Texts in CSV that a spreadsheet must not take for formulas: an apostrophe stands before them.

A name of a class or of a film may be anybody's. https://owasp.org/www-community/attacks/CSV_Injection
"""

from __future__ import annotations

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
