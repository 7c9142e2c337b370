"""The message and the exit code of an error that ends the program."""

from __future__ import annotations

import errno
import itertools
import os
from collections.abc import Sequence

from cyclopts import (
    App,
    CycloptsError,
    MissingArgumentError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from motes.cli.exit_codes import AWAY, FAULT, NO_MEMORY, UNREADABLE, UNWRITABLE, USAGE
from motes.core.errors import AwayError, FormatError, InputError, MotesError, SourceError

CODES: dict[type[MotesError], int] = {
    AwayError: AWAY, SourceError: UNREADABLE, InputError: UNREADABLE, FormatError: UNWRITABLE,
    MotesError: USAGE,
}  # fmt: skip
"""The exit codes of errors; the first class that fits counts."""
LACKS = "can't start new thread", "failed to map segment", "cannot allocate memory"
"""Signs in an error that a thread, a library or the system is out of memory."""

NO_HOME = "You have no home folder here; name one in the environment variable HOME."


def explain(error: Exception, program: str) -> tuple[str, int]:
    """Return the message for an error of a program, and its exit code."""
    for kind, code in CODES.items():
        if isinstance(error, kind):
            return str(error), code
    if isinstance(error, CycloptsError):
        return _wrong_option(error, program), USAGE
    no_memory = isinstance(error, MemoryError) or getattr(error, "errno", None) == errno.ENOMEM
    if no_memory or any(sign in str(error) for sign in LACKS):
        return NO_MEMORY, USAGE
    if isinstance(error, OSError) and error.errno in (errno.EMFILE, errno.ENFILE):
        return "No more files can be opened; raise the limit (ulimit -n), or ask for less.", USAGE
    if isinstance(error, RuntimeError) and "determine home directory" in str(error):
        return NO_HOME, USAGE
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        return f"{where}{error.strerror or error}; make it possible and try again.", UNWRITABLE
    return (
        f"{type(error).__name__}: {error}. This is a defect of motes; please report it with what "
        f"MOTES_DEBUG=1 shows in addition.",
        FAULT,
    )


def _wrong_option(error: CycloptsError, program: str) -> str:
    """Return the message for an option that the parser refuses."""
    command = " ".join([program, *(error.command_chain or ())])
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        if error.keyword is None:
            return f"{error.argument.name} is missing; see {command} --help."
        if (error.keyword, "-") in itertools.pairwise(error.root_input_tokens or ()):
            return f"{error.keyword} does not take -; see {command} --help."
        return f"{error.keyword} needs a value; see {command} --help."
    if isinstance(error, UnknownOptionError | UnusedCliTokensError) and (late := _late(error)):
        return f"After -- come names only, and {late} is an option; write it before --."
    if isinstance(error, UnknownOptionError):
        from motes.cli.load_config import is_key

        flag = error.token.keyword or error.token.value
        key = flag.lstrip("-").replace("-", "_")
        known = [] if error.app is None else _options(error.app)
        if "--set" in known and is_key(key):
            return f"{flag} is a key of the configuration; write --set {key}=VALUE."
        if key in ("scale", "ground", "lens"):
            return (
                f"There is no option {flag} here; motes convert ROWS OTHER {flag} … adds metres to "
                f"rows, or corrects them."
            )
        if "--overlay" in known and any(word in key for word in ("video", "save")):
            return f"There is no option {flag}; --overlay draws a film of tracks, -o writes rows."
        if flag == "-":
            return "- is no file; for standard input give /dev/stdin, for output /dev/stdout."
        if os.path.exists(flag):
            return f"There is no option {flag}; for the file write ./{flag}."
    if isinstance(error, UnusedCliTokensError):
        words = error.unused_tokens or []
        hint = "a name with spaces needs quotes, and a file to write its option, as -o; "
        if _are_numbers(words):
            hint = "numbers of one option need commas and no spaces; "
        if command.split()[-1] in ("track", "watch", "batch") and all(map(os.path.exists, words)):
            hint = "motes batch goes through several films; " * (command != "motes batch")
            hint += "quote a pattern, as 'img/*.png', which the shell has replaced by names; "
        return f"No option takes {' '.join(words)}; {hint}see {command} --help."
    return f"{error} See {command} --help."


def _late(error: CycloptsError) -> str | None:
    """Return the first option behind --, where all are names; None without one."""
    words = [*itertools.dropwhile(lambda word: word != "--", error.root_input_tokens or ())]
    known = _options(error.app) if words and error.app is not None else []
    flags = (word.partition("=")[0] for word in words if not os.path.exists(word))
    return next((flag for flag in flags if flag in known), None)


def _options(app: App) -> list[str]:
    """Return the names of all options of a command."""
    return [name for each in app.assemble_argument_collection() for name in each.names]


def _are_numbers(words: Sequence[str]) -> bool:
    """Return whether all words are numbers, as in --init 300 200 40 60."""
    try:
        _ = [float(part) for word in words for part in word.strip(",").split(",")]
    except ValueError:
        return False
    return True
