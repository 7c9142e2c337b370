"""The summary of an evaluation as Markdown."""

from __future__ import annotations

import re
from collections.abc import Mapping

from motes_lab.aggregate import Evaluation
from motes_lab.datasets.sot import Problem
from motes_lab.report import sections as report_sections
from motes_lab.report.speed_ratio import Comparisons, speed_ratios
from motes_lab.report.tables import Cell, Table


def summary(
    evaluation: Evaluation, problems: list[Problem], options: Comparisons, title: str
) -> str:
    """Return the text of summary.md: the tables of each protocol, references and problems."""
    sections: dict[str, list[Table]] = {}
    for protocol in evaluation.protocols:
        tables = [report_sections.overall(evaluation, protocol)]
        if len(evaluation.trackers) > 1:
            tables.append(report_sections.comparisons(evaluation, protocol))
        for make in (
            report_sections.per_sequence,
            report_sections.lost_status,
            report_sections.recovery,
            report_sections.times,
        ):
            tables.append(make(evaluation, protocol))
        if (pace := speed_ratios(evaluation, protocol, options.peer)).rows:
            tables.append(pace)
        if protocol == "robust":
            tables.append(report_sections.per_view(evaluation))
        sections[report_sections.title(evaluation, protocol)] = tables
    if options.reference is not None:
        sections["Published results"] = [report_sections.reference(evaluation, options.reference)]
    return document(title, report_sections.run_summary(evaluation), sections, problems)


def document(
    title: str, described: str, sections: Mapping[str, list[Table]], problems: list[Problem]
) -> str:
    """Return a text with the tables of each section, and the problems."""
    parts = [f"# {_literal(title)}", _literal(described)]
    if problems:
        sections = {**sections, "What went wrong": [report_sections.problem_table(problems)]}
    for name, tables in sections.items():
        parts += [f"## {_literal(name)}", *map(table, tables)]
    return "\n\n".join(parts) + "\n"


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
