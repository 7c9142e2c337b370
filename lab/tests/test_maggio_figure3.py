"""The weights of the cues on a film in which each cue fails."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from motes.core.errors import ConfigError
from motes.core.geometry import Ellipse
from motes.cues.base import Cue
from motes.cues.color import Color
from motes.cues.structure_tensor import Orientation
from motes_lab.cli import main
from motes_lab.papers import maggio_figure3
from motes_lab.papers.failing_cues import (
    FRAMES_OF_PART,
    PARTS,
    FilmPart,
    Shot,
    blue_light,
    failing_cues,
    frosted_glass,
)


@pytest.fixture(name="film", scope="module")
def _film() -> list[Shot]:
    return list(failing_cues())


def test_a_cue_fails_where_the_film_says_so(film: list[Shot]) -> None:
    """Distances of the true region, and of one beside it, from the model of the first frame."""
    cues: list[Cue] = [Color(bins=(10, 10, 10)), Orientation()]
    first = film[0]
    models = [cue.learn(first.frame, first.target) for cue in cues]
    for index, part in enumerate(PARTS):
        frame, found, target = film[index * FRAMES_OF_PART + FRAMES_OF_PART // 2]
        assert found is part
        beside = Ellipse(target.x + 25, target.y + 15, *target[2:])
        regions = np.array([target, beside])
        colors, edges = (
            cue.distances(model, frame, regions) for cue, model in zip(cues, models, strict=True)
        )
        assert (colors[1] - colors[0] > 0.1) == (part is not FilmPart.BLUE_LIGHT)
        assert (edges[0] < 0.5) == (part is not FilmPart.FROSTED_GLASS)


def test_blue_light_has_no_color_of_before() -> None:
    pixels = np.random.default_rng(0).integers(0, 256, (20, 30, 3), np.uint8)
    lit = blue_light(pixels)
    assert (lit[..., 0] == 0).all()
    assert (lit[..., 2] == 255).all()


def test_frosted_glass_moves_pixels_by_the_reach_at_most() -> None:
    y, x = np.mgrid[:20, :30].astype(np.uint8)
    moved = frosted_glass(np.stack([y, x, y], axis=2), np.random.default_rng(0), 3).astype(int)
    off = np.abs(moved[..., :2] - np.stack([y, x], axis=2))
    assert off.max() == 3


def test_the_weights_follow_within_10_frames(film: list[Shot]) -> None:
    *_, result = maggio_figure3.figure3(["maggio:C+O-A-SS-ROH"], [film], 2)
    assert result.share == 1
    (row,) = result.tables[""].rows
    name, runs, before, during, frames, clear, failed, until, error = (cell.value for cell in row)
    assert name is None
    assert runs == 2
    assert before is not None
    assert during is not None
    assert clear is not None
    assert failed is not None
    assert before - during > 0.1
    assert failed - clear > 0.1
    assert frames is not None
    assert until is not None
    assert max(frames, until) <= 10
    assert error is not None
    assert error < 0.3
    assert result.draw is not None
    (axes,) = result.draw().axes
    (line,) = axes.lines
    assert len(np.asarray(line.get_xdata())) == len(film)


def test_the_response_is_read_from_the_weights() -> None:
    clear, low = np.full(FRAMES_OF_PART, 0.5), np.full(FRAMES_OF_PART, 0.1)
    low[:4], low[5] = 0.5, 0.5  # below the middle in frame 4, and for 3 frames from frame 6 on
    weights = np.concatenate([clear, low, clear, clear - 0.2])
    before, during, frames = maggio_figure3.response(weights, 1)
    assert (before, frames) == (0.5, 6)
    assert during == pytest.approx(low.mean())
    assert maggio_figure3.response(weights, 3)[2] is None  # the wrong way


@pytest.mark.parametrize("name", ["nummiaro", "maggio:C", "ng_delp", "mean_shift"])
def test_presets_without_both_cues_are_refused(name: str) -> None:
    with pytest.raises(ConfigError, match="does not fuse color and orientation"):
        next(maggio_figure3.figure3([name], [], 1))


def test_the_command_writes_table_and_plot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, film: list[Shot]
) -> None:
    monkeypatch.setattr("motes_lab.papers.failing_cues.failing_cues", lambda seed: iter(film))
    line = [
        "maggio-figure3",
        "maggio:printed",
        "--seeds",
        "1",
        "--clips",
        "1",
        "--out",
        str(tmp_path),
    ]
    assert main(["experiment", *line]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {
        f"maggio-figure3.{ending}" for ending in ("md", "csv", "png")
    }
