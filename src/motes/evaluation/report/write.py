"""The report of an evaluation, for people: summary.md, and report.html with plots and pictures."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Iterable, Mapping
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motes.evaluation.aggregate import Evaluation, Passes, precision_curve, success_curve
from motes.evaluation.datasets.sot import Problem
from motes.evaluation.metrics import sot as metrics
from motes.evaluation.report import cross_validation, failures, plots
from motes.evaluation.report import html as page
from motes.evaluation.report import sections as report_sections
from motes.evaluation.report.markdown import summary
from motes.evaluation.report.speed_ratio import Comparisons, speed_ratios
from motes.evaluation.report.tables import Table, counted, number
from motes.evaluation.scores import Outcome, write_text

Floats = NDArray[np.float64]


def write_report(
    out: Path,
    outcomes: Iterable[Outcome],
    problems: list[Problem],
    wanted: Comparisons,
    title: str,
) -> None:
    """Write summary.md and report.html into a folder.

    The page needs neither a network nor other files. Plots need matplotlib; without it the page
    says so in their place.

    Parameters
    ----------
    out
        The folder.
    outcomes
        Of all passes; the others are compared with the tracker of the first one.
    problems
        What went wrong; passes that failed are added.
    wanted
        What is set beside their numbers.
    title
        For people.

    Raises
    ------
    FormatError
        If a file cannot be written.
    """
    evaluation = Evaluation(outcomes)
    problems = report_sections.problems(problems, evaluation.outcomes)
    write_text(out / "summary.md", summary(evaluation, problems, wanted, title))
    parts = _parts(evaluation, wanted)
    write_text(out / "report.html", page.page(title, body(evaluation, problems, parts)))


def body(
    evaluation: Passes[Any],
    problems: list[Problem],
    parts: Iterable[str],
    meanings: Mapping[str, str] = page.GLOSSARY,
) -> str:
    """Return a report as HTML: what was run, its parts, what numbers mean, and what went wrong."""
    return "\n".join([*_opening(evaluation, problems), *parts, *_closing(meanings, problems)])


def _opening(evaluation: Passes[Any], problems: list[Problem]) -> Iterable[str]:
    yield f"<p>{escape(report_sections.run_summary(evaluation))}</p>"
    if problems:
        count = counted(len(problems), "problem")
        yield f'<p class="alarm">{count}: see the <a href="#problems">list at the end</a>.</p>'
    if not plots.available():
        yield (
            '<p class="alarm">There are no plots, as matplotlib is not installed. Install it with '
            "<code>pip install 'motes[report]'</code> and make the report again.</p>"
        )


def _closing(meanings: Mapping[str, str], problems: list[Problem]) -> Iterable[str]:
    yield page.headed("What the numbers mean", page.glossary(meanings))
    if problems:
        yield page.headed(
            "Problems", page.table(report_sections.problem_table(problems)), "problems"
        )


def _parts(evaluation: Evaluation, wanted: Comparisons) -> Iterable[str]:
    for protocol in evaluation.protocols:
        yield page.headed(
            report_sections.title(evaluation, protocol),
            page.table(report_sections.overall(evaluation, protocol)),
        )
        if protocol != "reset":
            yield _plots(evaluation, protocol)
        if protocol == "robust":
            yield _spread(evaluation)
            table = report_sections.per_view(evaluation)
            yield f"<h3>{escape(table.title)}</h3>{page.table(table)}"
        if len(evaluation.trackers) > 1:
            compared = report_sections.comparisons(evaluation, protocol)
            yield f"<h3>{escape(compared.title)}</h3>{page.table(compared)}"
        if wanted.folds:
            table = cross_validation.choices(evaluation, protocol, wanted.candidates, wanted.folds)
            yield f"<h3>{escape(table.title)}</h3>{page.table(table)}"
    if evaluation.protocols:
        yield from _closer(evaluation, evaluation.protocols[0], wanted.peer)
    if "ope" in evaluation.protocols:
        yield page.headed("Where they fail", _failures(evaluation))
    if wanted.reference is not None:
        table = report_sections.reference(evaluation, wanted.reference)
        yield page.headed(table.title, page.table(table, column_tints(len(evaluation.trackers))))
    for protocol in evaluation.protocols:
        table = report_sections.details(evaluation, protocol)
        yield folded(f"{table.title}: {report_sections.title(evaluation, protocol)}", table)


def _closer(evaluation: Evaluation, protocol: str, peer: str) -> Iterable[str]:
    """Yield what the page shows of a single protocol, the first one."""
    aside = "" if len(evaluation.protocols) == 1 else f" ({protocol})"
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
            yield page.headed(table.title + aside, page.table(table, tint))
    yield page.headed("How honest is the confidence?" + aside, _diagrams(evaluation, protocol))


def tracker_tint(tracker: int) -> str:
    """Return the color of a tracker's bars."""
    return plots.style(tracker)[0] + "4d"


def folded(title: str, table: Table) -> str:
    """Return a table that is seen after a click on its title."""
    return f"<details><summary>{escape(title)}</summary>{page.table(table)}</details>"


def column_tints(trackers: int) -> Callable[[int, int], str]:
    """Return the tints of a table with a column for each tracker, and maybe more."""
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
    of: Callable[[Any], Floats],
    x: Floats,
    worth: Callable[[Floats], float],
    words: tuple[str, str, str, str],
) -> str:
    """Return a figure with a line for each tracker, and a legend with what the lines are worth."""
    lines = {}
    for i, tracker in enumerate(evaluation.trackers):
        curves = evaluation.per_seed(tracker, protocol, of)
        if known := [curve for curve in curves if np.isfinite(curve).all()]:
            lines[i] = np.mean(known, axis=0)
    worths = {i: worth(line) for i, line in lines.items()}
    return _drawn(evaluation.trackers, protocol, x, lines, worths, words)


def _spread(evaluation: Evaluation) -> str:
    """Return the figure of how the AUC is spread over the passes of `robust`."""
    x, lines, worths = np.linspace(0, 1, 101), {}, {}
    for i, tracker in enumerate(evaluation.trackers):
        values = evaluation.aucs(tracker, "robust")
        if values.size:
            lines[i] = np.quantile(values, x)
            worths[i] = evaluation.worst_tenth(tracker, "robust").mean
    words = ("Spread", "share of passes, the worst first", "AUC of a pass", "worst tenth")
    figure = _drawn(evaluation.trackers, "robust", x, lines, worths, words)
    return f'<div class="plots">{figure}</div>'


def _drawn(
    trackers: list[str],
    protocol: str,
    x: Floats,
    lines: dict[int, Floats],
    worths: dict[int, float],
    words: tuple[str, str, str, str],
) -> str:
    """Return a figure with a line for each tracker; as `plot` does."""
    title, horizontal, vertical, measured = words
    if not lines or not plots.available():
        return ""
    legend = "".join(
        f"<li>{plots.swatch(i)}{escape(trackers[i])}: {worths[i]:.3f}</li>"
        for i in sorted(lines, key=lambda i: -worths[i])
    )
    drawn = plots.curves(f"{title.lower()}-{protocol}", x, lines, (horizontal, vertical))
    return (
        f"<figure><h3>{title}</h3>{drawn}<figcaption>{measured}:"
        f'<ul class="legend">{legend}</ul></figcaption></figure>\n'
    )


def _diagrams(evaluation: Evaluation, protocol: str) -> str:
    """Return the reliability diagrams of the trackers that have a confidence."""
    figures, silent = [], []
    for i, tracker in enumerate(evaluation.trackers):
        found = evaluation.reliability(tracker, protocol)
        if found is None:
            silent.append(tracker)
        elif plots.available():
            error = number(evaluation.calibration(tracker, protocol)).text
            figures.append(
                f"<figure>{plots.diagram(f'reliability-{i}', i, found)}<figcaption>"
                f"<strong>{escape(tracker)}</strong>: ECE {error}, {found.frames.sum()} frames"
                f"</figcaption></figure>\n"
            )
    parts = []
    if figures:
        parts.append(
            '<p class="note">A bar and a dot for each tenth of confidence: the share of frames '
            "that were right (IoU above 0.5). On the dashed line, confidence is what it says; "
            "below, the tracker is too sure. Under it, the number of frames.</p>"
            f'<div class="plots diagrams">{"".join(figures)}</div>'
        )
    if silent:
        parts.append(f'<p class="note">Without a confidence: {escape(", ".join(silent))}.</p>')
    return "".join(parts)


def _failures(evaluation: Evaluation) -> str:
    """Return pictures of frames in which trackers began to fail."""
    found = failures.failures(evaluation)
    chosen = failures.choose(found)
    drawn, reasons = failures.draw(chosen)
    parts = [
        f'<p class="note">The first frame from which the IoU stays below 0.1 for at least '
        f"{failures.FRAMES} frames, in one pass with the lowest seed: "
        f"{counted(len(found), 'failure')}, {len(drawn)} shown. "
        '<span class="truth"></span> truth, <span class="estimate"></span> estimate.</p>'
    ]
    parts += [f'<p class="alarm">{escape(reason)}</p>' for reason in reasons]
    parts.append(f'<div class="pictures">{"".join(map(_picture, drawn))}</div>')
    return "\n".join(parts)


def _picture(picture: failures.Picture) -> str:
    failure = picture.failure
    sure = "none" if math.isnan(failure.confidence) else f"{failure.confidence:.2f}"
    said = "yes" if failure.lost else "no"
    caption = escape(
        f"{failure.sequence.name}, {failure.tracker}, frame {failure.frame}: "
        f"confidence {sure}, said lost: {said}"
        + ("" if np.isfinite(failure.estimate).all() else ", no estimate")
    )
    return (
        f'<figure><img width="{picture.width}" height="{picture.height}" loading="lazy" '
        f'alt="{caption}" src="data:image/jpeg;base64,{base64.b64encode(picture.jpeg).decode()}">'
        f"<figcaption>{caption}</figcaption></figure>\n"
    )
