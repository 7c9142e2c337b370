"""All commands, each with one line of help, and what other programs bring, by entry points.

A command's module is imported when it is called. A run that asks for a rig of cameras, events over
networks or the figures of the papers without their program says what to install.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from typing import Any

from cyclopts import App

from motes import __version__
from motes.cli.exit_codes import EXIT_CODES
from motes.cli.option_groups import Help
from motes.core.errors import MissingDependencyError, PluginError
from motes.core.registry import Registry


def program(name: str, what: str) -> App:
    """Return a program without commands, whose errors are raised."""
    return App(
        name=name,
        version=__version__,
        help=what,
        help_epilogue=EXIT_CODES,
        help_format="plaintext",
        help_formatter=Help(),
        result_action="return_value",
        exit_on_error=False,
        print_error=False,
        suppress_keyboard_interrupt=False,
    )


app = program(
    "motes", "Track objects in video with particle filters: without training, in real time."
)
COMMANDS = {
    "track": "Track one object, or several, through a video.",
    "refine": "Correct tracks; only what changes is tracked again.",
    "smooth": "Smooth tracks, and fill gaps.",
    "check": "List the frames in which tracks are doubtful.",
    "draw": "Draw tracks on their film, with figures.",
    "watch": "Track and count all objects that move.",
    "convert": "Convert tracks and annotations between formats.",
    "config": "List presets and all configuration keys.",
    "network": "Get trained networks that join the tracker.",
    "demo": "Show on rendered films what motes does.",
    "doctor": "Check the installation.",
}
"""The commands of motes, each in a file of its name, and its line of help."""
PLACES = {name: f"motes.cli.{name}:app" for name in COMMANDS}
PLACES |= {name: f"motes.cli.{name}:{name}" for name in ("demo", "doctor")}  # plain functions
for command, what in COMMANDS.items():
    app.command(PLACES[command], name=command, help=what)
PROGRAMS = {
    "batch": ("fleet", "Track in many films, on many machines."),
    "studio": ("studio", "Track, check and correct in a browser."),
}
"""Commands of motes' other programs: the extras that install these, and their lines of help."""
JOINED = Registry[App]("command", "motes.commands", App, PLACES, values=True)
"""Commands that other packages add: ours, and those of users."""
app.register_install_completion_command(help="Install completion for this shell and exit.")


PARTS = Registry[Callable[..., Any]]("part", "motes.parts", Callable, {}, values=True)
"""What commands of motes leave to other programs."""


def part(name: str, need: str, program: str = "fleet") -> Callable[..., Any]:
    """Return what another program brings.

    Raises a MissingDependencyError if no installed package has it. `name` is that of its entry
    point, and `need` what needs it, as the subject of an error.
    """
    if name not in PARTS:
        raise missing(need, program)
    return PARTS.resolve(name)


def missing(need: str, program: str) -> MissingDependencyError:
    """Return the error for something that a program brings which is not installed."""
    return MissingDependencyError(
        f"{need} needs motes-{program}; install it with: pip install 'motes[{program}]'."
    )


def commands(tokens: Sequence[str]) -> App:
    """Return all commands; those of other packages are loaded only where they may be meant.

    Raises a MissingDependencyError if the command is of a program that is not installed, and a
    PluginError if the package that adds the command cannot be used.
    """
    first = tokens[0] if tokens else ""
    if first in COMMANDS:
        return app
    if first in JOINED and first not in app:
        app.command(JOINED.resolve(first), name=first)
    elif first in PROGRAMS and first not in app:
        raise missing(f"motes {first}", PROGRAMS[first][0])
    else:
        for name in JOINED.names():
            if name in PROGRAMS and name not in app:
                app.command(JOINED.target(name), name=name, help=PROGRAMS[name][1])
            elif name not in app:
                with contextlib.suppress(PluginError):  # its own call says what is wrong
                    app.command(JOINED.resolve(name), name=name)
    return app


def show_all(command: str) -> None:
    """Print the help of a command with all of its options."""
    with app.app_stack([app], overrides={"help_formatter": Help()}):
        app.help_print([command])
