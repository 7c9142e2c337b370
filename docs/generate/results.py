"""Run the experiments of the documentation, and write their tables into its pages: `make results`.

A measured table of a page has markers around it, with its name, the minutes that it takes, and the
beginning of the titles of the tables that are shown. The commands that make it follow, indented:

    <!-- results campus | 2 min | All frames -->

        motes-lab experiment zhao-figure9 MOT/TUD-Campus

    | sequence | frames | ...

    Measured on 2026-11-22.

    <!-- end campus -->

Rows of tables with the same columns are put together. A command is one of motes-lab, or Python that
prints its tables: a script of benchmarks/, or a module of a folder of tests (`PYTHONPATH=tests
python ...`). It names folders of data in capitals (`FOLDERS`). What it writes is kept in results/,
so that a run that was stopped goes on where it was, with the minutes that it took; remove results/
to measure again. A command of several tables runs once.
"""

from __future__ import annotations

import argparse
import datetime
import hashlib
import json
import os
import re
import shlex
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs", ROOT / "lab" / "docs"
KEPT = ROOT / "results"
"""The folder of what the commands write."""
DATA = Path(os.environ.get("MOTES_DATA", ROOT.parent / "shared" / "data")).resolve()
FOLDERS = {
    "DATA": ".",
    "SEQUENCES": "sot",
    "OTHERS": "sot-more",
    "FILMS": "film",
    "MOT": "mot",
    "VIDEOS": "video",
    "BACKBONE": "network/backbone.onnx",
    "HEAD": "network/head.onnx",
}
"""Names of folders and files in commands, and where they are in `DATA`."""
RESUMED = "evaluate"
"""The command that goes on by itself where it was stopped."""
MODULES = re.compile(r"PYTHONPATH=(\S+) ")
"""How a command begins that needs the modules of a folder of tests."""
SCRIPT = "python "
"""How a command goes on that prints its tables; all others are those of motes-lab."""
BLOCK = re.compile(
    r"^<!-- results (?P<name>[\w-]+) \| (?P<minutes>[\d.]+) min \| (?P<title>[^|]+?) -->\n"
    r"(?P<commands>(?:\n|    [^\n]+\n)+)(?P<tables>.*?)^<!-- end (?P=name) -->$",
    re.DOTALL | re.MULTILINE,
)


class Block(NamedTuple):
    """A measured table of a page.

    Attributes
    ----------
    name, page
        Its name and the file that it is in.
    minutes
        How long its commands take, about.
    title
        The beginning of the titles of the tables that are shown.
    commands
        The commands that make it, with names of `FOLDERS`.
    tables
        The text below the commands.
    """

    name: str
    page: Path
    minutes: float
    title: str
    commands: tuple[str, ...]
    tables: str


class Written(NamedTuple):
    """A table as a command has written it: title, head and rule, rows, and the note below."""

    title: str
    head: str
    rows: tuple[str, ...]
    note: str


def blocks(pages: Iterable[Path]) -> list[Block]:
    """Return the measured tables of pages."""
    found = []
    for page in pages:
        for each in BLOCK.finditer(page.read_text(encoding="utf-8")):
            text = each["commands"].replace("\\\n", " ")
            commands = tuple(" ".join(line.split()) for line in text.splitlines() if line.strip())
            minutes = float(each["minutes"])
            found.append(
                Block(each["name"], page, minutes, each["title"], commands, each["tables"])
            )
    return found


def written(text: str) -> list[Written]:
    """Return the tables in a text of Markdown, as commands write them."""
    found = []
    for part in re.split(r"^### ", text, flags=re.MULTILINE)[1:]:
        title, _, rest = part.partition("\n")
        lines = [line for line in rest.partition("\n## ")[0].splitlines() if line]
        table = [line for line in lines if line.startswith("|")]
        note = " ".join(line for line in lines if not line.startswith("|"))
        if table:
            found.append(Written(title, "\n".join(table[:2]), tuple(table[2:]), note))
    return found


def together(tables: Iterable[Written]) -> list[Written]:
    """Return tables with the rows of those that have the same columns put together."""
    found: dict[str, Written] = {}
    for table in tables:
        before = found.setdefault(table.head, table._replace(rows=()))
        found[table.head] = before._replace(rows=before.rows + table.rows)
    return list(found.values())


def arguments(command: str) -> list[str]:
    """Return a command without its first word, with the folders in place of their names."""
    _, *given = shlex.split(MODULES.sub("", command))
    names = "|".join(FOLDERS)
    return [
        re.sub(rf"(?<![^=,])({names})(?=[/,]|$)", lambda name: str(DATA / FOLDERS[name[0]]), each)
        for each in given
    ]


def folder_name(command: str) -> str:
    """Return the name of the folder of a command's results."""
    name = "-".join(re.findall(r"[\w-]+", MODULES.sub("", command))[1:3])
    return f"{name}-{hashlib.sha256(command.encode()).hexdigest()[:8]}"


def run(command: str, folder: Path) -> int:
    """Run a command that writes its tables into a folder; return its exit code."""
    given = arguments(command)
    if MODULES.sub("", command).startswith(SCRIPT):
        paths = [str(ROOT / folder) for folder in MODULES.findall(command)]
        paths += filter(None, [os.environ.get("PYTHONPATH")])
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / "printed.md").open("wb") as printed:
            script = [sys.executable, *given]
            return subprocess.run(script, stdout=printed, cwd=ROOT, env=environment).returncode
    again = "--resume" if given[0] == RESUMED and folder.exists() else "--overwrite"
    line = [sys.executable, "-m", "motes_lab", *given, "--out", str(folder), again]
    return subprocess.run(line, stdout=subprocess.DEVNULL, cwd=ROOT).returncode


def measure(block: Block, kept: Path) -> tuple[list[Written], str]:
    """Run the commands of a table that have not been run, and return its tables and the date.

    Raises
    ------
    RuntimeError
        If a command fails, or writes no such table.
    """
    tables, dates = list[Written](), []
    for command in block.commands:
        folder = kept / folder_name(command)
        done = folder / "done.json"
        if not done.exists():
            print(f"{block.name}: {command}", flush=True)
            start = time.monotonic()
            if code := run(command, folder):
                raise RuntimeError(f"{command} ended with exit code {code}.")
            minutes = round((time.monotonic() - start) / 60, 2)
            print(f"{block.name}: {minutes} min", flush=True)
            today = datetime.date.today().isoformat()
            done.write_text(json.dumps({"command": command, "date": today, "minutes": minutes}))
        dates.append(json.loads(done.read_text())["date"])
        texts = (each.read_text(encoding="utf-8") for each in sorted(folder.glob("*.md")))
        tables += [each for text in texts for each in written(text)]
    shown = together(each for each in tables if each.title.startswith(block.title))
    if not shown:
        titles = ", ".join(each.title for each in tables)
        raise RuntimeError(f"No table begins with {block.title!r}; there are {titles or 'none'}.")
    return shown, max(dates)


def as_text(tables: Sequence[Written], date: str) -> str:
    """Return what is between the commands and the end of a table; titles if there are several."""
    parts = []
    for table in tables:
        parts += [f"{table.title}:"] if len(tables) > 1 else []
        parts += ["\n".join([table.head, *table.rows]), *[table.note] * bool(table.note)]
    text = "\n\n".join([*parts, f"Measured on {date}.", ""])
    for name, place in FOLDERS.items():  # files are a part of the names of trackers
        text = re.sub(rf"{re.escape(str(DATA / place))}(?=[,\s])", name, text)
    return text


def write(block: Block, text: str) -> None:
    """Replace the text of a table in its page."""

    def replaced(found: re.Match[str]) -> str:
        if found["name"] != block.name:
            return found[0]
        start, end = (place - found.start() for place in found.span("tables"))
        return found[0][:start] + text + found[0][end:]

    page = block.page.read_text(encoding="utf-8")
    block.page.write_text(BLOCK.sub(replaced, page), encoding="utf-8")


def main(line: Sequence[str] | None = None) -> int:
    """Make the tables that are named, or all, the shortest first; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="tables to make; all by default")
    parser.add_argument("--list", action="store_true", help="only say which, and how long each is")
    options = parser.parse_args(line)
    names = options.names
    found = sorted(
        blocks(sorted(page for folder in DOCS for page in folder.glob("*.md"))),
        key=lambda each: each.minutes,
    )
    if unknown := set(names) - {each.name for each in found}:
        known = ", ".join(sorted(each.name for each in found))
        parser.error(f"there is no table {', '.join(sorted(unknown))}; known are {known}.")
    wanted = [each for each in found if not names or each.name in names]
    if options.list:
        print(*(f"{each.minutes:6g} min  {each.name}" for each in wanted), sep="\n")
    minutes = sum({each.commands: each.minutes for each in wanted}.values())
    print(f"{len(wanted)} tables, about {minutes:.0f} min without those that are in {KEPT.name}/.")
    if options.list:
        return 0
    failed = 0
    for block in wanted:
        try:
            write(block, as_text(*measure(block, KEPT)))
        except RuntimeError as error:
            print(f"{block.name}: {error}", file=sys.stderr)
            failed += 1
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
