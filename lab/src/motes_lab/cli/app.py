"""All commands of the lab. A command's module is imported when it is called."""

from __future__ import annotations

from motes.cli import program

app = program("motes-lab", "Measure trackers, and reproduce the tables and figures of the papers.")
app.command("motes_lab.cli.evaluate:app", name="evaluate", help="Measure trackers on sequences.")
app.command(
    "motes_lab.cli.experiment:app",
    name="experiment",
    help="Reproduce tables and figures of the papers.",
)
app.command("motes_lab.cli.bench:bench", name="bench", help="Measure the speed on this machine.")
app.register_install_completion_command(help="Install completion for this shell and exit.")
