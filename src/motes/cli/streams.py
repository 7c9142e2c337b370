"""The standard streams: they may be closed at the start, or be terminals of any width."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import sys
from collections.abc import Iterator
from typing import Any

from motes.core.errors import FormatError, clear

NARROWEST, WIDEST = 20, 1000
"""Columns. In fewer, libraries wrap without end; in more, padding takes all memory."""


def log(message: str) -> None:
    """Print a message to the user, a line on standard error."""
    print(f"motes: {clear(message)}", file=sys.stderr)


@contextlib.contextmanager
def usable() -> Iterator[None]:
    """Make the standard streams usable, whatever state they are in.

    - A closed stream is opened, so that no file takes its number. Its input is empty, messages to
      it are dropped, and to write results to it is an error.
    - Text that a closed terminal cannot show is dropped.
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
    """Flush standard output; raise a FormatError if that fails."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        raise FormatError(
            f"Standard output cannot be written: {error.strerror}; send it to another place."
        ) from error


def drop_output() -> None:
    """Flush standard output; if that fails drop its buffer, so that Python does not try again."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _open_closed() -> None:
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            # The lowest free number is this one. Read-only, it raises an error if results are lost.
            os.open(os.devnull, os.O_WRONLY if name == "stderr" else os.O_RDONLY)
            os.set_inheritable(number, True)
            mode = "r" if name == "stdin" else "w"
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115


class _Lenient(io.TextIOWrapper):
    """Text into a file that drops what it cannot write.

    The file below is one of Python's own. If an interrupt came after a `write` of the file in
    Python had written, the buffer above would keep the text, and write it again at the end.
    """

    def write(self, text: str) -> int:
        """Write text; return its length."""
        with contextlib.suppress(OSError):
            super().write(text)
        return len(text)

    def flush(self) -> None:
        """Write what waits."""
        with contextlib.suppress(OSError):
            super().flush()


def _lenient(stream: Any) -> Any:
    """Return a stream to the same file that drops text which it cannot write."""
    try:
        number = stream.fileno()
    except (OSError, ValueError):  # it has no file
        return stream
    stream.flush()
    file = open(number, "wb", closefd=False)  # noqa: SIM115
    return _Lenient(file, stream.encoding, stream.errors, line_buffering=True)
