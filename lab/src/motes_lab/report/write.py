"""The report of an evaluation: summary.md, and report.html with plots and images."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Iterable, Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from motes.core.types import Floats
from motes_lab.aggregate import Evaluation, Passes, precision_curve, success_curve
from motes_lab.datasets.sot import Problem
from motes_lab.metrics import sot as metrics
from motes_lab.report import cross_validation, failures, plots
from motes_lab.report import html as page
from motes_lab.report import sections as report_sections
from motes_lab.report.markdown import summary
from motes_lab.report.speed_ratio import Comparisons, speed_ratios
from motes_lab.report.tables import Table, count_noun, number
from motes_lab.scores import Outcome, write_text


def write_report(
    out: Path,
    outcomes: Iterable[Outcome],
    problems: list[Problem],
    options: Comparisons,
    title: str,
) -> None:
    """Write summary.md and report.html into a folder.

    The page needs neither a network nor other files. Plots need matplotlib; without it the page has
    a message in their place.

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
    parts = _parts(evaluation, options)
    write_text(out / "report.html", page.page(title, body(evaluation, problems, parts)))


def body(
    evaluation: Passes[Any],
    problems: list[Problem],
    parts: Iterable[str],
    meanings: Mapping[str, str] = page.GLOSSARY,
) -> str:
    """Return a report as HTML: a summary of the run, its parts, the glossary, and the problems."""
    return "\n".join([*_opening(evaluation, problems), *parts, *_closing(meanings, problems)])


def _opening(evaluation: Passes[Any], problems: list[Problem]) -> Iterable[str]:
    yield f"<p>{escape(report_sections.run_summary(evaluation))}</p>"
    if problems:
        count = count_noun(len(problems), "problem")
        yield f'<p class="alarm">{count}: see the <a href="#problems">list at the end</a>.</p>'
    if not plots.has_matplotlib():
        yield (
            '<p class="alarm">There are no plots, since matplotlib is not installed. Install it '
            "with <code>pip install 'motes[report]'</code> and make the report again.</p>"
        )


def _closing(meanings: Mapping[str, str], problems: list[Problem]) -> Iterable[str]:
    yield page.section("What the numbers mean", page.glossary(meanings))
    if problems:
        yield page.section(
            "Problems", page.table(report_sections.problem_table(problems)), "problems"
        )


def _parts(evaluation: Evaluation, options: Comparisons) -> Iterable[str]:
    for protocol in evaluation.protocols:
        yield page.section(
            report_sections.title(evaluation, protocol),
            page.table(report_sections.overall(evaluation, protocol)),
        )
        if protocol != "reset":
            yield _plots(evaluation, protocol)
        if protocol == "robust":
            yield _auc_distribution(evaluation)
            table = report_sections.per_view(evaluation)
            yield f"<h3>{escape(table.title)}</h3>{page.table(table)}"
        if len(evaluation.trackers) > 1:
            compared = report_sections.comparisons(evaluation, protocol)
            yield f"<h3>{escape(compared.title)}</h3>{page.table(compared)}"
        if options.folds:
            table = cross_validation.choices(
                evaluation, protocol, options.candidates, options.folds
            )
            yield f"<h3>{escape(table.title)}</h3>{page.table(table)}"
    if evaluation.protocols:
        yield from _first_protocol_parts(evaluation, evaluation.protocols[0], options.peer)
    if "ope" in evaluation.protocols:
        yield page.section("First failures", _failures(evaluation))
    if options.reference is not None:
        table = report_sections.reference(evaluation, options.reference)
        yield page.section(table.title, page.table(table, column_tints(len(evaluation.trackers))))
    for protocol in evaluation.protocols:
        table = report_sections.details(evaluation, protocol)
        yield collapsible(f"{table.title}: {report_sections.title(evaluation, protocol)}", table)


def _first_protocol_parts(evaluation: Evaluation, protocol: str, peer: str) -> Iterable[str]:
    """Yield the parts that the page has only for the first protocol."""
    suffix = "" if len(evaluation.protocols) == 1 else f" ({protocol})"
    for table, tint in (
        (
            report_sections.per_sequence(evaluation, protocol),
            column_tints(len(evaluation.trackers)),
        ),
        (report_sections.times(evaluation, protocol), lambda row, _: tracker_tint(row)),
        (speed_ratios(evaluation, protocol, peer), page.no_tint),
        (report_sections.lost_status(evaluation, protocol), page.no_tint),
        (report_sections.recovery(evaluation, protocol), page.no_tint),
    ):
        if table.rows:
            yield page.section(table.title + suffix, page.table(table, tint))
    yield page.section("Calibration of the confidence" + suffix, _diagrams(evaluation, protocol))


def tracker_tint(tracker: int) -> str:
    """Return the color of a tracker's bars."""
    return plots.style(tracker)[0] + "4d"


def collapsible(title: str, table: Table) -> str:
    """Return a table that opens with a click on its title."""
    return f"<details><summary>{escape(title)}</summary>{page.table(table)}</details>"


def column_tints(trackers: int) -> Callable[[int, int], str]:
    """Return the bar colors of a table with a column for each tracker, and perhaps more columns."""
    return lambda row, column: (
        tracker_tint(column - 1) if column <= trackers else page.no_tint(row, column)
    )


def _plots(evaluation: Evaluation, protocol: str) -> str:
    """Return the success and precision plots of a protocol."""
    success = plot(
        evaluation, protocol, success_curve, metrics.THRESHOLDS, np.mean,
        ("Success", "overlap threshold (IoU)", "share of frames above it", "AUC"),
    )  # fmt: skip
    precision = plot(
        evaluation, protocol, precision_curve, metrics.PIXELS.astype(float), lambda y: float(y[20]),
        ("Precision", "distance threshold (pixels)", "share of frames within it", "at 20 pixels"),
    )  # fmt: skip
    return f'<div class="plots">{success}{precision}</div>'


def plot(
    evaluation: Passes[Any],
    protocol: str,
    quantity: Callable[[Any], Floats],
    x: Floats,
    summarize: Callable[[Floats], float],
    labels: tuple[str, str, str, str],
) -> str:
    """Return a figure with a line for each tracker, and a legend with a number for each line.

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
    return _line_figure(evaluation.trackers, protocol, x, lines, numbers, labels)


def _auc_distribution(evaluation: Evaluation) -> str:
    """Return a figure of the distribution of AUC over the passes of `robust`."""
    x, lines, numbers = np.linspace(0, 1, 101), {}, {}
    for i, tracker in enumerate(evaluation.trackers):
        values = evaluation.aucs(tracker, "robust")
        if values.size:
            lines[i] = np.quantile(values, x)
            numbers[i] = evaluation.worst_tenth(tracker, "robust").mean
    labels = ("Spread", "share of passes, the worst first", "AUC of a pass", "worst tenth")
    figure = _line_figure(evaluation.trackers, "robust", x, lines, numbers, labels)
    return f'<div class="plots">{figure}</div>'


def _line_figure(
    trackers: list[str],
    protocol: str,
    x: Floats,
    lines: dict[int, Floats],
    numbers: dict[int, float],
    labels: tuple[str, str, str, str],
) -> str:
    """Return a figure with a line and a number for each tracker; see `plot`."""
    title, horizontal, vertical, measured = labels
    if not lines or not plots.has_matplotlib():
        return ""
    legend = "".join(
        f"<li>{plots.swatch(i)}{escape(trackers[i])}: {numbers[i]:.3f}</li>"
        for i in sorted(lines, key=lambda i: -numbers[i])
    )
    drawn = plots.curves(f"{title.lower()}-{protocol}", x, lines, (horizontal, vertical))
    return (
        f"<figure><h3>{title}</h3>{drawn}<figcaption>{measured}:"
        f'<ul class="legend">{legend}</ul></figcaption></figure>\n'
    )


def _diagrams(evaluation: Evaluation, protocol: str) -> str:
    """Return the reliability diagrams of the trackers that give a confidence."""
    figures, silent = [], []
    for i, tracker in enumerate(evaluation.trackers):
        found = evaluation.reliability(tracker, protocol)
        if found is None:
            silent.append(tracker)
        elif plots.has_matplotlib():
            error = number(evaluation.calibration(tracker, protocol)).text
            figures.append(
                f"<figure>{plots.diagram(f'reliability-{i}', i, found)}<figcaption>"
                f"<strong>{escape(tracker)}</strong>: ECE {error}, {found.frames.sum()} frames"
                f"</figcaption></figure>\n"
            )
    parts = []
    if figures:
        parts.append(
            '<p class="note">A bar and a dot for each tenth of confidence: the share of correct '
            "frames (IoU above 0.5). On the dashed line, the confidence equals that share; below "
            "it, the confidence is too high. The lower plot shows the number of frames.</p>"
            f'<div class="plots diagrams">{"".join(figures)}</div>'
        )
    if silent:
        parts.append(f'<p class="note">Without a confidence: {escape(", ".join(silent))}.</p>')
    return "".join(parts)


def _failures(evaluation: Evaluation) -> str:
    """Return images of frames in which trackers began to fail."""
    found = failures.failures(evaluation)
    chosen = failures.choose(found)
    drawn, reasons = failures.draw(chosen)
    parts = [
        f'<p class="note">The first frame from which the IoU stays below 0.1 for at least '
        f"{failures.MIN_FAILURE_FRAMES} frames, in one pass with the lowest seed: "
        f"{count_noun(len(found), 'failure')}, {len(drawn)} shown. "
        '<span class="truth"></span> truth, <span class="estimate"></span> estimate.</p>'
    ]
    parts += [f'<p class="alarm">{escape(reason)}</p>' for reason in reasons]
    parts.append(f'<div class="pictures">{"".join(map(_picture, drawn))}</div>')
    return "\n".join(parts)


def _picture(picture: failures.Picture) -> str:
    failure = picture.failure
    confidence = "none" if math.isnan(failure.confidence) else f"{failure.confidence:.2f}"
    lost = "yes" if failure.lost else "no"
    caption = escape(
        f"{failure.sequence.name}, {failure.tracker}, frame {failure.frame}: "
        f"confidence {confidence}, reported lost: {lost}"
        + ("" if np.isfinite(failure.estimate).all() else ", no estimate")
    )
    return (
        f'<figure><img width="{picture.width}" height="{picture.height}" loading="lazy" '
        f'alt="{caption}" src="data:image/jpeg;base64,{base64.b64encode(picture.jpeg).decode()}">'
        f"<figcaption>{caption}</figcaption></figure>\n"
    )
