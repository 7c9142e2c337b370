"""Experiments: their numbers against plain second computations, and how they reach the user."""

from __future__ import annotations

import contextlib
import csv
import math
import subprocess
import sys
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import arena
import oracles
from motes import Ellipse, Tracker, synthetic
from motes.cli.input_checks import prepare_folder
from motes.core.errors import ConfigError, FormatError, SourceError
from motes.core.geometry import iou
from motes.cues.structure_tensor import Orientation
from motes_lab.cli import experiment, experiment_output, main
from motes_lab.cli.experiment_output import Output, show
from motes_lab.datasets.sot import Problem
from motes_lab.metrics.sot import overlap_distances
from motes_lab.papers import (
    ng_delp_figure3,
    ng_delp_table1,
    nummiaro_figure9,
    occlusions,
    rendered_claims,
    sample_regions,
    two_rooms,
    zhao_pei_figure2,
)
from motes_lab.papers.expected_time import Expected
from motes_lab.papers.ng_delp_table1 import SAMPLINGS
from motes_lab.papers.result import Experiment, Result, as_csv, files, over, save
from motes_lab.papers.sample_regions import View
from motes_lab.report.tables import Cell, Table, number, percent

SIZE = (80, 64)
COMMANDS = [name for name in experiment.app if not name.startswith("-")]


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
        lattice = SAMPLINGS[sampling].lattice
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
@pytest.mark.parametrize("sampling", ["half", "quarter", "lattice of 64", "lattice of 512"])
def test_colors_over_fewer_pixels_are_compared_as_brute_force_does(sampling: str) -> None:
    view = small_view()
    row = cells(last(ng_delp_table1.table1([view])).tables["color"])[sampling]
    rho = float(np.sqrt(color_oracle(view, "all pixels") * color_oracle(view, sampling)).sum())
    assert 0.8 < rho < 0.9999
    assert value(row["rho"]) == pytest.approx(rho, abs=1e-6)
    assert value(row["distance"]) == pytest.approx(math.sqrt(1 - rho), abs=1e-6)
    likelihood = math.exp(-(1 - rho) / (2 * 0.15**2))
    assert value(row["likelihood"]) == pytest.approx(likelihood, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("sampling", ["half", "quarter"])
def test_edges_over_fewer_pixels_are_compared_as_brute_force_does(sampling: str) -> None:
    view = small_view()
    row = cells(last(ng_delp_table1.table1([view])).tables["edges"])[sampling]
    rho = float(np.sqrt(edges_oracle(view, "all") * edges_oracle(view, sampling)).sum())
    assert 0.9 < rho < 0.99999
    assert value(row["rho"]) == pytest.approx(rho, abs=1e-6)  # the arctangent is a polynomial


def test_all_pixels_are_like_themselves_and_take_all_the_time() -> None:
    for name, table in last(ng_delp_table1.table1(sample_regions.rendered(1))).tables.items():
        rows = cells(table)
        full = rows["all pixels"]
        assert [value(full[key]) for key in ("rho", "distance", "likelihood")] == pytest.approx(
            [1, 0, 1], abs=1e-7
        )
        assert value(full["against all"]) == 1
        shares = [value(rows[key]["against all"]) for key in ("half", "quarter", "lattice of 64")]
        assert 0.7 > shares[0] > shares[1] > shares[2] > 0, name
        assert value(full["µs"]) > value(rows["half"]["µs"]) > 0.1


def test_films_give_means_and_deviations_over_the_regions_that_are_tracked() -> None:
    seen = [small_view(seed=seed) for seed in range(3)]
    alone = [
        value(cells(last(ng_delp_table1.table1([view])).tables["color"])["quarter"]["rho"])
        for view in seen
    ]
    film = [view._replace(still=False) for view in seen]
    film.insert(1, View(seen[0].frame, None, still=False))
    film.append(View(seen[0].frame, Ellipse(-90, -90, 8, 8), still=False))  # shows nothing
    table = last(ng_delp_table1.table1(film)).tables["color"]
    rho = cells(table)["quarter"]["rho"]
    assert rho.value == pytest.approx(np.mean(alone))
    assert rho.deviation == pytest.approx(np.std(alone, ddof=1))
    assert "in 4 of 5 pictures" in table.title


# Pictures and regions


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of frames, with its truth."""
    folder = tmp_path_factory.mktemp("film") / "beetle"
    arena.write_sequence(folder, synthetic.still(arena.SIZE, target=(30, 40), frames=8))
    return folder


def test_a_film_is_followed_with_each_seed(film: Path) -> None:
    box = (60.0, 38.0, 30.0, 40.0)
    found = list(sample_regions.followed(film / "img", box, "nummiaro", 2))
    assert len(found) == 16
    assert not any(view.still for view in found)
    for seed in (0, 1):
        tracker = Tracker("nummiaro", seed)
        mine = found[8 * seed : 8 * seed + 8]
        assert mine[0].region == Ellipse.from_box(box)
        tracker.init(mine[0].frame, box)
        for view in mine[1:]:
            assert view.region == tracker.update(view.frame).ellipse
    assert found[3].region != found[11].region


def test_where_the_target_is_lost_there_is_no_region(tmp_path: Path) -> None:
    for i in range(12):
        pixels = np.full((60, 80, 3), 128, np.uint8)
        if i < 3:
            pixels[20:40, 30:50] = (220, 40, 30)
        Image.fromarray(pixels).save(tmp_path / f"{i:02}.png")
    found = list(sample_regions.followed(tmp_path, (30, 20, 20, 20), "nummiaro", 1))
    assert [view.region is None for view in found][:3] == [False] * 3
    assert found[-1].region is None


def test_a_picture_comes_once_and_needs_no_tracker(film: Path) -> None:
    picture = next((film / "img").iterdir())
    (view,) = sample_regions.followed(picture, (60, 38, 30, 40), "nummiaro", 5)
    assert view.still
    assert view.region == Ellipse.from_box((60, 38, 30, 40))
    with pytest.raises(ConfigError, match="center outside"):
        next(sample_regions.followed(picture, (600, 38, 30, 40), "nummiaro", 1))
    with pytest.raises(ConfigError, match="did you mean 'nummiaro'"):
        next(sample_regions.followed(picture, (60, 38, 30, 40), "numiaro", 1))


# Ng and Delp, figure 3


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


def test_the_known_histogram_is_that_of_the_region() -> None:
    view = small_view()
    assert view.region is not None
    result = last(nummiaro_figure9.figure9(view))
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


# Rendered clips


def run(name: str, clip: synthetic.Clip, seed: int, *, box: bool = False) -> list[Ellipse]:
    """Follow a target from its truth, frame by frame."""
    tracker, found = Tracker(name, seed), []
    for frame, (target,) in clip:
        start = target.ellipse.box if box else target.ellipse
        track = tracker.update(frame) if frame.index else tracker.init(frame, start)
        found.append(track.ellipse)
    return found


def test_leaps() -> None:
    clip = synthetic.jumping((240, 180), frames=40)
    table = last(rendered_claims.leaps(["mean_shift", "nummiaro"], [clip], 2)).tables[""]
    rows = cells(table)
    truth = [target.ellipse.box for _, (target,) in clip]
    jump = [i for i in range(1, 40) if iou(truth[i], truth[i - 1]) == 0]
    assert len(jump) >= 5
    for name, seeds in (("mean_shift", [0]), ("nummiaro", [0, 1])):
        overlaps = np.array(
            [
                [iou(e.box, t) for e, t in zip(run(name, clip, s, box=True), truth, strict=True)]
                for s in seeds
            ]
        )
        right = (
            overlaps.mean(axis=1),
            (overlaps > 0.1).mean(axis=1),
            (overlaps[:, jump] > 0.1).mean(axis=1),
        )
        for key, values in zip(("mean IoU", "frames on target", "leap frames"), right, strict=True):
            cell = rows[name][key]
            assert cell.value == pytest.approx(values.mean()), (name, key)
            assert (cell.deviation is None) == (name == "mean_shift")
            if cell.deviation is not None:
                assert cell.deviation == pytest.approx(values.std(ddof=1))
        assert rows[name]["runs"].text == str(len(seeds))
    assert value(rows["nummiaro"]["leap frames"]) > value(rows["mean_shift"]["leap frames"])
    assert rows["mean_shift"]["the paper"].text == "loses its target, for good"


def test_rotation() -> None:
    clip = synthetic.turning((160, 120), frames=40)
    *_, result = rendered_claims.rotation(["maggio:O-ROH", "maggio:O-FOH"], [clip], 1)
    rows = cells(result.tables[""])
    for name in rows:
        errors = []
        for found, (_, (target,)) in zip(run(name, clip, 0), clip, strict=True):
            # Between axes, which have no head: the angle whose double's cosine is this.
            twice = math.cos(2 * (found.theta - target.ellipse.theta))
            errors.append(math.degrees(math.acos(max(-1.0, min(1.0, twice)))) / 2)
        assert value(rows[name]["mean error (degrees)"]) == pytest.approx(np.mean(errors), abs=1e-4)
        assert value(rows[name]["largest error (degrees)"]) == pytest.approx(max(errors), abs=1e-4)
        right = f"{int(max(errors) < 45)} of 1"
        assert rows[name]["turns followed"].text == right
    assert {row["turns followed"].text for row in rows.values()} == {"0 of 1", "1 of 1"}


def test_a_turn_is_followed_if_no_frame_is_far_off(monkeypatch: pytest.MonkeyPatch) -> None:
    truth = np.zeros((10, 5))

    def passes(*_: object, **__: object) -> Iterator[rendered_claims.Pass]:
        for worst in (44, 46, 180 + 44, 180 + 46):
            found = truth.copy()
            found[3, 4] = math.radians(worst)
            yield rendered_claims.Pass("x", found, truth, "")

    monkeypatch.setattr(rendered_claims, "passes", passes)
    row = cells(last(rendered_claims.rotation(["x"], [], 1)).tables[""])["x"]
    assert row["turns followed"].text == "2 of 4"
    assert value(row["largest error (degrees)"]) == pytest.approx(45)
    assert value(row["mean error (degrees)"]) == pytest.approx(4.5)


def test_growth() -> None:
    clip = synthetic.growing((240, 180), frames=8, factor=4)
    result = last(rendered_claims.growth(["maggio:C"], [clip], 2))
    truth = np.array([target.ellipse for _, (target,) in clip])
    ods = [overlap_distances(np.array(run("maggio:C", clip, s)), truth).mean() for s in (0, 1)]
    cell = cells(result.tables["tracks"])["maggio:C"]["mean OD"]
    assert cell.value == pytest.approx(np.mean(ods))
    assert cell.deviation == pytest.approx(np.std(ods, ddof=1))
    follows, fixed = (value(row[1]) for row in result.tables["histograms"].rows)
    assert follows < fixed
    # Fixed filters ask nothing of the frames in between.
    cue = Orientation(scale_selection=False)
    model = cue.update_reading(
        cue.learn(clip[0][0], clip[0][1][0].ellipse), clip[3][0], Ellipse(*truth[3])
    )
    assert fixed == pytest.approx(cue.distances(model, clip[4][0], truth[4:5])[0])
    assert follows == rendered_claims.grown(Orientation(scale_selection=True), clip)


@pytest.mark.slow
def test_a_target_that_turns_around() -> None:
    clip = synthetic.rolling((160, 120), frames=30)
    result = last(zhao_pei_figure2.figure2(["zhao_pei:fixed", "zhao_pei:color"], [clip], 2))
    rows = cells(result.tables[""])
    truth = [target.ellipse.box for _, (target,) in clip]
    curves = []
    for name in ("zhao_pei:fixed", "zhao_pei:color"):
        overlaps = np.array(
            [
                [iou(e.box, t) for e, t in zip(run(name, clip, s), truth, strict=True)]
                for s in (0, 1)
            ]
        )
        curves.append(overlaps.mean(axis=0))
        final = overlaps[:, 22:].mean(axis=1)  # the last 8 of 30 frames
        for key, values in (("mean IoU", overlaps.mean(axis=1)), ("in the last quarter", final)):
            assert rows[name][key].value == pytest.approx(values.mean())
            assert rows[name][key].deviation == pytest.approx(values.std(ddof=1))
        assert rows[name]["turns followed"].text == f"{(final > 0.5).sum()} of 2"
        assert rows[name]["runs"].text == "2"
    assert result.draw is not None
    (axes,) = result.draw().axes
    for line, curve in zip(axes.lines, curves, strict=True):
        np.testing.assert_allclose(np.asarray(line.get_ydata(), float), curve)


def test_runs_are_told_from_each_other_and_counted() -> None:
    clips = [synthetic.still(SIZE, target=(30, 40), frames=2, seed=seed) for seed in (0, 1)]
    found = list(rendered_claims.passes(["mean_shift", "nummiaro"], clips, 3))
    assert [each.name for each in found] == ["mean_shift", *["nummiaro"] * 3] * 2
    assert found[-1].progress == "8 of 8 runs"
    assert found[1].found.shape == (2, 5)
    assert (found[1].found[1] != found[2].found[1]).any()
    with pytest.raises(ConfigError):
        next(rendered_claims.passes(["nobody"], clips, 1))


# Files


TABLE = Table(
    "Title",
    ("name", "size", "share"),
    [(Cell("a, b"), number(over([1, 3]), 2), percent(0.5)), (Cell("c"), number(7.0), Cell(""))],
    ((Cell("all"), Cell("many"), percent(1 / 3)),),
    "Note.",
)


def test_csv_holds_all_digits_and_deviations_in_columns_of_their_own() -> None:
    assert list(csv.reader(as_csv(TABLE).splitlines())) == [
        ["name", "size", "size, standard deviation", "share"],
        ["a, b", "2", "1.41421", "0.5"],
        ["c", "7", "", ""],
        ["all", "many", "", "0.333333"],
    ]


def test_saving(tmp_path: Path) -> None:
    result = Result({"one": TABLE, "two": TABLE}, last(ng_delp_figure3.figure3()).draw)
    save(result, tmp_path, "it")
    names = ["it.md", "it-one.csv", "it-two.csv", "it.png"]
    assert files("it", ["one", "two"], plot=True) == names
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)
    text = (tmp_path / "it.md").read_text()
    assert text.count("### Title") == 2
    assert "| a, b | 2.00 ± 1.41 | 50% |" in text
    with Image.open(tmp_path / "it.png") as image:
        assert image.width >= 800
    with pytest.raises(FormatError, match="cannot be written"):
        save(result, tmp_path / "nowhere", "it")


# The command line


def go(capfd: pytest.CaptureFixture[str], line: str) -> tuple[int, str, str]:
    capfd.readouterr()
    code = main(["experiment", *line.split()])
    return code, *capfd.readouterr()


def test_the_list(capfd: pytest.CaptureFixture[str]) -> None:
    assert len(COMMANDS) == 21
    code, out, error = go(capfd, "")
    assert (code, error) == (0, "")
    assert [line.split()[0] for line in out.splitlines()] == COMMANDS
    papers = (
        " et al., ",
        " Ng and Delp, ",
        "Zhao and Pei, ",
        "Hard films",
        "Effort of",
        "Masks of",
        "Claims of",
    )
    assert all(any(paper in line for paper in papers) for line in out.splitlines())
    assert max(map(len, out.splitlines())) <= 80
    assert go(capfd, "--list") == (code, out, error)


@pytest.mark.parametrize(
    ("line", "module", "given"),
    [
        ("occlusions", occlusions, ([2, 10], [15], 2)),
        ("occlusions --full", occlusions, ([2, 10, 50], [5, 15, 30, 45, 60], 10)),
        ("occlusions --full --objects 2 --hidden 7 --least 1", occlusions, ([2], [7], 1)),
        ("two-rooms", two_rooms, (1, 1500)),
        ("two-rooms --full --frames 50", two_rooms, (5, 50)),
        ("two-rooms --full --seeds 3", two_rooms, (3, 1500)),
    ],
)
def test_the_short_run_and_the_full_one(
    line: str,
    module: Any,
    given: tuple[object, ...],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    asked: list[tuple[Any, ...]] = []

    def measured(*arguments: Any) -> Iterator[Result]:
        asked.append(arguments)
        yield Result({"": Table("A table", ("a",), [])}, share=1.0)

    monkeypatch.setattr(module, line.split()[0].replace("-", "_"), measured)
    monkeypatch.setattr(module, "expected", lambda *_: Expected("7 clips", 200.0))
    options = "--detector gaussian --preset ng_delp:color"
    code, _, error = go(capfd, f"{line} {options}")
    assert code == 0, error
    more = "" if "--full" in line else " The whole table: --full."
    assert error == f"motes: 7 clips: about 3 min.{more}\n"
    ((*numbers, scene),) = asked
    if module is occlusions:
        kinds, least = numbers
        numbers = [
            sorted({kind.objects for kind in kinds}), sorted({kind.length for kind in kinds}), least
        ]  # fmt: skip
    assert tuple(numbers) == given
    made = scene(0)
    assert made.config.tracker.edges is None
    assert made.detector.config.method == "gaussian"
    assert scene(0).detector is not made.detector


def test_progress_has_the_time_that_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    texts: list[str] = []

    class Shown:
        def __init__(self, **_: object) -> None: ...

        def status(self, text: object) -> Any:
            texts.append(str(text))
            return contextlib.nullcontext(self)

        def update(self, text: object) -> None:
            texts.append(str(text))

    def steps() -> Experiment:
        yield Result({}, progress="clip 1", share=0.25)
        yield Result({}, progress="clip 2")

    expected = Expected("2 clips", 75.0)
    now = iter([100.0, 120.0, 140.0])
    monkeypatch.setattr("motes_lab.cli.experiment_output.time.monotonic", lambda: next(now))
    monkeypatch.setattr("rich.console.Console", Shown)
    assert show(steps(), Output("it", ("",), None, overwrite=False), (), expected) == 0
    assert texts == [
        "measuring, about 75 s left",
        "measuring: clip 1, about 60 s left",
        "measuring: clip 2",
    ]


def test_listing_loads_nothing_heavy() -> None:
    script = "import sys; from motes_lab.cli import main; main(['experiment']); print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not {"numpy", "av", "matplotlib", "rich.table"} & set(done.stdout.split())


@pytest.mark.parametrize(
    ("line", "code", "why"),
    [
        ("ng-delp-tabel1", 2, "did you mean ng-delp-table1?"),
        ("ng-delp-tabel1 film.mp4 --init 1,2,3,4", 2, "did you mean ng-delp-table1?"),
        ("magic", 2, "known are ng-delp-table1, "),
        ("ng-delp-table1 nowhere.mp4 --init 1,2,30,40", 3, "no file or folder nowhere.mp4"),
        ("ng-delp-table1 nowhere.mp4", 2, "--init"),
        ("ng-delp-table1 --init 1,2,3,4", 2, "omit --init"),
        ("ng-delp-table1 film.mp4 --init 1,2,3", 2, "--init takes x,y,width,height"),
        ("ng-delp-table1 --seeds 0", 2, "--seeds is 0"),
        ("nummiaro-figure9 nowhere.mp4 --init 1,2,30,40", 3, "no file or folder nowhere.mp4"),
        ("nummiaro-leaps nobody", 2, "No preset 'nobody'"),
        ("maggio-growth --clips 0", 2, "--clips is 0"),
        ("maggio-rotation --seeds -1", 2, "--seeds is -1"),
        ("occlusions --least 0", 2, "--least is 0"),
        ("occlusions --objects 12", 2, "--objects is 12; give 2 or a multiple of 10"),
        ("occlusions --hidden 10 --hidden 4", 2, "--hidden is 4; give 5 or more"),
        ("occlusions --detector found.txt", 2, "found.txt, and clips are rendered"),
        ("occlusions --detector dog", 2, "A detector is mog2"),
        ("occlusions --preset mean_shift", 2, "Objects are followed by particle filters"),
        ("two-rooms --preset dog", 2, "No preset 'dog'"),
        ("two-rooms --detector found.txt", 2, "found.txt, and clips are rendered"),
        ("pairs nowhere nummiaro mean_shift", 3, "no file or folder nowhere"),
        ("pairs nowhere nummiaro mean_shift --first-pixel 2", 2, "--first-pixel takes 0, 1"),
        ("pairs . nummiaro mean_shift", 3, "no sequence in ."),
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
    found, out, error = go(capfd, line)
    assert (found, out) == (code, "")
    assert error.startswith("motes: error: ")
    assert why in error
    assert error.count("\n") == 1


SMALL_CLIPS = {
    "jumping": partial(synthetic.jumping, (160, 120), frames=30),
    "turning": partial(synthetic.turning, (160, 120), frames=3),
    "growing": partial(synthetic.growing, (160, 120), frames=3),
    "rolling": partial(synthetic.rolling, (160, 120), frames=4),
}
RUNS = {
    "ng-delp-table1": "",
    "ng-delp-figure3": "",
    "nummiaro-leaps": "mean_shift --clips 1",
    "nummiaro-figure9": "",
    "maggio-rotation": "maggio:C --clips 1 --seeds 1",
    "maggio-growth": "maggio:C --clips 1 --seeds 1",
    "zhao-figure2": "--clips 1 --seeds 1",
    "occlusions": "--hidden 5 --objects 2 --least 1",
}


@pytest.mark.slow
@pytest.mark.parametrize("name", RUNS)
def test_every_experiment_writes_what_it_says(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for clip, small in SMALL_CLIPS.items():
        monkeypatch.setattr(synthetic, clip, small)
    monkeypatch.setattr(occlusions, "keeps", lambda met, _: [len(met.clip) > 100])
    checked: list[list[str]] = []

    def prepare(out: Path, names: list[str], overwrite: bool) -> None:
        checked.append(names)
        prepare_folder(out, names, overwrite)

    monkeypatch.setattr(experiment_output, "prepare_folder", prepare)
    folder = tmp_path / "new" / "out"
    code, out, error = go(capfd, f"{name} {RUNS[name]} --out {folder}")
    assert code == 0, error
    assert error.endswith(f"wrote {folder / name}.md, with CSV{' and PNG' * ('figure' in name)}.\n")
    assert sorted(path.name for path in folder.iterdir()) == sorted(checked[0])
    titles = [
        line[4:] for line in (folder / f"{name}.md").read_text().splitlines() if "###" in line
    ]
    assert titles
    assert all(title in " ".join(out.split()) for title in titles)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    code, out, error = go(capfd, f"{name} {RUNS[name]} --out {folder}")
    assert (code, out) == (5, "")
    assert "--overwrite" in error
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_options_of_table_1(
    film: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    asked: list[tuple[object, ...]] = []

    def made(*given: object) -> Iterator[View]:
        asked.append(given)
        yield small_view()

    monkeypatch.setattr(sample_regions, "followed", made)
    monkeypatch.setattr(sample_regions, "rendered", made)
    assert go(capfd, f"ng-delp-table1 {film} --init 1,-2,3.5,4")[0] == 0
    assert go(capfd, f"ng-delp-table1 {film} --init -1,2,3,4 --preset maggio --seeds 2")[0] == 0
    assert go(capfd, "ng-delp-table1 --seeds 7")[0] == 0
    assert asked == [
        (str(film), [1, -2, 3.5, 4], "ng_delp", 1),
        (str(film), [-1, 2, 3, 4], "maggio", 2),
        (7,),
    ]


def test_what_is_known_when_it_is_cut_short_is_kept(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    closed = []

    def steps(error: BaseException | None) -> Experiment:
        try:
            yield Result({"": TABLE})
            if error is not None:
                raise error
            yield Result({"": TABLE}, problems=(Problem("sequence x", "It is broken."),))
        finally:
            closed.append(True)

    def output(name: str) -> Output:
        return Output(name, ("",), tmp_path, overwrite=False)

    assert show(steps(KeyboardInterrupt()), output("interrupted")) == 130
    with pytest.raises(SourceError):
        show(steps(SourceError("no more")), output("failed"))
    assert show(steps(None), output("whole"), [Problem("tracker y", "Gone.")]) == 6
    out, error = capfd.readouterr()
    assert out.count("Title") == 3
    assert "motes: sequence x: It is broken.\n" in error
    assert "motes: tracker y: Gone.\n" in error
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
    assert show(running, Output("it", ("",), None, overwrite=False)) == 130
    assert ended
