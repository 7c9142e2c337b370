"""The views of the protocol `robust`: their pictures, and the truth that goes with them."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from evaluations import ellipses, outcome, shifted, trace
from evaluations import sequence as standing
from motes_lab.adapters.registry import resolve
from motes_lab.aggregate import Evaluation
from motes_lab.datasets.sot import Sequence
from motes_lab.protocols.perturbations import (
    OCCLUSION_FRAMES,
    PerturbedSequence,
    mirrored,
    perturbations,
    perturbed_frames,
)
from motes_lab.protocols.sot import Start
from motes_lab.report.sections import title
from motes_lab.report.speed_ratio import Comparisons
from motes_lab.report.write import write_report
from motes_lab.runner import plan

WIDTH, HEIGHT, FRAMES = 96, 72, 60
Made = dict[str, tuple[PerturbedSequence, list[Start]]]


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Sequence:
    """Return a film of a white rectangle that moves to the right before red."""
    folder = tmp_path_factory.mktemp("film")
    boxes = np.array([(2.0 * (i % 30) + 4, 20, 16, 12) for i in range(FRAMES)])
    for i, (x, y, width, height) in enumerate(boxes.astype(int).tolist()):
        picture = np.zeros((HEIGHT, WIDTH, 3), np.uint8) + np.array([90, 0, 0], np.uint8)
        picture[y : y + height, x : x + width] = 255
        Image.fromarray(picture).save(folder / f"{i:03d}.png")
    boxes[:3] = boxes[-2:] = np.nan
    return Sequence("White", folder, boxes, ellipses(boxes))


@pytest.fixture(scope="module")
def made(film: Sequence) -> Made:
    return {each[0].view: each for each in perturbations(film, WIDTH, HEIGHT)}


def white(pixels: NDArray[np.uint8]) -> list[int]:
    rows, columns = np.nonzero(pixels[:, :, 1] > 127)
    x, y = columns.min(), rows.min()
    return [int(x), int(y), int(columns.max() - x + 1), int(rows.max() - y + 1)]


def test_there_are_24_views_and_each_starts_on_its_truth(made: Made) -> None:
    begins = [start for _, each in made.values() for start in each]
    assert len({start.label for start in begins}) == len(begins) == 24
    assert {start.protocol for start in begins} == {"robust"}
    for view, (seen, each) in made.items():
        assert np.isfinite(seen.boxes[0]).all(), view
        if view != "perturbed":
            assert each[0].box == pytest.approx(tuple(seen.boxes[0]))
            assert each[0].frame == 0


STILL = ["original", "mirrored", "backward", "every-second", "gray", "half-size"]
LATER = ["from-quarter", "from-half", "from-three-quarters"]


@pytest.mark.parametrize("view", [*STILL, *LATER])
def test_the_truth_is_where_the_target_is(made: Made, view: str) -> None:
    seen = made[view][0]
    frames = list(perturbed_frames(seen))
    assert [frame.index for frame in frames] == list(range(seen.frames))
    assert all(a.time < b.time for a, b in itertools.pairwise(frames))
    for frame, box in zip(frames, seen.boxes, strict=True):
        if np.isfinite(box).all():
            assert white(frame.pixels) == box.tolist()
    there = np.isfinite(seen.boxes).all(axis=1)
    assert np.allclose(ellipses(seen.boxes[there]), seen.ellipses[there])


def test_mirrored_twice_is_as_before() -> None:
    boxes = np.array([[3.0, 5, 7, 9]])
    regions = np.array([[6.0, 9, 4, 2, 0.3]])
    once = mirrored(boxes, regions, 50)
    assert once[0][0].tolist() == [40, 5, 7, 9]
    assert once[1][0].tolist() == [43, 9, 4, 2, -0.3]
    assert all(map(np.array_equal, mirrored(*once, 50), (boxes, regions)))


def test_the_occluder_passes_over_the_target(made: Made) -> None:
    seen = made["occluded"][0]
    shares = []
    for frame, (x, y, width, height) in zip(perturbed_frames(seen), seen.boxes, strict=True):
        if np.isfinite(x):
            inside = frame.pixels[int(y) : int(y + height), int(x) : int(x + width), 1]
            shares.append(float((inside < 127).mean()))
    touched = np.flatnonzero(shares)
    middle = (seen.frames - min(OCCLUSION_FRAMES, seen.frames // 3)) // 2
    assert max(shares) == 1
    assert middle <= touched[0] < touched[-1] < middle + OCCLUSION_FRAMES
    assert np.array_equal(seen.boxes, made["original"][0].boxes, equal_nan=True)


def test_pixels_change_as_the_view_says(made: Made) -> None:
    before, gray, hue, blurred = (
        next(perturbed_frames(made[view][0])).pixels
        for view in ("original", "gray", "hue", "blurred")
    )
    assert (gray[0, 0] == 27).all()  # 0.299 of 90
    assert (gray[..., 0] == gray[..., 2]).all()
    # By hand: red 90 turned by 30 degrees about gray is (81.96, 30, -21.96); and 30 brighter.
    assert hue[0, 0].tolist() == [112, 60, 8]
    assert abs(blurred.mean() - before.mean()) < 1
    assert white(blurred)[2:] == white(before)[2:]
    assert not np.array_equal(blurred, before)


def test_a_view_is_cut(film: Sequence) -> None:
    cut = {seen.view: seen for seen, _ in perturbations(film, WIDTH, HEIGHT, 7)}
    assert {seen.frames for seen in cut.values()} == {7}
    assert cut["backward"].chosen.tolist() == [57, 56, 55, 54, 53, 52, 51]
    assert cut["every-second"].chosen.tolist() == [3, 5, 7, 9, 11, 13, 15]


def test_the_plan_has_a_job_for_each_view(film: Sequence) -> None:
    entries, _ = resolve(["nummiaro"])
    jobs, problems = plan(entries, [film], ["robust"], 2, 10)
    assert not problems
    assert len(jobs) == 13
    assert sum(len(job.passes) for job in jobs) == 48
    assert len({item.path(Path()) for job in jobs for item in job.passes}) == 48
    assert {job.sequence.digest for job in jobs} == {film.digest}


def test_the_report_has_the_spread_and_the_number_of_views(tmp_path: Path) -> None:
    where, far = standing(), standing("Far")
    passes = [
        outcome(who, film, trace(shifted([dx] * 20)), seed, "robust", label)
        for who, seeds in (("a", 1), ("b", 2))
        for seed in range(seeds)
        for film, labels in ((where, "xyz"), (far, "xy"))
        for label, dx in zip(labels, (8.0 + seed, 0.0, 2.0), strict=False)
    ]
    passes.append(outcome("c", where, "broken", 0, "robust", "x"))
    passes.append(outcome("c", where, trace(shifted([0.0] * 20)), 0, "sre", "shift-up"))
    found = Evaluation(passes)
    assert title(found, "robust") == "Perturbed views (3 views)"
    values = [float(each.scores["auc"] or 0) for each in passes[5:15]]
    assert found.aucs("b", "robust").tolist() == sorted(values)
    assert found.aucs("c", "robust").size == 0
    write_report(tmp_path, passes, [], Comparisons(), "Views")
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<h2>Perturbed views (3 views)</h2>" in page
    assert "## Perturbed views (3 views)" in (tmp_path / "summary.md").read_text().replace("\\", "")
    (figure,) = re.findall(r"<figure><h3>Spread</h3>.*?</figure>", page, flags=re.DOTALL)
    worst = {who: found.worst_tenth(who, "robust").mean for who in "ab"}
    assert [f"{who}: {worst[who]:.3f}" in figure for who in "ab"] == [True, True]
    assert "c: " not in re.sub("<svg.*</svg>", "", figure, flags=re.DOTALL)


def test_the_worst_tenth() -> None:
    # 12 passes: the worst tenth is the lowest two of them, rounded up.
    where = standing()
    passes = [
        outcome("a", where, trace(shifted([3.0 * i] * 20)), protocol="robust", label=f"{i:02d}")
        for i in range(12)
    ]
    values = sorted(float(each.scores["auc"] or 0) for each in passes)
    found = Evaluation(passes)
    assert found.worst_tenth("a", "robust").mean == pytest.approx(sum(values[:2]) / 2)
    assert found.per_start("a", "robust", "03").mean == passes[3].scores["auc"]
    assert values[0] < values[-1]
