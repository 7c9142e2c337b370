"""All commands, each with one line of help. A command's module is imported when it is called."""

from __future__ import annotations

from cyclopts import App

from motes import __version__
from motes.cli.help import Help
from motes.cli.settings import refuse_clashes

EXIT_CODES = """\
Exit codes:
  0    done
  1    a fault in motes or its installation
  2    wrong option, configuration or region, or a part is not installed
  3    an input cannot be read
  4    the target was never found
  5    an output exists or cannot be written
  6    done, but some sequences, trackers or cameras failed
  7    a live source ended, and was away for longer than --reconnect allows
  129  the terminal was closed (SIGHUP)
  130  interrupted by Ctrl-C (SIGINT)
  143  terminated (SIGTERM)
With the last three, the outputs are finished and kept, and the summary is printed.
"""


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
app.command(
    "motes.cli.track:app", name="track", help="Track one object, or several, through a video."
)
app.command(
    "motes.cli.refine:app",
    name="refine",
    help="Correct tracks; only what changes is tracked again.",
)
app.command("motes.cli.smooth:app", name="smooth", help="Smooth tracks, and fill gaps.")
app.command(
    "motes.cli.check:app", name="check", help="List the frames in which tracks are doubtful."
)
app.command("motes.cli.draw:app", name="draw", help="Draw tracks on their film, with figures.")
app.command("motes.cli.watch:app", name="watch", help="Track and count all objects that move.")
app.command("motes.cli.batch:app", name="batch", help="Track in many films, on many machines.")
app.command(
    "motes.cli.convert:app", name="convert", help="Convert tracks and annotations between formats."
)
app.command("motes.cli.config:app", name="config", help="List presets and all configuration keys.")
app.command("motes.cli.studio:app", name="studio", help="Track, check and correct in a browser.")
app.command("motes.cli.serve:app", name="serve", help="Track for annotation tools.")
app.command("motes.cli.demo:demo", name="demo", help="Show on rendered films what motes does.")
app.command("motes.cli.doctor:doctor", name="doctor", help="Check the installation.")
app.register_install_completion_command(help="Install completion for this shell and exit.")


def show_all(command: str) -> None:
    """Print the help of a command with all of its options."""
    with app.app_stack([app], overrides={"help_formatter": Help()}):
        app.help_print([command])
