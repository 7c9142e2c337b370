"""Where the time of one update of the default tracker goes.

    python benchmarks/default_breakdown.py

Each part is timed in the real functions in the midst of real updates, less what other parts take
in it; the frames are 640x480, the target is 60x100.
"""

from __future__ import annotations

import statistics
import time
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from typing import Any
from unittest.mock import patch

from motes import Tracker
from motes.cues.color import Posterior
from motes.cues.confined_filter import ConfinedFilter
from motes.cues.correlation_filter import Correlation, ScaleFilter
from motes.cues.search_window import SampleGrid
from motes.sot.discriminative import placing, prediction, tracker
from motes.sot.discriminative.prediction import Light
from motes.sot.discriminative.tracker import Discriminative
from motes.synthetic.clips import still
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Table, number
from motes_lab.speed.measure import MAIN, SIZE, Film, timed

FRAMES, ROUNDS = 31, 10
PARTS = {
    "predict: small picture": (tracker, "small_picture"),
    "predict: shift of the camera": (prediction, "predictions"),
    "light: measured": (Light, "followed"),
    "place: window sampled": (SampleGrid, "sample_window"),
    "place: gradient and color cells, transform": (Correlation, "spectra"),
    "place: responses of both filters": (Correlation, "responses"),
    "place: color posterior": (Posterior, "integral"),
    "place: particles, evidence": (placing, "localize"),
    "wide: window, features, transform": (ConfinedFilter, "_spectra"),
    "wide: response": (ConfinedFilter, "view"),
    "wide: learned": (ConfinedFilter, "_solve"),
    "size: sampled, cells, transform": (ScaleFilter, "spectra"),
    "size: weighed": (tracker, "estimated"),
    "learn: filter": (Correlation, "updated"),
    "learn: colors": (Posterior, "updated"),
    "learn: size": (ScaleFilter, "updated"),
    "report: mean, covariance": (tracker, "report"),
    "rest: Python between all these": (Discriminative, "step"),
}


class Clock:
    """Times functions that call one another: each by what is its own."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = defaultdict(float)
        self._open = [0.0]

    def timing(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that is timed."""

        def called(*arguments: Any, **named: Any) -> Any:
            self._open.append(0.0)
            start = time.perf_counter()
            result = function(*arguments, **named)
            taken = time.perf_counter() - start
            self.seconds[part] += taken - self._open.pop()
            self._open[-1] += taken
            return result

        return called


def measure(film: Film) -> dict[str, float]:
    """Return the microseconds of each part in an update."""
    clock, follower = Clock(), Tracker(seed=0)
    follower.init(film.frames[0], film.regions[0])
    with ExitStack() as stack:
        for part, (owner, name) in PARTS.items():
            timing = clock.timing(part, getattr(owner, name))
            stack.enter_context(patch.object(owner, name, timing))
        timed(follower.update, film.frames[1:])
    return {part: 1e6 * clock.seconds[part] / (len(film.frames) - 1) for part in PARTS}


def main() -> None:
    """Print the table."""
    film = Film.of(still(SIZE, target=MAIN, frames=FRAMES))
    rounds = [measure(film) for _ in range(ROUNDS)]
    medians = {part: statistics.median(each[part] for each in rounds[1:]) for part in PARTS}
    rows: list[tuple[Cell, ...]] = [
        (Cell(part), number(value, 0)) for part, value in medians.items()
    ]
    foot = ((Cell("all"), number(sum(medians.values()), 0)),)
    print(markdown.table(Table("Microseconds of an update", ("part", "default"), rows, foot)))


if __name__ == "__main__":
    main()
