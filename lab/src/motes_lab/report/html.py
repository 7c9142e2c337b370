"""The HTML of reports: page, sections, tables and glossary."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from html import escape

from motes_lab.report.tables import NO_VALUE, Cell, Row, Table

STYLE = """
:root { color-scheme: light dark; --ink: #1d2125; --soft: #5b646d; --paper: #ffffff;
  --panel: #f5f6f8; --grid: #d9dde1; --best: #0b6e4f; --alarm: #b3261e; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8ea; --soft: #a3abb3; --paper: #16191c;
  --panel: #1f2327; --grid: #3a4147; --best: #5fd3a8; --alarm: #ff8a80; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 1180px; padding: 1.5rem 1rem 4rem; background: var(--paper);
  color: var(--ink); font: 15px/1.5 system-ui, "Segoe UI", Helvetica, Arial, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .4rem; }
h2 { font-size: 1.25rem; margin: 2.6rem 0 .6rem; padding-top: .9rem;
  border-top: 1px solid var(--grid); }
h3 { font-size: 1rem; margin: 1.4rem 0 .4rem; }
p { max-width: 75ch; margin: .4rem 0; }
a { color: inherit; }
.note, figcaption { color: var(--soft); font-size: .88rem; }
.alarm { color: var(--alarm); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .9rem; }
th, td { padding: .28rem .6rem; text-align: left; vertical-align: baseline; white-space: nowrap;
  border-bottom: 1px solid var(--grid); }
td.wide { white-space: normal; overflow-wrap: anywhere; min-width: 14rem; }
thead th { vertical-align: bottom; border-bottom: 2px solid var(--grid); }
tfoot th, tfoot td { font-weight: 600; border-top: 2px solid var(--grid); }
tbody th { font-weight: 500; }
th:first-child { position: sticky; left: 0; background: var(--paper); z-index: 1; }
td.number, th.number { text-align: right; }
td.bar { min-width: 5.6rem; background: linear-gradient(to right, var(--tint) var(--length),
  transparent var(--length)) no-repeat center / 100% 76%; text-align: left; }
td.best { color: var(--best); font-weight: 700; }
th button { background: none; border: 0; padding: 0; margin: 0; width: auto; cursor: pointer;
  font: inherit; font-weight: 600; color: inherit; text-align: inherit; white-space: normal; }
th button:focus-visible { outline: 2px solid var(--ink); outline-offset: 2px; }
th button::after { content: "\\2195"; opacity: .35; padding-left: .3em; }
th[aria-sort=ascending] button::after { content: "\\2191"; opacity: 1; }
th[aria-sort=descending] button::after { content: "\\2193"; opacity: 1; }
.plots { display: flex; flex-wrap: wrap; gap: 1.2rem; }
.plots figure { flex: 1 1 420px; max-width: 560px; }
.diagrams figure { flex: 0 1 250px; }
figure { margin: 0; }
figure svg:not(.swatch) { width: 100%; height: auto; display: block; }
.swatch { width: 32px; height: 6px; vertical-align: middle; margin-right: .5em; }
ul.legend { list-style: none; margin: .2rem 0 0; padding: 0; columns: 2 14rem; font-size: .9rem; }
.legend li { overflow-wrap: anywhere; break-inside: avoid; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(270px, 1fr));
  gap: 1rem; align-items: start; }
.pictures img { width: 100%; height: auto; display: block; background: var(--panel); }
.pictures figcaption { overflow-wrap: anywhere; }
.truth, .estimate { display: inline-block; width: .9em; height: .9em; vertical-align: -.1em;
  border: 2px solid #3ce65a; background: #000; }
.estimate { border-color: #ff3c28; }
dl { max-width: 80ch; }
dt { font-weight: 600; }
dd { margin: 0 0 .5rem 1.2rem; }
summary { cursor: pointer; font-weight: 600; }
@media print { body { max-width: none; } details > * { display: block; } }
"""

SCRIPT = """
for (const button of document.querySelectorAll("th button")) {
  button.addEventListener("click", () => {
    const head = button.closest("th"), body = head.closest("table").tBodies[0];
    const value = row => {
      const cell = row.cells[head.cellIndex], number = cell.dataset.value;
      return number === undefined ? cell.textContent.trim() : Number(number);
    };
    const rows = Array.from(body.rows);
    const numeric = rows.some(row => typeof value(row) === "number");
    const order = head.getAttribute("aria-sort");
    const up = order ? order === "descending" : !numeric;
    rows.sort((one, other) => {
      const a = value(one), b = value(other);
      if (typeof a !== typeof b) return typeof a === "number" ? -1 : 1;  // missing numbers last
      const less = typeof a === "number" ? a - b : a.localeCompare(b, undefined, {numeric: true});
      return up ? less : -less;
    });
    for (const other of head.parentNode.cells) other.removeAttribute("aria-sort");
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    body.append(...rows);
  });
}
"""

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
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f"<h1>{escape(title)}</h1>\n{body}\n<script>{SCRIPT}</script>\n</body>\n</html>\n"
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
