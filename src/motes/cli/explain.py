"""What to say about an error that ends the program, and the exit code that it has."""

from __future__ import annotations

from cyclopts import CycloptsError

from motes.cli import FAULT, UNREADABLE, UNWRITABLE, USAGE
from motes.errors import FormatError, MotesError, SourceError


def explain(error: Exception) -> tuple[str, int]:
    """Return what to say about an error, and its exit code."""
    if isinstance(error, SourceError):
        return str(error), UNREADABLE
    if isinstance(error, FormatError):
        return str(error), UNWRITABLE
    if isinstance(error, MotesError):
        return str(error), USAGE
    if isinstance(error, CycloptsError):
        command = " ".join(["motes", *(error.command_chain or ())])
        return f"{error} See {command} --help.", USAGE
    if isinstance(error, MemoryError):
        return "There is not enough memory; use fewer particles or a smaller picture.", USAGE
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        return f"{where}{error.strerror or error}; make it possible and try again.", UNWRITABLE
    return (
        f"{type(error).__name__}: {error}. This is a defect of motes; please report it with what "
        f"MOTES_DEBUG=1 shows in addition.",
        FAULT,
    )
