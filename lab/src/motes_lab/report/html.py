"""The HTML of reports: page, sections, tables and glossary."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from html import escape
from importlib.resources import files

from motes_lab.report.tables import NO_VALUE, Cell, Row, Table

STYLE, SCRIPT = (
    files(__package__).joinpath(f"page.{form}").read_text("utf-8") for form in ("css", "js")
)

GLOSSARY = {
    "AUC": "Area under the success curve: the mean, over 21 thresholds from 0 to 1, of the share "
    "of frames whose overlap (IoU of the boxes) exceeds the threshold. Wu, Lim and Yang, Online "
    "object tracking: a benchmark, CVPR 2013. One pass (OPE) starts in the first frame with the "
    "target; perturbed starts (SRE) use a shifted or scaled box; perturbed times (TRE) start "
    "later.",
    "Precision at 20 px": "Share of frames in which the center is at most 20 pixels from the true "
    "one. The same source.",
    "OD, tracks lost": "Overlap distance of the ellipses, 1 - 2 TP / (|A| + |A true|) with their "
    "common area TP; a track is lost if OD exceeds 0.8 in any frame. Maggio, Smeraldi and "
    "Cavallaro, equation 11.",
    "Accuracy, robustness, failures": "A failure is a frame without any overlap; five frames later "
    "the tracker is restarted. Accuracy is the mean IoU between failures, without the first ten "
    "frames of each start; robustness is exp(-30 failures / frames). Kristan et al., The visual "
    "object tracking VOT challenges; Čehovin, Leonardis and Kristan, TIP 2016.",
    "Recall, precision and F1 of lost": "The losses that a tracker reports, compared with the "
    "truth: it should report a loss if the IoU is below 0.1, or there is no target.",
    "ECE": "Expected calibration error: the mean distance between the confidence and the share of "
    "frames with IoU above 0.5, over ten bins of confidence. Guo, Pleiss, Sun and Weinberger, ICML "
    "2017. Each pass counts equally, whatever its length.",
    "Losses, found again": "A loss is a frame with an IoU below 0.1 after one with 0.1 or more; it "
    "counts if the target is later present for 30 frames in a row. The target is found "
    "again if a later frame has an IoU above 0.5. Over the losses of all passes.",
    "Truth within 95 %": "Share of the frames with the target and status tracking in which the "
    "true center lies in the ellipse d' C^-1 d = 5.991 of the covariance C of the tracker's "
    "position: 0.95 if the covariance is right, less if it is too small. Over all frames.",
    "ms, updates per second": "Time inside the tracker, on one image that is already decoded.",
    "±": "Standard deviation over seeds of the mean over sequences. It is missing for a tracker "
    "that is not stochastic, or was run with one seed.",
}
"""The meaning of the numbers in a report."""


def page(title: str, body: str) -> str:
    """Return a page that needs no other file; the title is text, the body is HTML."""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n"
        f"<h1>{escape(title)}</h1>\n{body}\n<script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    )


def section(title: str, content: str, name: str = "") -> str:
    """Return a section with a title and an optional anchor for links; the content is HTML."""
    anchor = f' id="{name}"' if name else ""
    return f"<h2{anchor}>{escape(title)}</h2>\n{content}"


def glossary(meanings: Mapping[str, str] = GLOSSARY) -> str:
    """Return the meanings of the numbers, as HTML."""
    items = (f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in meanings.items())
    return "<dl>" + "".join(items) + "</dl>"


def no_tint(row: int, column: int) -> str:
    """Return the color of a bar that belongs to no tracker."""
    return "#8088904d"


def table(content: Table, tint: Callable[[int, int], str] = no_tint) -> str:
    """Return a table as HTML, which a click on the head of a column sorts; if empty, its note.

    `tint` gives the color of a bar from the numbers of its row and column.
    """
    note = f'<p class="note">{escape(content.note)}</p>' if content.note else ""
    if not content.rows:
        return note
    rows = (*content.rows, *content.foot)
    numeric = [
        any(row[j].value is not None or row[j].text == NO_VALUE for row in rows)
        for j in range(len(content.head))
    ]
    barred = [any(row[j].bar is not None for row in rows) for j in range(len(content.head))]
    kinds = [' class="number"' if n and not b else "" for n, b in zip(numeric, barred, strict=True)]
    head = "".join(
        f'<th scope="col"{kind}><button type="button">{escape(name)}</button></th>'
        for kind, name in zip(kinds, content.head, strict=True)
    )
    lines = [_row(row, numeric, partial(tint, i)) for i, row in enumerate(rows)]
    count = len(content.rows)
    body, foot = "\n".join(lines[:count]), "\n".join(lines[count:])
    return (
        f'<div class="scroll" role="region" tabindex="0" aria-label="{escape(content.title)}">'
        f"<table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>"
        + (f"\n<tfoot>\n{foot}\n</tfoot>" if foot else "")
        + f"</table></div>\n{note}"
    )


def _row(row: Row, numeric: list[bool], tint: Callable[[int], str]) -> str:
    first, *others = row
    cells = "".join(_cell(cell, numeric[j], tint(j)) for j, cell in enumerate(others, 1))
    return f'<tr><th scope="row">{escape(first.text)}</th>{cells}</tr>'


def _cell(cell: Cell, numeric: bool, tint: str) -> str:
    kinds = [
        *(["number"] if numeric else []),
        *(["bar"] if cell.bar is not None else []),
        *(["best"] if cell.best else []),
        *(["wide"] if len(cell.text) > 40 else []),
    ]
    value = "" if cell.value is None else f' data-value="{cell.value:.9g}"'
    length = "" if cell.bar is None else f' style="--length: {cell.bar:.1%}; --tint: {tint}"'
    kind = f' class="{" ".join(kinds)}"' if kinds else ""
    return f"<td{kind}{value}{length}>{escape(cell.text)}</td>"
