"""How soon the studio's page answers, and how many corrections a person needs in it: in Chromium.

    python benchmarks/studio_page.py speed              # start, seek, overlays, corrections
    python benchmarks/studio_page.py effort DATASET SEQUENCE ...

`speed` renders films: one of 10 minutes at 1920x1080 for `seek`, one at 1280x720 for the others.
All times are those of the page: until a picture is on the stage, or until all rows are results.
`effort` opens each sequence, draws its truth in the first frame, and tracks. Then it asks for the
next doubtful frame, draws the truth there, and waits for the smoothed rows, until 95 % of the
frames have an IoU of 0.7: as `motes-lab experiment effort`, but by pointer and keys.
"""

from __future__ import annotations

import random
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from motes.core.geometry import iou
from motes.core.types import Floats
from motes_lab.datasets.sot import load_dataset
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table, number

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import browsers
from browsers import START, Shown, browsing
from studio import render
from studios import Program

browsers.PATIENCE = 600_000  # a long film on a busy machine is no failure

RIGHT, ENOUGH = 0.7, 0.95
MOST = 60
"""Corrections after which a sequence is given up."""
SEEN = """import('/static/main.js').then(({ app }) => {
    window.seen = [];
    app.store.on(['overlays', 'picture'], ({ pictured, overlays }) => {
        if (overlays.get(1)?.has(pictured)) window.seen.push([pictured, performance.now()]);
    });
    window.painted = [];
    app.store.on(['picture'], ({ pictured }) => window.painted.push([pictured, performance.now()]));
})"""
JUMP = """(frame) => import('/static/main.js').then(({ app }) => new Promise((resolve) => {
    const begun = performance.now();
    const off = app.store.on(['pictured'], ({ pictured }) => {
        if (pictured === frame) requestAnimationFrame(() => {
            off();
            resolve(performance.now() - begun);
        });
    });
    app.player.go(frame);
}))"""


def timed(act: Callable[[], object]) -> float:
    """Return the seconds that something takes."""
    begun = time.perf_counter()
    act()
    return time.perf_counter() - begun


def speed(folder: Path) -> None:
    """Measure start, seek, overlays and corrections."""
    films = folder / "films"
    films.mkdir()
    render(films / "long.mp4", 15_000, (1920, 1080))
    render(films / "short.mp4", 300, (1280, 720))
    begun = time.perf_counter()
    program = Program(films, folder / "data")
    print(f"server listens after {time.perf_counter() - begun:.2f} s")
    try:
        with browsing() as browser:
            shown = Shown(browser, program.address)
            times = sorted(timed(lambda: reload(shown)) for _ in range(5))
            print(f"page usable after {statistics.median(times):.2f} s (median of 5)")
            seek(shown)
            shown.page.goto(program.address)
            follow(shown)
            shown.close()
    finally:
        program.close()


def reload(shown: Shown) -> None:
    """Load the first page again, and wait until its lists are there."""
    shown.page.reload()
    shown.until("s.films !== null && s.sessions !== null")


def seek(shown: Shown) -> None:
    """Print how long it takes until a random frame is on the stage."""
    print(f"long film opened after {timed(lambda: shown.open('long.mp4')):.2f} s")
    last, rng = int(shown.state("s.film.frames")) - 1, random.Random(0)
    times = sorted(float(shown.page.evaluate(JUMP, rng.randint(0, last))) for _ in range(100))
    print(f"seek: median {times[50]:.0f} ms, 95 % {times[95]:.0f} ms, most {times[-1]:.0f} ms")


def follow(shown: Shown) -> None:
    """Print the rate of overlays while tracking, and the time of a correction."""
    shown.open("short.mp4")
    shown.draw((640 - 60, 576 - 40), (640 + 60, 576 + 40))
    shown.page.evaluate(SEEN)
    took = timed(shown.track)
    for name, what in (("seen", "frames with their overlay"), ("painted", "pictures")):
        moments = dict(shown.page.evaluate(f"window.{name}"))
        span = (max(moments.values()) - min(moments.values())) / 1000
        print(f"tracking: {len(moments) / span:.1f} {what} a second, of {300 / took:.1f} tracked")
    for frame in (100, 200):
        shown.go(frame)
        shown.page.keyboard.press("k")
        shown.until(f"s.session.objects[0].keyframes.some(({{ frame }}) => frame === {frame})")
        shown.settle()
    shown.go(150)
    begun = time.perf_counter()
    shown.page.keyboard.press("k")
    shown.until("s.session.objects[0].keyframes.length === 4")
    shown.settle()
    print(f"correction of a stretch of 100 frames: {time.perf_counter() - begun:.2f} s")


def effort(dataset: Path, names: list[str], data: Path) -> None:
    """Print the corrections of each sequence."""
    program = Program(dataset, data)
    rates, rows = list[float](), list[Row]()
    try:
        with browsing() as browser:
            for name in names:
                ((sequence,), _) = load_dataset(dataset / name)
                shown = Shown(browser, program.address, viewport={"width": 1600, "height": 1000})
                truth = np.asarray(sequence.boxes, np.float64)
                count, right = corrections(shown, f"{name}/img", truth)
                rates.append(100 * count / len(truth))
                cells = Cell(f"{len(truth)}"), Cell(f"{count}"), number(rates[-1], 1)
                rows.append((Cell(name), *cells, number(right, 3)))
                shown.close()
    finally:
        program.close()
    note = f"Mean {statistics.mean(rates):.1f}, median {statistics.median(rates):.1f}."
    head = "sequence", "frames", "corrections", "for each 100 frames", "frames right"
    print(markdown.table(Table("Corrections on the page", head, rows, note=note)))


def corrections(shown: Shown, film: str, truth: Floats) -> tuple[int, float]:
    """Correct a film on the page until enough frames are right, or none is in doubt.

    Returns
    -------
    tuple
        How often it was corrected, and the share of frames that are right.
    """
    shown.open(film, "default")
    shown.draw(*corners(truth[0]))
    shown.track()
    for count in range(MOST):
        right = share(shown, truth)
        shown.page.evaluate(f"{START} app.actions.nextDoubt())")
        shown.until("s.pictured === s.frame")
        frame = int(shown.state("s.frame"))
        known = shown.state("s.session.objects[0].keyframes.map(({ frame }) => frame)")
        if right >= ENOUGH or frame in known:
            return count, right
        shown.page.keyboard.press("r")
        shown.drag(*corners(truth[frame]))
        shown.until(f"s.session.objects[0].keyframes.length > {len(known)} && !s.draft")
        shown.settle()
    return MOST, share(shown, truth)


def corners(box: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the corners of a box."""
    x, y, width, height = map(float, box)
    return (x - 0.5, y - 0.5), (x + width - 0.5, y + height - 0.5)


def share(shown: Shown, truth: Floats) -> float:
    """Return the share of frames whose box is right."""
    rows = shown.state("s.rows.get(1).map(({ x, y, a, b }) => [x, y, a, b])")
    x, y, a, b = np.array(rows, np.float64).T
    found = np.stack([x - a + 0.5, y - b + 0.5, 2 * a, 2 * b], axis=1)
    known = np.isfinite(truth).all(axis=1)
    return float(np.mean(iou(np.nan_to_num(found), np.nan_to_num(truth))[known] >= RIGHT))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        if sys.argv[1] == "speed":
            speed(Path(folder))
        else:
            effort(Path(sys.argv[2]), sys.argv[3:], Path(folder))
