"""What a report sets beside the trackers' own numbers, if somebody asks for it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motes.evaluation.aggregate import Evaluation
from motes.evaluation.metrics import sot as metrics
from motes.evaluation.report.reference import Reference
from motes.evaluation.report.tables import Cell, Table, three_digits

PEER = "cv2:csrt"
"""Whose time those of the others are set against, unless somebody says otherwise."""


class Comparisons(NamedTuple):
    """What a report sets beside the trackers' own numbers.

    Attributes
    ----------
    reference
        Other people's results; None for none.
    peer
        The tracker whose time those of the others are set against, if it took part.
    candidates, folds
        Among whom is chosen on all but one of so many folds; 0 for no choice.
    """

    reference: Reference | None = None
    peer: str = PEER
    candidates: tuple[str, ...] = ()
    folds: int = 0


def speed_ratios(evaluation: Evaluation, protocol: str, peer: str) -> Table:
    """Return a table with a row for each sequence: how many times as fast as a peer trackers are.

    Without rows if it did not take part, or nobody else did.
    """
    others = [tracker for tracker in evaluation.trackers if tracker != peer]
    title = f"How many times as fast as {peer}"
    if peer not in evaluation.trackers or not others:
        return Table(title, (), [])

    def medians(tracker: str) -> list[float]:
        seconds = (evaluation.seconds(tracker, protocol, [name]) for name in evaluation.sequences)
        return [metrics.time_quantiles(each)[0] for each in seconds]

    with np.errstate(divide="ignore", invalid="ignore"):  # a time too short to be measured
        ratios = np.array(medians(peer)) / np.array([medians(other) for other in others])
    least = [min(row[np.isfinite(row)], default=np.nan) for row in ratios]
    return Table(
        title,
        ("sequence", *others),
        [
            (Cell(sequence), *map(three_digits, column))
            for sequence, column in zip(evaluation.sequences, ratios.T, strict=True)
        ],
        ((Cell("minimum"), *map(three_digits, least)),),
        f"The median time of an update of {peer}, divided by the tracker's: above 1, the tracker "
        f"is the faster one. For sequences that both finished.",
    )
