"""Maggio et al., table 1 and figure 5: the variants of their tracker on sequences with truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from motes.output import charts
from motes_lab.adapters.registry import resolve
from motes_lab.aggregate import Evaluation, Mean
from motes_lab.datasets.sot import Problem
from motes_lab.datasets.sot import Sequence as Film
from motes_lab.finished_passes import finished_passes
from motes_lab.metrics.sot import Difference, paired_difference
from motes_lab.papers.result import Experiment, Result, over
from motes_lab.report import sections as report_sections
from motes_lab.report.tables import NO_VALUE, Cell, Row, Table, number
from motes_lab.scores import Outcome

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = {
    "C": "maggio:C",
    "O FOH": "maggio:O-FOH",
    "O ROH": "maggio:O-ROH",
    "C+O(SS) FOH": "maggio:C+O-SS-FOH",
    "C+O(SS) ROH": "maggio:C+O-SS-ROH",
    "C+O(A&SS) FOH": "maggio:C+O-A-SS-FOH",
    "C+O(A&SS) ROH": "maggio:C+O-A-SS-ROH",
}
"""The columns of table 1, and the presets of motes."""
FIXED_SCALE = {"C+O(A) FOH": "maggio:C+O-A-FOH", "C+O(A) ROH": "maggio:C+O-A-ROH"}
"""Additional variants in figure 5a."""
PRINTED = {"C+O(A&SS) ROH as printed": "maggio:printed"}
"""The preset with the paper's fusion to the letter."""

COLOR = COLUMNS["C"]

LT = "(LT)"
PAPER = {
    "P1": "0.535(LT) 0.932(LT) 0.513(LT) 0.322(LT) 0.190 0.294 0.183",
    "P2": "0.861(LT) 0.944(LT) 0.940(LT) 0.433(LT) 0.403(LT) 0.414(LT) 0.351(LT)",
    "P3": "0.457(LT) 0.896(LT) 0.828(LT) 0.333(LT) 0.304(LT) 0.339(LT) 0.268",
    "F1": "0.281 0.742(LT) 0.710(LT) 0.228 0.213 0.240 0.222",
    "F2": "0.397(LT) 0.633(LT) 0.519(LT) 0.376(LT) 0.337(LT) 0.355(LT) 0.320(LT)",
    "F3": "0.279 0.369 0.305 0.235 0.237 0.244 0.229",
    "V4": "0.249 0.845(LT) 0.844(LT) 0.275 0.322 0.253 0.239",
}
"""Table 1 as printed, by target."""


class Score(NamedTuple):
    """A column of table 1 in short.

    Attributes
    ----------
    od
        Mean over the sequences.
    lost
        Number of lost tracks.
    """

    od: Mean
    lost: Mean


def paper(column: str) -> Score | None:
    """Return the paper's score of a column of `COLUMNS`; None for a variant that is only drawn."""
    if column not in COLUMNS:
        return None
    cells = [row.split()[list(COLUMNS).index(column)] for row in PAPER.values()]
    od = np.mean([float(cell.removesuffix(LT)) for cell in cells])
    return Score(Mean(float(od)), Mean(sum(cell.endswith(LT) for cell in cells)))


class Standing(NamedTuple):
    """The results after a job.

    Attributes
    ----------
    evaluation
        All results so far.
    sequences
        The sequences that every tracker has finished, on which they can be compared.
    problems
        Failures so far.
    progress
        Number of finished jobs, as text.
    """

    evaluation: Evaluation
    sequences: list[str]
    problems: tuple[Problem, ...]
    progress: str

    def score(self, tracker: str) -> Score:
        """Return a tracker's score, with standard deviations over seeds."""
        od = self.evaluation.mean(tracker, "ope", "od", self.sequences)
        lost = self.evaluation.per_seed(tracker, "ope", report_sections.lost_track, self.sequences)
        return Score(od, over(lost * len(self.sequences)))

    def difference(self, tracker: str, other: str) -> Difference:
        """Return the difference of two trackers' OD, and its interval over sequences.

        The value of a sequence is the mean over seeds.
        """
        pairs = [
            [self.evaluation.mean(each, "ope", "od", [name]).mean for each in (tracker, other)]
            for name in self.sequences
        ]
        ours, theirs = np.array(pairs).T
        return paired_difference(np.random.default_rng(0), ours, theirs)


def evaluated(
    trackers: Sequence[str], films: Sequence[Film], seeds: int, workers: int
) -> Iterator[Standing]:
    """Run trackers over sequences in worker processes and yield the results after each job.

    Raises
    ------
    SourceError
        If no sequence can be opened.
    """
    entries, _ = resolve(trackers)
    for outcomes, problems, progress in finished_passes(Outcome, entries, films, seeds, workers):
        yield _standing(trackers, outcomes, problems, progress)


def _standing(
    trackers: Sequence[str], outcomes: list[Outcome], problems: list[Problem], progress: str
) -> Standing:
    evaluation = Evaluation(outcomes)
    finished = [
        set(evaluation.finished(tracker, "ope")) if tracker in evaluation.trackers else set()
        for tracker in trackers
    ]
    common = set.intersection(*finished)
    return Standing(
        evaluation,
        [name for name in evaluation.sequences if name in common],
        tuple(report_sections.problems(problems, evaluation.outcomes)),
        progress,
    )


def table1(films: Sequence[Film], seeds: int, workers: int) -> Experiment:
    """Yield table 1 for the sequences so far, and its means beside the paper's."""
    columns = COLUMNS | PRINTED
    for standing in evaluated([*columns.values()], films, seeds, workers):
        tables = {}
        if standing.sequences:
            tables = {"sequences": _sequences(standing), "means": _means(standing, columns)}
        yield Result(tables, None, standing.problems, standing.progress)


def _sequences(standing: Standing) -> Table:
    """Return the paper's table: each OD, with LT if most runs of a tracker lost the track."""
    rows: list[Row] = []
    for name in standing.sequences:
        cells = []
        for tracker in COLUMNS.values():
            od, lost = standing._replace(sequences=[name]).score(tracker)
            cells.append(f"{od.mean:.3f}{LT if lost.mean > 0.5 else ''}")
        rows.append((Cell(name), *map(Cell, cells)))
    for name, line in PAPER.items():
        rows.append((Cell(f"the paper's {name}"), *map(Cell, line.split())))
    note = f"Overlap distance, 0 to 1, mean over the seeds; {LT}: lost, with most of them."
    return Table("Accuracy on each sequence", ("sequence", *COLUMNS), rows, note=note)


def _means(standing: Standing, columns: dict[str, str]) -> Table:
    rows: list[Row] = []
    for column, tracker in columns.items():
        (od, lost), known = standing.score(tracker), paper(column)
        theirs = (number(known.od), number(known.lost, 0)) if known else (Cell(NO_VALUE),) * 2
        against = [Cell(NO_VALUE)] * 2
        if tracker != COLOR:
            mean, low, high = standing.difference(tracker, COLOR)
            between = f"{low:+.3f} to {high:+.3f}" if np.isfinite(low) else NO_VALUE
            against = [Cell(f"{mean:+.3f}", mean), Cell(between)]
        rows.append((Cell(column), number(od), number(lost, 1), *against, *theirs))
    ours = ("mean OD", f"tracks lost of {len(standing.sequences)}", "minus C", "95 % interval")
    head = ("features", *ours, "the paper's OD", "its lost of 7")
    note = (
        "Standard deviations are over the seeds. Minus C: the difference from color alone; its "
        "interval is a paired bootstrap over sequences."
    )
    return Table("All sequences", head, rows, note=note)


def figure5(films: Sequence[Film], seeds: int, workers: int) -> Experiment:
    """Yield figure 5, and its numbers beside the means of the paper's table 1."""
    columns = COLUMNS | FIXED_SCALE
    for standing in evaluated([*columns.values()], films, seeds, workers):
        tables = {"": _means(standing, columns)} if standing.sequences else {}
        draw = partial(_draw, standing, columns)
        yield Result(tables, draw, standing.problems, standing.progress)


def _draw(standing: Standing, columns: dict[str, str]) -> Figure:
    ods = {column: standing.score(tracker).od.mean for column, tracker in columns.items()}
    figure = charts.new_figure(3.6)
    left, right = figure.subplots(1, 2, sharey=True)
    _bars(left, "(a) color and orientation", ["C+O(A)", "C+O(SS)", "C+O(A&SS)"], ods)
    _bars(right, "(b) each alone, and both", ["O", "C", "C+O(A&SS)"], ods)
    left.set_ylabel("mean overlap distance")
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=9)
    return figure


def _bars(axes: Axes, title: str, groups: Sequence[str], ods: dict[str, float]) -> None:
    """Draw motes as bars and the paper as dashes; without orientation, both bars are the same."""
    charts.style_axes(axes, title, "", "")
    width = 0.38
    for shift, form, color in ((-0.5, "FOH", charts.BLUE), (0.5, "ROH", charts.VERMILION)):
        names = [group if group in ods else f"{group} {form}" for group in groups]
        places = np.arange(len(groups)) + shift * width
        axes.bar(places, [ods[name] for name in names], width, color=color, label=form)
        theirs = [known.od.mean if (known := paper(name)) else np.nan for name in names]
        label = "the paper's" if form == "ROH" else "_"  # only one of the two is in the legend
        low, high = places - width / 2, places + width / 2
        axes.hlines(theirs, low, high, color=charts.INK, linewidth=2, label=label)
    axes.set_xticks(np.arange(len(groups)), groups)
