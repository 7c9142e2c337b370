"""The report of an evaluation, and tables, as Markdown."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from motes_lab.aggregate import Passes
from motes_lab.datasets.sot import Problem
from motes_lab.report.sections import problem_table, run_summary
from motes_lab.report.tables import Cell, Table
from motes_lab.scores import write_text


def write_report(
    out: Path,
    evaluation: Passes[Any],
    sections: Mapping[str, list[Table]],
    problems: list[Problem],
    title: str,
) -> None:
    """Write summary.md into a folder: tables by the title of their section, and the problems.

    Raises
    ------
    FormatError
        If it cannot be written.
    """
    parts = [f"# {_literal(title)}", _literal(run_summary(evaluation))]
    if problems:
        sections = {**sections, "What went wrong": [problem_table(problems)]}
    for name, tables in sections.items():
        parts += [f"## {_literal(name)}", *map(table, tables)]
    write_text(out / "summary.md", "\n\n".join(parts) + "\n")


def table(table: Table) -> str:
    """Return a table under its title."""
    lines = [
        tuple(map(_literal, table.head)),
        tuple("---" for _ in table.head),
        *(tuple(map(_cell, row)) for row in (*table.rows, *table.foot)),
    ]
    rows = "\n".join(f"| {' | '.join(line)} |" for line in lines) if table.rows else ""
    parts = (f"### {_literal(table.title)}", rows, _literal(table.note))
    return "\n\n".join(part for part in parts if part)


def _cell(cell: Cell) -> str:
    text = _literal(cell.text)
    return f"**{text}**" if cell.best else text


def _literal(text: str) -> str:
    """Return text in one line with all characters escaped that Markdown would interpret."""
    return re.sub(r"[\\`*|<>\[\]#$]|\b_|_\b", r"\\\g<0>", " ".join(text.split()))
