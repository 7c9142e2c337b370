"""`motes-lab compare`: paired differences of trackers and versions, and a choice's optimism."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from motes_lab.experiment import ResultOptions
from motes_lab.inputs import RUN
from motes_lab.report.comparison import PEER, comparison, default_reference
from motes_lab.saved_scores import SavedScores

app = App(name="compare", help_format="plaintext")


@app.default
def compare(
    run: Path,
    /,
    *others: Path,
    reference: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help=f"Tracker that the others are compared with; by default {PEER}, or the first one "
            "where a run does not have it.",
        ),
    ] = None,
    protocol: Annotated[
        str | None, Parameter(group=RUN, help="Protocol; by default the first one of each run.")
    ] = None,
    column: Annotated[
        str | None,
        Parameter(
            group=RUN,
            help="Column of results.csv, such as precision_20; by default the one by which the "
            "protocol ranks trackers.",
        ),
    ] = None,
    results: ResultOptions = ResultOptions(),
) -> int:
    """Compare evaluations, with intervals over sequences.

    Each tracker is compared with the reference in each run. In a second run on the same sequences,
    each is compared with itself in the first run: another version. With a second run on other
    sequences, the optimism is measured: how much of a tracker's lead over the reference on the
    first set, on which it may have been tuned, is not there on the second.

    Parameters
    ----------
    run
        The folder of an evaluation by motes-lab evaluate.
    others
        The folders of others.
    """
    runs = [SavedScores.load(folder, protocol, column) for folder in (run, *others)]
    return results.show("compare", comparison(runs, reference or default_reference(runs)))
