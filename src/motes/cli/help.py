"""The help of a command: all of its options, or those that most people use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from motes.cli.option_groups import CONFIGURATION, FLAG

if TYPE_CHECKING:
    from cyclopts.help import HelpEntry, HelpPanel
    from rich.console import Console, ConsoleOptions

HelpAll = Annotated[
    bool, FLAG, Parameter(group=CONFIGURATION, help="List all options of this command.")
]


class Help:
    """Shows the help of a command, with its texts from docstrings as running text.

    `usual` are the options that are shown, beside all arguments; by default all.
    """

    def __init__(self, *usual: str) -> None:
        self.usual = frozenset(usual)

    def __call__(self, console: Console, options: ConsoleOptions, panel: HelpPanel) -> None:
        """Show a group of arguments or options, unless no usual one is among them."""
        from cyclopts.help import DefaultFormatter

        shown = [
            _running(entry)
            for entry in panel.entries
            if not (self.usual and entry.positive_names)
            or self.usual.intersection(entry.positive_names)
        ]
        DefaultFormatter()(console, options, panel.copy(entries=shown))

    def render_usage(self, console: Console, options: ConsoleOptions, usage: Any) -> None:
        """Show how the command is called."""
        from cyclopts.help import DefaultFormatter

        DefaultFormatter().render_usage(console, options, usage)


def _running(entry: HelpEntry) -> HelpEntry:
    """Return an entry whose text has no line breaks."""
    from rich.text import Text

    text = getattr(entry.description, "primary_renderable", None)
    if isinstance(text, Text):
        entry.description.primary_renderable = Text(" ".join(text.plain.split()), end=text.end)
    return entry
