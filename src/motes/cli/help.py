"""The help of commands with many options: those that most people use, or all with --help-all."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from motes.cli.options import CONFIGURATION, FLAG

if TYPE_CHECKING:
    from cyclopts.help import HelpPanel
    from rich.console import Console, ConsoleOptions

HelpAll = Annotated[
    bool, FLAG, Parameter(group=CONFIGURATION, help="List all options of this command.")
]


class UsualOptions:
    """Shows the help of a command with its arguments, but only some of its options.

    Parameters
    ----------
    names
        The options.
    """

    def __init__(self, *names: str) -> None:
        self.names = frozenset(names)

    def __call__(self, console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
        """Show a group of arguments or options, unless no usual one is among them."""
        from cyclopts.help import DefaultFormatter

        shown = [
            entry
            for entry in panel.entries
            if not entry.positive_names or self.names.intersection(entry.positive_names)
        ]
        DefaultFormatter()(console, options, panel.copy(entries=shown))

    def render_usage(self, console: Console, options: ConsoleOptions, usage: Any) -> None:
        """Show how the command is called."""
        from cyclopts.help import DefaultFormatter

        DefaultFormatter().render_usage(console, options, usage)


def show_all(command: str) -> None:
    """Print the help of a command with all of its options."""
    from cyclopts.help import DefaultFormatter

    from motes.cli.app import app

    with app.app_stack([app], overrides={"help_formatter": DefaultFormatter()}):
        app.help_print([command])
