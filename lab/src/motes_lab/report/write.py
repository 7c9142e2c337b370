"""The report of an evaluation: summary.md, and report.html with plots and images."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from motes.core.types import Floats
from motes_lab.aggregate import Evaluation, Passes, precision_curve, success_curve
from motes_lab.datasets.sot import Problem
from motes_lab.metrics import sot as metrics
from motes_lab.report import failures, plots
from motes_lab.report import sections as report_sections
from motes_lab.report.markdown import summary
from motes_lab.report.speed_ratio import Comparisons, speed_ratios
from motes_lab.report.tables import count_noun, number
from motes_lab.scores import Outcome, write_text


def write_report(
    out: Path,
    outcomes: Iterable[Outcome],
    problems: list[Problem],
    options: Comparisons,
    title: str,
) -> None:
    """Write summary.md and report.html into a folder.

    The page needs neither a network nor other files.

    Parameters
    ----------
    out
        The folder.
    outcomes
        The results of all passes; trackers are compared with the tracker of the first one.
    problems
        Problems of the run; failed passes are added.
    options
        The optional parts of the report.
    title
        The title of the report.

    Raises
    ------
    FormatError
        If a file cannot be written.
    """
    evaluation = Evaluation(outcomes)
    problems = report_sections.problems(problems, evaluation.outcomes)
    write_text(out / "summary.md", summary(evaluation, problems, options, title))
    text = page(
        "one.html",
        evaluation,
        problems,
        title,
        options=options,
        plots_of=partial(_plots, evaluation),
        spread=partial(_auc_distribution, evaluation),
        diagrams=partial(_diagrams, evaluation),
        failures=partial(_failures, evaluation),
        least_frames=failures.MIN_FAILURE_FRAMES,
        speed_ratios=speed_ratios,
    )
    write_text(out / "report.html", text)


def page(
    template: str, evaluation: Passes[Any], problems: list[Problem], title: str, **parts: Any
) -> str:
    """Return a report as HTML.

    Parameters
    ----------
    template
        The file of this folder that is filled.
    evaluation, problems, title
        The results, what went wrong, and the title.
    parts
        Values and functions of this template.
    """
    environment = Environment(
        loader=PackageLoader("motes_lab", "report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    return environment.get_template(template).render(
        evaluation=evaluation,
        problems=problems,
        title=title,
        sections=report_sections,
        count_noun=count_noun,
        style=plots.style,
        tints=[plots.style(tracker)[0] + "4d" for tracker in range(len(evaluation.trackers))],
        **parts,
    )


class Plot(NamedTuple):
    """A figure with a line for each tracker.

    Attributes
    ----------
    title, drawn
        Its title, and the drawing as SVG.
    measured
        The name of the numbers in the legend.
    legend
        For each line, the best first: the tracker's index, its name and its number.
    """

    title: str
    drawn: Markup
    measured: str
    legend: list[tuple[int, str, float]]


def curve_plot(
    evaluation: Passes[Any],
    protocol: str,
    quantity: Callable[[Any], Floats],
    x: Floats,
    summarize: Callable[[Floats], float],
    labels: tuple[str, str, str, str],
) -> Plot:
    """Return a plot of a curve for each tracker.

    Parameters
    ----------
    evaluation, protocol
        The results.
    quantity
        A function from the result of a pass to a curve (n,).
    x
        (n,), the horizontal coordinates.
    summarize
        A function from a curve to the number in the legend.
    labels
        The figure's title, the labels of its axes, and the name of the number.
    """
    lines = {}
    for i, tracker in enumerate(evaluation.trackers):
        curves = evaluation.per_seed(tracker, protocol, quantity)
        if known := [curve for curve in curves if np.isfinite(curve).all()]:
            lines[i] = np.mean(known, axis=0)
    numbers = {i: summarize(line) for i, line in lines.items()}
    return _line_plot(evaluation.trackers, protocol, x, lines, numbers, labels)


def _line_plot(
    trackers: list[str],
    protocol: str,
    x: Floats,
    lines: dict[int, Floats],
    numbers: dict[int, float],
    labels: tuple[str, str, str, str],
) -> Plot:
    """Return a plot of a line and a number for each tracker; see `curve_plot`."""
    title, horizontal, vertical, measured = labels
    legend = [(i, trackers[i], numbers[i]) for i in sorted(lines, key=lambda i: -numbers[i])]
    name = f"{title.lower()}-{protocol}"
    drawn = plots.curves(name, x, lines, (horizontal, vertical)) if lines else ""
    return Plot(title, Markup(drawn), measured, legend)


def _plots(evaluation: Evaluation, protocol: str) -> list[Plot]:
    """Return the success and precision plots of a protocol."""
    return [
        curve_plot(
            evaluation, protocol, success_curve, metrics.THRESHOLDS, np.mean,
            ("Success", "overlap threshold (IoU)", "share of frames above it", "AUC"),
        ),
        curve_plot(
            evaluation, protocol, precision_curve, metrics.PIXELS.astype(float),
            lambda y: float(y[20]),
            (
                "Precision", "distance threshold (pixels)", "share of frames within it",
                "at 20 pixels",
            ),
        ),
    ]  # fmt: skip


def _auc_distribution(evaluation: Evaluation) -> Plot:
    """Return a plot of the distribution of AUC over the passes of `robust`."""
    x, lines, numbers = np.linspace(0, 1, 101), {}, {}
    for i, tracker in enumerate(evaluation.trackers):
        values = evaluation.aucs(tracker, "robust")
        if values.size:
            lines[i] = np.quantile(values, x)
            numbers[i] = evaluation.worst_tenth(tracker, "robust").mean
    labels = ("Spread", "share of passes, the worst first", "AUC of a pass", "worst tenth")
    return _line_plot(evaluation.trackers, "robust", x, lines, numbers, labels)


class Diagram(NamedTuple):
    """A tracker's reliability diagram as SVG, its calibration error, and its number of frames."""

    tracker: str
    drawn: Markup
    error: str
    frames: int


def _diagrams(evaluation: Evaluation, protocol: str) -> tuple[list[Diagram], list[str]]:
    """Return the diagrams of trackers that give a confidence, and the names of the others."""
    drawn, silent = [], []
    for i, tracker in enumerate(evaluation.trackers):
        found = evaluation.reliability(tracker, protocol)
        if found is None:
            silent.append(tracker)
            continue
        svg = Markup(plots.diagram(f"reliability-{i}", i, found))
        error = number(evaluation.calibration(tracker, protocol)).text
        drawn.append(Diagram(tracker, svg, error, int(found.frames.sum())))
    return drawn, silent


def _failures(evaluation: Evaluation) -> tuple[int, list[failures.Picture], list[str]]:
    """Return the number of failures, images of some, and the reasons why others are missing."""
    found = failures.failures(evaluation)
    pictures, reasons = failures.draw(failures.choose(found))
    return len(found), pictures, reasons
