"""The optional parts of a report, and the table of speed ratios."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motes_lab.aggregate import Evaluation
from motes_lab.metrics import sot as metrics
from motes_lab.report.reference import Reference
from motes_lab.report.tables import Cell, Table, three_digits

PEER = "cv2:csrt"
"""The tracker whose time is the reference of speed ratios, by default."""


class Comparisons(NamedTuple):
    """The optional parts of a report.

    Attributes
    ----------
    reference
        Published results, or None.
    peer
        The tracker whose time is the reference of speed ratios, if it took part.
    """

    reference: Reference | None = None
    peer: str = PEER


def speed_ratios(evaluation: Evaluation, protocol: str, peer: str) -> Table:
    """Return a table of the trackers' speed relative to a peer, with a row for each sequence.

    It has no rows if the peer, or any other tracker, did not take part.
    """
    others = [tracker for tracker in evaluation.trackers if tracker != peer]
    title = f"Speed relative to {peer}"
    if peer not in evaluation.trackers or not others:
        return Table(title, (), [])

    def medians(tracker: str) -> list[float]:
        seconds = (evaluation.seconds(tracker, protocol, [name]) for name in evaluation.sequences)
        return [metrics.time_quantiles(each)[0] for each in seconds]

    with np.errstate(divide="ignore", invalid="ignore"):  # a time may be too short to be measured
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
        f"The median time of an update of {peer}, divided by that of the tracker. Above 1, the "
        f"tracker is faster. For sequences that both finished.",
    )
