"""How many reports a second cameras may send, and how long one takes, as cameras become more.

    PYTHONPATH=fleet/tests python benchmarks/handover.py

Cameras are simulated: rooms in a grid, each the neighbor of the rooms beside it, and people who
walk through. Rates are those of one core: seconds of the processor that updates and arrivals take.
Latency is measured by feeding the reports at half of the highest rate, at random moments (a Poisson
process), to a queue that one core serves: a report waits for those before it, then takes its time.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from motes.core.types import Floats
from motes_fleet.cameras.reidentification import CrossCameraAssociation
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number
from simulated_cameras import Building, Simulation

COUNTS = 10, 32, 100, 316, 1000, 3162
SECONDS = 8.0
"""Of the simulation: people come back to each other's rooms, and the first are forgotten."""


def building_of(cameras: int) -> Building:
    """Return a building with about so many cameras, one in each room."""
    rows = max(round(cameras**0.5), 1)
    return Building(rows, max(round(cameras / rows), 1))


def times(building: Building, seconds: float, people: float) -> Floats:
    """Return the processor's seconds of each report."""
    association = CrossCameraAssociation(building.rig())
    taken = []
    for report in Simulation(building, seconds, people).reports():
        begun = time.process_time()
        association.update(report)
        association.arrivals(report.camera, report.time)
        taken.append(time.process_time() - begun)
    return np.array(taken)


def waits(taken: Floats, load: float, rng: np.random.Generator) -> Floats:
    """Return the seconds from the arrival of each report to its end, with one core at a load."""
    arrivals = np.cumsum(rng.exponential(taken.mean() / load, len(taken)))
    ends, end = [], 0.0
    for arrival, duration in zip(arrivals.tolist(), taken.tolist(), strict=True):
        end = max(end, arrival) + duration
        ends.append(end)
    latency: Floats = np.array(ends) - arrivals
    return latency


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cameras", type=int, nargs="*", default=COUNTS)
    parser.add_argument("--people", type=float, default=1.0)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--plot")
    options = parser.parse_args()
    times(building_of(9), options.seconds, 3.0)  # imports what it needs
    rows, lines, rng = [], list[Row](), np.random.default_rng(0)
    for cameras in options.cameras:
        building = building_of(cameras)
        runs = [times(building, options.seconds, options.people) for _ in range(options.repeats)]
        rates = sorted(1 / run.mean() for run in runs)
        latency = 1e3 * np.concatenate([waits(run, 0.5, rng) for run in runs])
        half = np.median(latency), np.quantile(latency, 0.99)
        count = building.rows * building.columns
        middle = rates[len(rates) // 2]
        rate = f"{middle:,.0f} ({rates[0]:,.0f} to {rates[-1]:,.0f})"
        lines.append((Cell(f"{count:,}"), Cell(rate), number(half[0], 2), number(half[1], 1)))
        rows.append((count, middle))
    note = ""
    if len(rows) > 1:
        counts, rates = np.log(np.array(rows)).T
        power = np.polyfit(counts, -rates, 1)[0]
        note = f"The time for a report grows with the cameras to the power {power:.2f}."
        if options.plot:
            _plot(options.plot, rows, power)
    head = "cameras", "reports a second", "ms at half of it, median", "ms, 99 %"
    print(markdown.table(Table("Reports of simulated cameras", head, lines, note=note)))


def _plot(name: str, rows: list[tuple[int, float]], power: float) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 3.2), layout="constrained")
    axes = figure.add_subplot()
    axes.loglog(*zip(*[(count, 1e6 / rate) for count, rate in rows], strict=True), "o-")
    axes.set_xlabel("cameras")
    axes.set_ylabel("µs of one core for a report")
    axes.set_ylim(10, 1000)
    axes.set_title(f"power {power:.2f}")
    axes.grid(which="both", alpha=0.3)
    figure.savefig(name, dpi=110)


if __name__ == "__main__":
    main()
