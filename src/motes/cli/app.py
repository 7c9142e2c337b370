"""All commands, each with one line of help. A command's module is imported when it is called."""

from __future__ import annotations

from cyclopts import App

from motes import __version__
from motes.cli.exit_codes import EXIT_CODES
from motes.cli.help import Help
from motes.cli.settings import refuse_clashes


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
        config=(refuse_clashes,),
    )


app = program(
    "motes", "Track objects in video with particle filters: without training, in real time."
)
COMMANDS = {
    "track:app": "Track one object, or several, through a video.",
    "refine:app": "Correct tracks; only what changes is tracked again.",
    "smooth:app": "Smooth tracks, and fill gaps.",
    "check:app": "List the frames in which tracks are doubtful.",
    "draw:app": "Draw tracks on their film, with figures.",
    "watch:app": "Track and count all objects that move.",
    "batch:app": "Track in many films, on many machines.",
    "convert:app": "Convert tracks and annotations between formats.",
    "config:app": "List presets and all configuration keys.",
    "network:app": "Get trained networks that join the tracker.",
    "studio:app": "Track, check and correct in a browser.",
    "serve:app": "Track for annotation tools.",
    "demo:demo": "Show on rendered films what motes does.",
    "doctor:doctor": "Check the installation.",
}
"""Where each command is, by the name of its file, and its line of help."""
for place, what in COMMANDS.items():
    app.command(f"motes.cli.{place}", name=place.partition(":")[0], help=what)
app.register_install_completion_command(help="Install completion for this shell and exit.")


def show_all(command: str) -> None:
    """Print the help of a command with all of its options."""
    with app.app_stack([app], overrides={"help_formatter": Help()}):
        app.help_print([command])
