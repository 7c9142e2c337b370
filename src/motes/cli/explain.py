"""What to say about an error that ends the program, and the exit code that it has."""

from __future__ import annotations

import errno
import inspect

from cyclopts import CycloptsError, MissingArgumentError

from motes.cli.exit_codes import FAULT, NO_MEMORY, UNREADABLE, UNWRITABLE, USAGE
from motes.core.errors import FormatError, MotesError, SourceError


def explain(error: Exception) -> tuple[str, int]:
    """Return what to say about an error, and its exit code."""
    if isinstance(error, SourceError):
        return str(error), UNREADABLE
    if isinstance(error, FormatError):
        return str(error), UNWRITABLE
    if isinstance(error, MotesError):
        return str(error), USAGE
    if isinstance(error, MissingArgumentError) and (unknown := _unknown_option(error)):
        return unknown, USAGE
    if isinstance(error, CycloptsError):
        command = " ".join(["motes", *(error.command_chain or ())])
        return f"{error} See {command} --help.", USAGE
    if isinstance(error, MemoryError) or _lacks_memory(error):
        return NO_MEMORY, USAGE
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        return f"{where}{error.strerror or error}; make it possible and try again.", UNWRITABLE
    return (
        f"{type(error).__name__}: {error}. This is a defect of motes; please report it with what "
        f"MOTES_DEBUG=1 shows in addition.",
        FAULT,
    )


def _lacks_memory(error: Exception) -> bool:
    """Return whether an error says that a thread, a library or the system finds no memory."""
    signs = ("can't start new thread", "failed to map segment", "cannot allocate memory")
    text = str(error)
    return getattr(error, "errno", None) == errno.ENOMEM or any(sign in text for sign in signs)


def _unknown_option(error: MissingArgumentError) -> str | None:
    """Return the message for an option without a value that is no key of the configuration.

    The parser takes every unknown option for a key.
    """
    argument, command = error.argument, error.target
    if argument is None or argument.field_info.kind is not inspect.Parameter.VAR_KEYWORD:
        return None
    assert command is not None
    assert error.keyword is not None

    from motes.cli.load_config import no_such_option
    from motes.core.config_keys import names
    from motes.mot.pipeline_config import WatchConfig
    from motes.sot.presets import TrackerConfig

    known = names(WatchConfig if command.__name__ == "watch" else TrackerConfig)
    if error.keyword.lstrip("-").split(".")[0].replace("-", "_") in known:
        return None
    return no_such_option(command, error.keyword, known)
