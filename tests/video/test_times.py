"""Times of pictures: wrong stamps, lost pictures, and rates that are given or assumed."""

import itertools
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from clips import clip, picture
from motes import ConfigError, SourceError, open_source
from motes.video.film import Film
from motes.video.report import Report
from motes.video.times import AHEAD, timed

EVEN = [index / 25 for index in range(60)]
VARIABLE = np.cumsum(np.random.default_rng(0).uniform(0.01, 0.08, 60)).tolist()


def times(stamps: Sequence[float | None], ahead: int = AHEAD) -> tuple[list[float], int]:
    report = Report()
    pictures = ((stamp, lambda: picture(0)) for stamp in stamps)
    found = [moment for moment, _, _ in timed(pictures, 25, report, ahead=ahead)]
    assert report.decoded == len(stamps)
    assert (np.diff(found) > 0).all()
    return found, report.retimed


@pytest.mark.parametrize("stamps", [EVEN, VARIABLE], ids=["even", "variable"])
@pytest.mark.parametrize(
    "wrong",
    [
        {20: 10.0}, {20: 10.0, 21: 10.0, 22: 10.0}, {0: 10.0}, {20: None}, {20: 10.0, 40: -0.5},
        {57: 10.0},
    ],
)  # fmt: skip
def test_wrong_stamps_are_replaced_and_no_other(
    stamps: list[float], wrong: dict[int, float | None]
) -> None:
    given: list[float | None] = [*stamps]
    for index, shift in wrong.items():
        given[index] = None if shift is None else stamps[index] + shift
    found, replaced = times(given)
    origin = stamps[1] - 1 / 25 if 0 in wrong else stamps[0]
    right = np.array([index not in wrong for index in range(60)])
    assert np.array(found)[right] == pytest.approx((np.array(stamps) - origin)[right])
    if stamps is EVEN:
        assert found == pytest.approx(EVEN)
    assert replaced <= len(wrong)  # one may fit by chance where steps vary
    assert replaced == len(wrong) or stamps is VARIABLE


def test_of_two_equal_stamps_the_uneven_one_is_replaced() -> None:
    found, replaced = times([*EVEN[:20], EVEN[21], *EVEN[21:]])
    assert found == pytest.approx(EVEN)
    assert replaced == 1


def test_what_comes_live_is_not_waited_for() -> None:
    def coming() -> object:
        for stamp in EVEN:
            asked.append(stamp)
            yield stamp, lambda: picture(0)

    asked = list[float]()
    for count, _ in enumerate(timed(coming(), 25, Report()), start=1):  # type: ignore[arg-type]
        assert len(asked) == count


def test_an_error_comes_after_the_pictures_before_it() -> None:
    def broken() -> object:
        for stamp in EVEN[:5]:
            yield stamp, lambda: picture(0)
        raise SourceError("no more.")

    found = timed(broken(), 25, Report(), ahead=AHEAD)  # type: ignore[arg-type]
    assert len([*itertools.islice(found, 5)]) == 5
    with pytest.raises(SourceError):
        next(found)


def test_lost_pictures_count_as_lost(tmp_path: Path) -> None:
    path = clip(tmp_path / "whole.ts", 60)
    data = path.read_bytes()
    parts = [data[i : i + 188] for i in range(0, len(data), 188)]
    video = [number for number, part in enumerate(parts) if part[1] & 0x1F == 1 and part[2] == 0]
    gone = {*video[len(video) // 2 : len(video) // 2 + 9]}
    path.write_bytes(b"".join(part for number, part in enumerate(parts) if number not in gone))
    with open_source(path) as source:
        decoded = sum(1 for _ in source)
    assert decoded < 60
    assert source.report.lost == 60 - decoded
    assert f"{60 - decoded} picture(s) lost" in (source.report.problems or "")


def test_a_gap_of_an_undamaged_film_is_no_loss(tmp_path: Path) -> None:
    stamps = [40 * index for index in (0, 1, 2, 3, 9, 10, 11, 12)]
    with open_source(clip(tmp_path / "pause.mkv", len(stamps), times_ms=stamps)) as source:
        assert [frame.time for frame in source] == pytest.approx([each / 1000 for each in stamps])
    assert source.report.problems is None


def images(folder: Path, count: int = 5) -> Path:
    """Make a folder of images of a red box that walks one pixel a frame."""
    folder.mkdir(parents=True)
    for index in range(count):
        pixels = np.full((60, 80, 3), 90, np.uint8)
        pixels[20:40, 20 + index : 40 + index] = (230, 40, 40)
        Image.fromarray(pixels).save(folder / f"{index}.png")
    return folder


def rated(source: str | Path, fps: float | None = None) -> tuple[list[float], str | None]:
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
    found, assumption = rated(folder)
    assert found == pytest.approx([index / 7 for index in range(5)])
    assert assumption is None
    assert rated(f"{folder}/*.png")[0] == found
    assert rated(folder, fps=10)[0] == pytest.approx([index / 10 for index in range(5)])


@pytest.mark.parametrize("text", ["frameRate=0", "frameRate=fast", "[["])
def test_a_seqinfo_without_a_rate_is_refused_unless_one_is_given(tmp_path: Path, text: str) -> None:
    folder = images(tmp_path / "img1")
    (tmp_path / "img1" / "seqinfo.ini").write_text(f"[Sequence]\n{text}\n")
    with pytest.raises(SourceError, match=r"seqinfo\.ini"):
        open_source(folder)
    assert rated(folder, fps=10)[0][1] == 0.1


def test_what_is_assumed_is_in_the_report(tmp_path: Path) -> None:
    folder = images(tmp_path / "img")
    found, assumption = rated(folder)
    assert found[1] == 1 / 25
    assert "25 a second" in (assumption or "")
    assert rated(folder, fps=25)[1] is None
    assert rated(clip(tmp_path / "clip.mp4", 5))[1] is None
    pages = [Image.new("RGB", (8, 8), shade) for shade in ("red", "blue", "green")]
    pages[0].save(tmp_path / "pages.tif", save_all=True, append_images=pages[1:])
    assert rated(tmp_path / "pages.tif")[1] is not None
    assert rated(tmp_path / "pages.tif", fps=2) == ([0, 0.5, 1.0], None)
    pages[0].save(tmp_path / "one.tif")
    assert rated(tmp_path / "one.tif")[1] is None


@pytest.mark.parametrize(
    ("names", "said"),
    [
        ("f8 f9 f10 f11", None),
        ("f0 f5 f10 f15", None),
        ("f1 f2 f3 f4 f7 f8 f20", "f7.png comes after f4.png, and so 1 time more"),
        ("a1 a2 a3 b1 b2 b3", "b1.png comes after a3.png: all are read as one film"),
        ("cam1_1 cam1_2 cam1_3 cam2_1 cam2_2", "cam2_1.png comes after cam1_3.png:"),
        ("t1_c1 t1_c2 t2_c1 t2_c2 t3_c1 t3_c2", "t2_c1.png comes after t1_c2.png, and so 1 time"),
        ("f1_10.40 f2_10.44 f3_10.48", None),
        ("1714550400 1714550411 1714550413 1714550500", None),
        ("f1", None),
        ("beach garden house", None),
        ("f1 f2 f3 f4 logo", "logo.png comes after f4.png: all"),
    ],
)
def test_images_that_do_not_follow_each_other_are_said(
    tmp_path: Path, names: str, said: str | None
) -> None:
    for name in names.split():
        Image.new("RGB", (8, 8)).save(tmp_path / f"{name}.png")
    found = rated(tmp_path, fps=5)[1]
    assert (found is None) is (said is None)
    assert (said or "") in (found or "")


def test_a_rate_replaces_the_times_of_a_film(tmp_path: Path) -> None:
    film = clip(tmp_path / "clip.mp4", 12)
    assert rated(film, fps=100)[0] == pytest.approx([index / 100 for index in range(12)])
    with open_source(film, fps=100) as source:
        assert source.duration == pytest.approx(0.12)
    backward = [frame.time for frame in Film(film, fps=100).backward(8, 5)]
    assert backward == pytest.approx([0.08, 0.07, 0.06, 0.05])


def test_what_is_no_rate_is_refused(tmp_path: Path) -> None:
    folder = images(tmp_path / "img", 1)
    for read in (open_source, Film):
        for fps in (0, -1, math.nan, math.inf, 1e-9):
            with pytest.raises(ConfigError, match="fps is"):
                read(folder, fps=fps)
