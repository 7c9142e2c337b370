"""Frame rates: what a folder of images says, what is given, and what is assumed."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from clips import clip
from motes import open_source
from motes.core.errors import ConfigError, SourceError
from motes.video.film import Film


def images(folder: Path, count: int = 5) -> Path:
    """Make a folder of images of a red box that walks one pixel a frame."""
    folder.mkdir(parents=True)
    for index in range(count):
        pixels = np.full((60, 80, 3), 90, np.uint8)
        pixels[20:40, 20 + index : 40 + index] = (230, 40, 40)
        Image.fromarray(pixels).save(folder / f"{index}.png")
    return folder


def times(source: str | Path, fps: float | None = None) -> tuple[list[float], str | None]:
    with open_source(source, fps=fps) as film:
        found = [frame.time for frame in film]
        assert Film(source, fps=fps).times == found
        assert film.duration is None or film.duration == pytest.approx(
            len(found) / (film.fps or 25)
        )
        return found, film.report.assumption


@pytest.mark.parametrize("place", ["seq/seqinfo.ini", "seq/img1/seqinfo.ini"])
def test_the_rate_of_images_is_that_of_their_seqinfo(tmp_path: Path, place: str) -> None:
    folder = images(tmp_path / "seq" / "img1")
    (tmp_path / place).write_text("[Sequence]\nname=seq\nimDir=img1\nframeRate=7\n")
    found, assumption = times(folder)
    assert found == pytest.approx([index / 7 for index in range(5)])
    assert assumption is None
    assert times(f"{folder}/*.png")[0] == found
    assert times(folder, fps=10)[0] == pytest.approx([index / 10 for index in range(5)])


@pytest.mark.parametrize("text", ["frameRate=0", "frameRate=fast", "frameRate=inf", "[[", "="])
def test_a_seqinfo_without_a_rate_is_refused_unless_one_is_given(tmp_path: Path, text: str) -> None:
    folder = images(tmp_path / "img1")
    (tmp_path / "img1" / "seqinfo.ini").write_text(f"[Sequence]\n{text}\n")
    with pytest.raises(SourceError, match=r"seqinfo\.ini"):
        open_source(folder)
    assert times(folder, fps=10)[0][1] == 0.1


def test_what_is_assumed_is_in_the_report(tmp_path: Path) -> None:
    folder = images(tmp_path / "img")
    found, assumption = times(folder)
    assert found[1] == 1 / 25
    assert "25 a second" in (assumption or "")
    assert times(folder, fps=25)[1] is None
    assert times(clip(tmp_path / "clip.mp4", 5))[1] is None
    pages = [Image.new("RGB", (8, 8), shade) for shade in ("red", "blue", "green")]
    pages[0].save(tmp_path / "pages.tif", save_all=True, append_images=pages[1:])
    assert times(tmp_path / "pages.tif")[1] is not None
    assert times(tmp_path / "pages.tif", fps=2) == ([0, 0.5, 1.0], None)
    pages[0].save(tmp_path / "one.tif")
    assert times(tmp_path / "one.tif")[1] is None


def test_a_rate_replaces_the_times_of_a_film(tmp_path: Path) -> None:
    film = clip(tmp_path / "clip.mp4", 12)
    assert times(film, fps=100)[0] == pytest.approx([index / 100 for index in range(12)])
    with open_source(film, fps=100) as source:
        assert source.duration == pytest.approx(0.12)
    backward = [frame.time for frame in Film(film, fps=100).backward(8, 5)]
    assert backward == pytest.approx([0.08, 0.07, 0.06, 0.05])


@pytest.mark.parametrize("fps", [0, -1, math.nan, math.inf, 1e-9])
def test_what_is_no_rate_is_refused(tmp_path: Path, fps: float) -> None:
    folder = images(tmp_path / "img", 1)
    for read in (open_source, Film):
        with pytest.raises(ConfigError, match="fps is"):
            read(folder, fps=fps)
