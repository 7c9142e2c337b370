"""The standard streams, which may be closed at the start, and terminals, which may be anything."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import sys
from collections.abc import Iterator
from typing import Any, cast

from motes.core.errors import FormatError

NARROWEST, WIDEST = 20, 1000
"""Columns. In fewer, no word fits and the libraries do not end; in more, padding takes the memory.
"""


@contextlib.contextmanager
def usable() -> Iterator[None]:
    """Make the standard streams such that all can rely on them.

    What is closed is opened, lest a file take its place: there is nothing to read, messages are
    dropped, and to write results is an error. What a terminal cannot show, since it is closed, and
    messages that nobody can read, are dropped as well.
    """
    _open_closed()
    columns = shutil.get_terminal_size().columns
    if "COLUMNS" in os.environ or columns < NARROWEST:
        os.environ["COLUMNS"] = str(min(max(columns, NARROWEST), WIDEST))
    with contextlib.ExitStack() as redirected:
        redirected.enter_context(contextlib.redirect_stderr(_lenient(sys.stderr)))
        redirected.callback(sys.stderr.flush)
        if sys.stdout.isatty():
            redirected.enter_context(contextlib.redirect_stdout(_lenient(sys.stdout)))
            redirected.callback(sys.stdout.flush)
        yield


def finish_output() -> None:
    """Write what standard output still holds back; raise a FormatError if that fails."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise FormatError(
            f"Standard output cannot be written: {error.strerror}; send it to another place."
        ) from error


def drop_output() -> None:
    """Write what standard output still holds back, or drop it: Python shall not try once more."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _open_closed() -> None:
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            # The lowest free number is this one. What cannot be written to tells of results lost.
            os.open(os.devnull, os.O_WRONLY if name == "stderr" else os.O_RDONLY)
            os.set_inheritable(number, True)
            mode = "r" if name == "stdin" else "w"
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115


class _Lenient(io.FileIO):
    """Drops what it cannot write."""

    def write(self, data: Any) -> int:
        """Write bytes; return how many there are."""
        try:
            return super().write(data)
        except OSError:
            return len(data)


def _lenient(stream: Any) -> Any:
    """Return a stream to the same place that drops what it cannot write."""
    try:
        number = stream.fileno()
    except (OSError, ValueError):  # it is none of the system's
        return stream
    stream.flush()
    file = _Lenient(number, "w", closefd=False)
    return io.TextIOWrapper(
        cast(Any, io.BufferedWriter(file)), stream.encoding, stream.errors, line_buffering=True
    )
