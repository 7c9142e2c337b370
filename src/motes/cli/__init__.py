"""The command line: one file per command. What only one command needs is imported by it."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import App, CycloptsError

from motes import __version__
from motes.errors import FormatError, MotesError, SourceError, clear

EXIT_CODES = """\
Exit codes:
  0    done
  1    a fault in motes or its installation
  2    wrong option, configuration or region, or a part is not installed
  3    an input cannot be read
  4    the target was never found
  5    an output exists or cannot be written
  6    done, but some sequences, trackers or cameras failed
  130  interrupted; what was written is kept
"""
DONE, FAULT, USAGE, UNREADABLE, NOT_FOUND, UNWRITABLE, PARTIAL, INTERRUPTED = *range(7), 130

app = App(
    name="motes",
    version=__version__,
    help="Follow objects through video with particle filters: training-free, in real time.",
    help_epilogue=EXIT_CODES,
    help_format="plaintext",
    result_action="return_value",
    exit_on_error=False,
    print_error=False,
    suppress_keyboard_interrupt=False,
)
app.command("motes.cli.track:app", name="track", help="Follow one object through a video.")
app.command("motes.cli.watch:watch", name="watch", help="Follow and count all that moves.")
app.command(
    "motes.cli.convert:app", name="convert", help="Make the document of a run that was cut off."
)
app.command("motes.cli.histogram:app", name="histogram", help="Save what a target looks like.")
app.command("motes.cli.evaluate:app", name="evaluate", help="Measure trackers on sequences.")
app.command("motes.cli.experiment:app", name="experiment", help="Reproduce the papers' tables.")
app.command("motes.cli.demo:demo", name="demo", help="Show it all on a rendered clip.")
app.command("motes.cli.bench:bench", name="bench", help="Measure the speed on this machine.")
app.command("motes.cli.doctor:doctor", name="doctor", help="Check the installation.")
app.register_install_completion_command(help="Install completion for this shell and exit.")


def main(tokens: Sequence[str] | None = None) -> int:
    """Run the program with its arguments, those of the process by default; return the exit code.

    No exception leaves it: each becomes one line on standard error. MOTES_DEBUG=1 adds tracebacks.
    """
    try:
        code = app(sys.argv[1:] if tokens is None else tokens)
        sys.stdout.flush()
        return code or DONE
    except BrokenPipeError:
        # The reader of a pipe has seen enough. Python's own flush on exit shall not complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        if os.environ.get("MOTES_DEBUG"):
            raise
        message, code = _explain(error)
        print("motes: error:", clear(" ".join(message.split())), file=sys.stderr)
        return code


def _explain(error: Exception) -> tuple[str, int]:
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
