"""Experiments: their numbers against plain second computations, and how they reach the user."""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arena
import oracles
from crowds import write_crowd
from motes import Ellipse, SourceError, Tracker, synthetic
from motes.cues import sunflower
from motes_lab.cli import main
from motes_lab.datasets.sot import Problem
from motes_lab.experiment import Experiment, Result, ResultOptions, as_csv
from motes_lab.metrics.statistics import over
from motes_lab.papers import ng_delp_figure3, ng_delp_table1, nummiaro_figure9
from motes_lab.papers.ng_delp_table1 import LATTICES, View
from motes_lab.report.tables import Cell, Table, number, percent

SIZE = (80, 64)


def last(steps: Experiment) -> Result:
    """Return the result of a whole experiment."""
    *_, result = steps
    return result


def cells(table: Table) -> dict[str, dict[str, Cell]]:
    """Return a table's cells by row and column."""
    return {row[0].text: dict(zip(table.head, row, strict=True)) for row in table.rows}


def value(cell: Cell) -> float:
    assert cell.value is not None
    return cell.value


def heights(axes: Any) -> list[float]:
    """Return the heights of a plot's bars."""
    return [bar.get_height() for bar in axes.patches]


def small_view(seed: int = 0, index: int = 0) -> View:
    clip = synthetic.still(SIZE, target=(30, 40), frames=index + 1, seed=seed)
    frame, (target,) = clip[index]
    return View(frame, target.ellipse, still=True)


# Ng and Delp, table 1


def color_oracle(view: View, sampling: str) -> oracles.Floats:
    """Return the weighted HSV histogram of a view's region, slowly."""
    assert view.region is not None
    pixels, bins, profile = view.frame.pixels, (8, 8, 4), "epanechnikov"
    if sampling.startswith("lattice"):
        lattice = sunflower(LATTICES[sampling])
        return oracles.on_lattice(pixels, view.region, lattice, "hsv", bins, profile)
    share = "all" if sampling == "all pixels" else sampling
    return oracles.every_pixel(pixels, view.region, "hsv", bins, profile, share)


def edges_oracle(view: View, sampling: str) -> oracles.Floats:
    """Return the weighted histogram of strong edges over a part of the pixels, slowly."""
    assert view.region is not None
    pixels = view.frame.pixels
    bins = oracles.edge_bins(*oracles.sobel(pixels), threshold=100, count=8)
    distance, own = oracles.radii(pixels.shape, view.region)
    weights = oracles.weighted("epanechnikov", view.region, distance, own) * (own < 1)
    weights *= oracles.checkerboard(pixels.shape, sampling)
    histogram = np.bincount(bins[bins >= 0], weights[bins >= 0], minlength=9).astype(np.float64)
    normalized: oracles.Floats = histogram / histogram.sum()
    return normalized


@pytest.mark.slow
def test_fewer_pixels_are_compared_as_brute_force_does() -> None:
    view = small_view()
    tables = last(ng_delp_table1.table1([view])).tables
    whole = color_oracle(view, "all pixels")
    for sampling in ("half", "quarter", "lattice of 64"):
        row = cells(tables["color"])[sampling]
        rho = float(np.sqrt(whole * color_oracle(view, sampling)).sum())
        assert 0.8 < rho < 0.9999
        assert value(row["rho"]) == pytest.approx(rho, abs=1e-6)
        assert value(row["distance"]) == pytest.approx(math.sqrt(1 - rho), abs=1e-6)
        likelihood = math.exp(-(1 - rho) / (2 * 0.15**2))
        assert value(row["likelihood"]) == pytest.approx(likelihood, abs=1e-6)
    whole = edges_oracle(view, "all")
    for sampling in ("half", "quarter"):
        rho = float(np.sqrt(whole * edges_oracle(view, sampling)).sum())
        assert 0.9 < rho < 0.99999
        found = value(cells(tables["edges"])[sampling]["rho"])
        assert found == pytest.approx(rho, abs=1e-6)  # the arctangent is a polynomial


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of frames, with its truth."""
    folder = tmp_path_factory.mktemp("film") / "beetle"
    arena.write_sequence(folder, synthetic.still(arena.SIZE, target=(30, 40), frames=8))
    return folder


def test_a_film_is_followed(film: Path) -> None:
    box = (60.0, 38.0, 30.0, 40.0)
    tracker = Tracker("ng_delp")
    first, *others = ng_delp_table1.followed(str(film / "img"), box)
    assert len(others) == 7
    assert not first.still
    assert first.region == Ellipse.from_box(box)
    tracker.init(first.frame, box)
    for view in others:
        assert view.region == tracker.update(view.frame).ellipse


# Ng and Delp, figure 3


@pytest.mark.slow
def test_the_likelihoods_are_those_of_the_equations() -> None:
    result = last(ng_delp_figure3.figure3())
    rows = result.tables[""].rows
    assert [row[0].text for row in rows] == [f"{i / 10}" for i in range(11)]
    for i, (_, plain, lifted, best) in enumerate(rows):
        d = i / 10
        assert value(plain) == pytest.approx(math.exp(-(d**2) / (2 * 0.15**2)), abs=1e-12)
        assert value(lifted) == pytest.approx(math.exp(-(d**2) / (2 * 0.15**2)) + 0.1)
        if d < 0.4:
            assert best == Cell("")
        else:  # sigma = d_min / sqrt(2)
            assert value(best) == pytest.approx(math.exp(-((d / 0.4) ** 2)) + 0.1)
    assert result.draw is not None
    (axes,) = result.draw().axes
    ends = [np.asarray(line.get_xydata())[0].tolist() for line in axes.lines]
    assert ends == [[0, 1], [0, 1.1], pytest.approx([0.4, math.exp(-1) + 0.1])]


# Nummiaro et al., figure 9


@pytest.mark.slow
def test_the_known_histogram_is_that_of_the_region() -> None:
    view = small_view()
    assert view.region is not None
    result = last(nummiaro_figure9.figure9(view.frame, view.region))
    right = oracles.every_pixel(view.frame.pixels, view.region, "rgb", (8, 8, 8), "radial")
    table = result.tables[""]
    assert f"{np.count_nonzero(right)} of 512" in table.title
    shares = [value(row[3]) for row in table.rows]
    assert shares == pytest.approx(np.sort(right)[::-1][:12], abs=1e-9)
    red, green, blue, share = table.rows[0]
    ranges = [int(cell.text.split(" to ")[0]) // 32 for cell in (red, green, blue)]
    assert right.reshape(8, 8, 8)[tuple(ranges)] == pytest.approx(value(share))
    assert sum(shares) + value(table.foot[0][3]) == pytest.approx(1)
    assert result.draw is not None
    (axes,) = result.draw().axes
    assert heights(axes) == pytest.approx(right.tolist(), abs=1e-9)


TABLE = Table(
    "Title",
    ("name", "size", "share"),
    [(Cell("a, b"), number(over([1, 3]), 2), percent(0.5)), (Cell("c"), number(7.0), Cell(""))],
    ((Cell("all"), Cell("many"), percent(1 / 3)),),
    "Note.",
)


def go(capfd: pytest.CaptureFixture[str], line: str) -> tuple[int, str, str]:
    capfd.readouterr()
    code = main(["experiment", *line.split()])
    return code, *capfd.readouterr()


@pytest.mark.parametrize(
    ("line", "code", "why"),
    [
        ("ng-delp-tabel1", 2, "did you mean ng-delp-table1?"),
        ("magic", 2, "known are ng-delp-table1, "),
        ("ng-delp-table1 nowhere.mp4", 2, "--init"),
        ("ng-delp-table1 film.mp4 --init 1,2,3", 2, "--init takes x,y,width,height"),
        ("nummiaro-figure9 nowhere.mp4 --init 1,2,30,40", 3, "no file or folder nowhere.mp4"),
        ("pairs nowhere nummiaro mean_shift --first-pixel 2", 2, "--first-pixel takes 0, 1"),
        ("pairs bare nummiaro mean_shift", 3, "no sequence in bare"),
        ("zhao-figure9 crowds", 3, "has 2 sequences; give the folder of one."),
        ("zhao-figure9 bad", 3, "can be used. sequence bad: it has no seqinfo.ini"),
        ("ng-delp-figure3 --sedes 2", 2, "Unknown option"),
    ],
)
def test_bad_input_is_answered_in_one_line(
    line: str,
    code: int,
    why: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bare").mkdir()
    for name in ("crowds/a", "crowds/b", "bad"):
        write_crowd(Path(name))
    Path("bad/seqinfo.ini").unlink()
    found, out, error = go(capfd, line)
    assert (found, out) == (code, "")
    assert error.startswith("motes: error: ")
    assert why in error
    assert error.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ng-delp-table1", "nummiaro-figure9"])
def test_an_experiment_writes_what_it_says(
    name: str, film: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "new" / "out"
    line = f"{name} {film / 'img' / '0001.png'} --init 60,38,30,40 --out {folder}"
    code, out, error = go(capfd, line)
    assert code == 0, error
    assert error.endswith(f"wrote {folder / name}.md, with CSV{' and PNG' * ('figure' in name)}.\n")
    (title,) = re.findall("^### (.*)", (folder / f"{name}.md").read_text(), re.MULTILINE)[:1]
    assert title in " ".join(out.split())
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert before.keys() > {f"{name}.md"}
    code, out, error = go(capfd, line)
    assert (code, out) == (5, "")
    assert "--overwrite" in error
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    (folder / f"{name}.md").unlink()
    assert go(capfd, line)[0] == 5  # a CSV is in the way


def test_what_is_known_when_it_is_cut_short_is_kept(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    closed = []

    def interrupt(_: int) -> Result:
        raise KeyboardInterrupt

    def steps(error: BaseException | None) -> Experiment:
        try:
            yield Result({"": TABLE})
            if error is not None:
                raise error
            yield Result({"": TABLE}, problems=(Problem("sequence x", "It is broken."),))
        finally:
            closed.append(True)

    def none() -> Experiment:
        yield from map(interrupt, [0])

    results = ResultOptions(out=tmp_path)
    assert results.show("early", none()) == 130
    out, error = capfd.readouterr()
    assert (out, error.count(" s; there are no results yet.\n")) == ("", 1)
    assert results.show("interrupted", steps(KeyboardInterrupt())) == 130
    with pytest.raises(SourceError):
        results.show("failed", steps(SourceError("no more")))
    assert results.show("whole", steps(None), [Problem("tracker y", "Gone.")]) == 6
    out, error = capfd.readouterr()
    assert out.count("Title") == 3
    assert "motes: sequence x: It is broken.\n" in error
    assert "motes: tracker y: Gone.\n" in error
    assert error.count(" s; the results are not complete.\n") == 1
    for name in ("interrupted", "failed", "whole"):
        assert (tmp_path / f"{name}.csv").read_text() == as_csv(TABLE)
    assert closed == [True] * 3


def test_an_interrupt_between_steps_ends_the_experiment() -> None:
    class Interrupting(Result):
        @property
        def progress(self) -> str:
            raise KeyboardInterrupt

    ended = []

    def steps() -> Experiment:
        try:
            yield Interrupting({"": TABLE})
        finally:
            ended.append(True)

    running = steps()  # held, so that it does not end for want of anybody who knows it
    assert ResultOptions().show("it", running) == 130
    assert ended
