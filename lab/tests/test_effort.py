"""The simulated annotator: with a tracker, and with interpolation."""

from pathlib import Path

import numpy as np
import pytest

import arena
from in_process import work_here
from motes import Ellipse, preset
from motes.correction import run_pass
from motes.synthetic import occluded
from motes.video import Film as Reader
from motes_lab.cli import main
from motes_lab.effort.annotator import annotate, annotate_equidistant
from motes_lab.effort.methods import (
    Film,
    Keyframes,
    Path as Rows,
    equidistant,
    forward_only,
    interpolated,
    smoothed,
)

FRAMES = 30


@pytest.fixture(scope="module")
def sequence(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a sequence whose target goes back and forth."""
    folder = tmp_path_factory.mktemp("dataset") / "walk"
    arena.write_sequence(folder, occluded((96, 72), frames=FRAMES))
    return folder


def film(sequence: Path) -> Film:
    reader = Reader(sequence / "img")
    return Film(reader, reader.frames, preset("mean_shift"))


def test_every_method_is_exact_at_keyframes(sequence: Path) -> None:
    work = film(sequence)
    keys = {0: Ellipse(30, 30, 8, 6), 12: Ellipse(40, 32, 9, 7), 20: None}
    for method in (smoothed, forward_only, interpolated):
        path = method(work, keys)
        assert path.ellipses.shape == path.variances.shape == (FRAMES, 5)
        for frame in (0, 12):
            assert path.ellipses[frame] == pytest.approx(keys[frame])
            assert path.variances[frame] == pytest.approx(np.zeros(5), abs=1e-6)
    assert path.ellipses[6] == pytest.approx([35, 31, 8.5, 6.5, 0])
    assert path.ellipses[25] == pytest.approx([40, 32, 9, 7, 0])
    assert path.variances[6, 0] > path.variances[1, 0] > 0


@pytest.mark.slow
def test_stretches_are_computed_once(sequence: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A new keyframe needs only the passes between its neighbors."""
    runs: list[int] = []

    def counted(config, seed, frames, region, **options):  # type: ignore[no-untyped-def]
        tracks = run_pass(config, seed, frames, region, **options)
        runs.append(len(tracks))
        return tracks

    monkeypatch.setattr("motes.correction.correct.run_pass", counted)
    work = film(sequence)
    keys = {0: Ellipse(30, 30, 8, 6), 29: Ellipse(30, 30, 8, 6)}
    before = smoothed(work, keys)
    assert runs == [30, 30]
    middle = smoothed(work, {0: keys[0], 10: Ellipse(35, 30, 8, 6), 29: keys[29]})
    assert runs == [30, 30, 11, 11, 20, 20]
    smoothed(work, keys)
    assert len(runs) == 6
    assert middle.ellipses[0] == pytest.approx(before.ellipses[0])
    fresh = smoothed(film(sequence), {0: keys[0], 10: Ellipse(35, 30, 8, 6), 29: keys[29]})
    assert middle.ellipses == pytest.approx(fresh.ellipses)


def test_the_annotator_stops_when_enough_is_right(sequence: Path) -> None:
    work = film(sequence)
    truth = np.tile([20.0, 20, 16, 12], (FRAMES, 1))
    truth[:, 0] += 0.4 * np.arange(FRAMES)  # straight: two keyframes are enough
    asked: list[list[int]] = []

    def method(work: Film, keys: Keyframes) -> Rows:
        asked.append([*keys])
        return interpolated(work, keys)

    effort = annotate(work, truth, method)
    assert asked[0] == [0]
    assert effort.corrections == len(asked) - 1 <= 3
    assert annotate_equidistant(work, truth).corrections == 1
    truth[10:20] = np.nan
    assert annotate_equidistant(work, truth).corrections == 1
    assert equidistant(range(5, 26), 2) == [5, 15, 25]


@pytest.mark.slow
def test_the_command(
    sequence: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    work_here(monkeypatch)
    out = tmp_path / "out"
    line = f"experiment effort {sequence.parent} --out {out}"
    assert main(line.split()) == 0
    said = capsys.readouterr().out
    assert "motes smoothed" in said
    assert "interpolation, equidistant" in said
    assert sorted(path.name for path in out.iterdir()) == [
        "effort-means.csv", "effort-sequences.csv", "effort.md",
    ]  # fmt: skip
