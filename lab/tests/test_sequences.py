"""Datasets written by hand in every layout, against boxes worked by hand, and the real ones."""

import math
import shutil
from collections.abc import Callable, Sequence as Rows
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray
from PIL import Image

from motes import ConfigError, Ellipse, SourceError, Tracker, TrackWriter, open_source
from motes.cli import main as motes_main
from motes.formats import ABSENT, TruthRegion, read_regions
from motes_lab.datasets.sot import Problem, Sequence, load_dataset
from motes_lab.datasets.truth import read_mask
from oracles import radii

NAN = [math.nan] * 4
ROW = "1,1,5,5\n"


def frames(folder: Path, names: Rows[str] | int = 2) -> None:
    """Write small pictures, 00000001.jpg … or of these names."""
    folder.mkdir(parents=True, exist_ok=True)
    if isinstance(names, int):
        names = [f"{number:08}.jpg" for number in range(1, names + 1)]
    for number, name in enumerate(names):
        Image.new("RGB", (32, 24), (number, 0, 0)).save(folder / name)


def otb(folder: Path, truth: str, count: int = 2) -> Path:
    frames(folder / "img", count)
    (folder / "groundtruth_rect.txt").write_text(truth)
    return folder


def load(path: Path, first_pixel: dict[str, int] | None = None) -> Sequence:
    """Load a dataset of one sequence and no problem."""
    sequences, problems = load_dataset(path, first_pixel or {})
    assert not problems
    (sequence,) = sequences
    return sequence


def refusal(path: Path, annotation: Path | None = None) -> str:
    """Return what is wrong with a dataset of one sequence."""
    sequences, problems = load_dataset(path, annotation=annotation)
    assert not sequences
    (problem,) = problems
    assert problem.where.startswith("sequence ")
    assert "\n" not in problem.what
    return problem.what


def only(text: str) -> TruthRegion:
    (region,) = read_regions(text)
    return region


@pytest.mark.parametrize(
    "row",
    [
        *["NaN,NaN,NaN,NaN", "nan", "0,0,0,0", "5,5,0,9", "5,5,9,0", "5,5,-3,9"],
        *["0", "NaN,NaN,NaN,NaN,NaN,NaN,NaN,NaN", "0,0,0,0,0,0,0,0"],
        *["3,4,9,4,9,4,3,4", "m0,0,0,0,0", "m3,4,2,2,4", "m3,4,2,2"],
    ],
)
def test_rows_without_target(row: str) -> None:
    assert only(row) is ABSENT


@pytest.mark.parametrize("code", ["1", "2"])
def test_codes_of_results_tell_no_place(code: str) -> None:
    assert np.isnan(only(code).box).all()
    assert np.isnan(only(code).ellipse).all()


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("1,2,3", "not 3"),
        ("1,b,3,4", "'b' is not a number"),
        ("1,2,nan,4", "finite"),
        ("31,5;61,5;40,0;40,0", "separated in two ways"),
        ("m1,2,3", "whole numbers"),
        ("m1,2,2,2,1,4", "do not fit into its 2x2"),
        ("0,0,4,4,4,0,0,4", "crosses itself"),
        ("1e300,0,5,5", "is too large a number"),
    ],
)
def test_rows_that_are_none(tmp_path: Path, row: str, said: str) -> None:
    what = refusal(otb(tmp_path / "A", f"1,2,3,4\n\n{row}\n"))
    assert what.startswith("groundtruth_rect.txt, line 3: ")
    assert said in what


def rectangle(
    center: tuple[float, float], half: tuple[float, float], angle: float
) -> NDArray[np.float64]:
    """Return the corners (4, 2) of a turned rectangle."""
    along = np.array([math.cos(angle), math.sin(angle)])
    across = np.array([-along[1], along[0]])
    signs = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    return np.array([center + s * half[0] * along + t * half[1] * across for s, t in signs])


def written(corners: NDArray[np.float64]) -> str:
    return ",".join(str(value) for value in corners.ravel().tolist())


@given(
    st.tuples(*[st.floats(-500, 2000)] * 2, *[st.floats(0.5, 900)] * 2).map(
        lambda box: tuple(round(value, 2) for value in box)
    )
)
def test_a_box_is_the_same_as_a_polygon(box: tuple[float, float, float, float]) -> None:
    x, y, width, height = box
    corners = [(x, y + height), (x, y), (x + width, y), (x + width, y + height)]
    region = only(written(np.array(corners)))
    np.testing.assert_allclose(region.box, box, atol=1e-6)
    ellipse = Ellipse.from_box(box)
    if abs(width - height) > 1e-3:
        np.testing.assert_allclose(region.ellipse, ellipse, rtol=1e-6, atol=1e-6)
    else:  # a circle has no angle
        np.testing.assert_allclose(region.ellipse[:4], ellipse[:4], rtol=1e-3, atol=1e-6)


def test_four_corners_that_are_no_rectangle_keep_their_area() -> None:
    region = only("0,0,60,10,70,50,5,30")
    assert 4 * region.ellipse.a * region.ellipse.b == pytest.approx((2300 + 1850) / 2)  # shoelace
    assert region.box == (0, 0, 70, 50)


TURNED = Ellipse(150.0, 90.0, 80.0, 30.0, 0.4)


def test_an_ellipse_is_found_again_in_its_outline_and_mask(tmp_path: Path) -> None:
    outline = only(written(TURNED.polygon(400) + 0.5))
    np.testing.assert_allclose(outline.ellipse, TURNED, rtol=1e-3)
    Image.fromarray(radii((200, 300), TURNED)[1] <= 1).save(tmp_path / "1.png")
    mask = read_mask(tmp_path / "1.png")
    np.testing.assert_allclose(mask.ellipse, TURNED, rtol=2e-3)
    np.testing.assert_allclose(outline.box, mask.box, atol=1)


def decoded(row: str) -> set[tuple[int, int]]:
    """Return the pixels (x, y) of a mask in VOT's form, one after the other."""
    x, y, width, _, *runs = (int(value) for value in row[1:].split(","))
    pixels, place, inside = set(), 0, False
    for run in runs:
        for _ in range(run):
            if inside:
                pixels.add((x + place % width, y + place // width))
            place += 1
        inside = not inside
    return pixels


@given(st.data())
def test_runs(data: st.DataObject) -> None:
    width, height = data.draw(st.integers(1, 7)), data.draw(st.integers(1, 7))
    runs: list[int] = []
    while (rest := width * height - sum(runs)) and len(runs) < 9:
        runs.append(data.draw(st.integers(0, rest)))
    row = f"m{data.draw(st.integers(-3, 9))},5,{width},{height}," + ",".join(map(str, runs))
    pixels = decoded(row)
    region = only(row)
    if not pixels:
        assert region is ABSENT
        return
    x, y = np.array(sorted(pixels)).T
    assert region.box == (x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1)
    assert region.ellipse[:2] == pytest.approx((x.mean(), y.mean()))
    a, b, theta = region.ellipse[2:]
    turn = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
    moments = turn @ np.diag([a * a, b * b]) @ turn.T / 4
    expected = np.cov(x, y, bias=True) + np.eye(2) / 12
    np.testing.assert_allclose(moments, expected, atol=1e-9)
    assert abs(theta) <= math.pi / 4 + 1e-12


@pytest.mark.parametrize("mode", ["1", "L", "P", "RGB", "RGBA", "LA", "I;16"])
def test_mask_pictures(tmp_path: Path, mode: str) -> None:
    mask = np.zeros((20, 30), np.uint8)
    mask[4:9, 7:17] = 3
    if mode in ("L", "P"):
        picture = Image.fromarray(mask)
        if mode == "P":
            picture.putpalette([0, 0, 0] * 256)  # what a palette shows does not matter
    elif mode == "I;16":
        picture = Image.fromarray(mask.astype(np.uint16) * 500)
    else:
        picture = Image.fromarray(mask * 85).convert(mode)
    assert picture.mode == mode
    picture.save(tmp_path / "1.png")
    assert read_mask(tmp_path / "1.png").box == (7, 4, 10, 5)


@pytest.mark.parametrize("mark", ["color", "sequence", "camera_motion.tag"])
def test_vot_is_zero_based(tmp_path: Path, mark: str) -> None:
    folder = tmp_path / "ball"
    frames(folder / "color" if mark == "color" else folder, 3)
    if mark != "color":
        (folder / mark).touch()
    (folder / "groundtruth.txt").write_text("1\n10,20,30,40\n0\n")
    sequence = load(folder)
    np.testing.assert_array_equal(sequence.boxes, [NAN, [10, 20, 30, 40], NAN])
    with open_source(sequence.source) as source:
        assert source.frame_count == 3


def test_got10k_is_one_based_and_has_absence(tmp_path: Path) -> None:
    folder = tmp_path / "GOT-10k_Val_000001"
    frames(folder, 3)
    (folder / "groundtruth.txt").write_text("11.5,21,30,40\n12,22,30,40\n13,23,30,40\n")
    (folder / "absence.label").write_text("0\n1\n0\n")
    sequence = load(tmp_path)
    np.testing.assert_array_equal(sequence.boxes, [[10.5, 20, 30, 40], NAN, [12, 22, 30, 40]])
    assert np.isnan(sequence.ellipses[1]).all()
    (folder / "absence.label").write_text("0\n1\n")
    assert refusal(tmp_path) == "absence.label is for 2 frames, not 3"


def masks(folder: Path, count: int, ending: str = "png") -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number in range(count):
        mask = np.zeros((24, 32), np.uint8)
        mask[5:15, 8 + number : 20 + number] = number != 1
        Image.fromarray(mask).save(folder / f"{number:05}.{ending}")


def test_masks(tmp_path: Path) -> None:
    frames(tmp_path / "swan" / "img", 12)
    masks(tmp_path / "swan" / "masks", 12)
    boxes = load(tmp_path, {"*": 1}).boxes  # pictures have no first pixel
    np.testing.assert_array_equal(boxes[[0, 1, 11]], [[8, 5, 12, 10], NAN, [19, 5, 12, 10]])
    annotated, problems = load_dataset(
        tmp_path / "swan" / "img", annotation=tmp_path / "swan" / "masks"
    )
    assert not problems
    np.testing.assert_array_equal(annotated[0].boxes, boxes)


def test_first_pixel_by_pattern(tmp_path: Path) -> None:
    for name in ("seg-a", "seg-b", "c"):
        otb(tmp_path / name, "10,10,5,5\n" * 2)

    def lefts(first_pixel: dict[str, int]) -> dict[str, float]:
        sequences, problems = load_dataset(tmp_path, first_pixel)
        assert not problems
        return {s.name: s.boxes[0, 0] for s in sequences}

    assert lefts({}) == {"c": 9, "seg-a": 9, "seg-b": 9}
    assert lefts({"seg-*": 0}) == {"c": 9, "seg-a": 10, "seg-b": 10}
    assert lefts({"*": 0, "seg-b": 1}) == {"c": 10, "seg-a": 10, "seg-b": 9}
    with pytest.raises(ConfigError, match="'sge-\\*' fits no sequence"):
        lefts({"sge-*": 0})
    with pytest.raises(ConfigError, match="is 2; it is 0 or 1"):
        lefts({"seg-*": 2})


def test_names_that_meet(tmp_path: Path) -> None:
    otb(tmp_path / "A" / "unused", "")
    frames(tmp_path / "A")
    (tmp_path / "A" / "groundtruth_rect.1.txt").write_text("1,1,5,5\n" * 2)
    otb(tmp_path / "A-1", "2,2,5,5\n" * 2)
    sequences, problems = load_dataset(tmp_path)
    assert [s.name for s in sequences] == ["A-1"]
    assert sequences[0].boxes[0, 0] == 0
    assert problems == [Problem("sequence A-1", "there are two of this name; rename one")]


def test_pictures_that_cannot_be_kept_apart(tmp_path: Path) -> None:
    frames(tmp_path, 3)
    (tmp_path / "groundtruth.txt").write_text("1,1,5,5\n" * 3)
    Image.new("RGB", (5, 5)).save(tmp_path / "0_mask.jpg")
    assert refusal(tmp_path).startswith("0_mask.jpg is among the frames")
    frames(tmp_path, ["1.png", "2.png", "3.png"])
    assert "frames are either like" in refusal(tmp_path)


def test_a_sequence_in_a_relative_folder_of_digits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    frames(tmp_path / "0")
    (tmp_path / "0" / "groundtruth.txt").write_text("1,1,5,5\n" * 2)
    monkeypatch.chdir(tmp_path)
    with open_source(load(Path()).source) as source:  # not camera 0
        assert source.frame_count == 2
    monkeypatch.chdir(tmp_path / "0")
    assert load(Path()).name == "0"


def test_films_with_the_truth_beside_them(tmp_path: Path) -> None:
    """Beside a sequence of OTB, whose pixels count from 1, and what is none."""
    otb(tmp_path / "David", "11,21,30,40\nNaN,NaN,NaN,NaN\n")
    others = ("README.md", "code/main.py", ".thumbnails/1.jpg")
    for name in ("cup.mp4", "alone.mp4", ".hidden", *others):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "cup.txt").write_text("3,4,5,6\nNaN,NaN,NaN,NaN\n4,4,5,6\n")
    sequences, problems = load_dataset(tmp_path)
    assert not problems
    assert [sequence.name for sequence in sequences] == ["David", "cup"]
    david, film = sequences
    assert david.source == tmp_path / "David" / "img"
    np.testing.assert_array_equal(david.boxes, [[10, 20, 30, 40], NAN])
    np.testing.assert_array_equal(david.ellipses[0], [24.5, 39.5, 15, 20, 0])
    assert np.isnan(david.ellipses[1]).all()
    assert Path(film.source) == tmp_path / "cup.mp4"
    assert film.boxes[[0, 2]].tolist() == [[3, 4, 5, 6], [4, 4, 5, 6]]  # 0-based
    assert np.isnan(film.boxes[1]).all()


@pytest.mark.parametrize("form", ["csv", "jsonl"])
def test_annotation_by_motes_track(tmp_path: Path, form: str) -> None:
    frames(tmp_path / "clip", 6)
    path = tmp_path / f"track.{form}"
    ellipse = Ellipse(15, 12, 6, 4, 0.25)
    with TrackWriter(path) as writer, open_source(tmp_path / "clip") as source:
        tracker = Tracker("mean_shift")
        first = next(source)
        track = tracker.init(first, ellipse)
        writer.write(0, 0.0, track)
        writer.write(2, 0.1, None)  # searching; frame 1 was left out, as by a stride
        writer.write(5, 0.2, track)
    sequence = load_dataset(tmp_path / "clip", annotation=path)[0][0]
    assert sequence.boxes.shape == (6, 4)
    np.testing.assert_allclose(sequence.ellipses[[0, 5]], [ellipse] * 2, atol=1e-3)
    np.testing.assert_allclose(sequence.boxes[0], ellipse.box, atol=1e-2)
    assert np.isnan(sequence.boxes[1:5]).all()
    path.write_text(path.read_text().replace("tracking", "lost", 1))
    sequence = load_dataset(tmp_path / "clip", annotation=path)[0][0]
    assert np.isnan(sequence.boxes[0]).all()


def test_rows_of_another_film_are_no_annotation(tmp_path: Path) -> None:
    """What is remembered beside them tells of which."""
    frames(tmp_path / "clip", 6)
    other = tmp_path / "other"
    other.mkdir()
    for index in range(6):
        Image.new("RGB", (99, 50)).save(other / f"{index}.png")
    path = tmp_path / "rows.csv"
    options = ["--preset", "mean_shift", "-o", str(path)]
    assert motes_main(["track", str(other), "--init", "5,5,20,20", *options]) == 0
    assert "but the rows are of other, with 99x50" in refusal(tmp_path / "clip", path)
    assert len(load_dataset(other, annotation=path)[0]) == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("frame,x,y,a,b\n1,2,3,4,5\n", "a track has the column theta"),
        ("frame,x,y,a,b,theta\n1,2,3,4\n", "row 1 has 4 fields instead of 6"),
        ("frame,x,y,a,b,theta\n0,2,3,4,5,0\n0,2,3,4,5,0\n", "has a frame twice"),
        ("frame,x,y,a,b,theta\n1e999,2,3,4,5,0\n", "row 1: frame: "),
        ("frame,x,y,a,b,theta\n", "has no frame with a target"),
        ('{"frame": 0, "x": 1}\n', "a track has the column y"),
        ("[1]", "line 1: "),
    ],
)
def test_annotation_that_is_none(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "a.mp4").touch()
    (tmp_path / "a.csv").write_text(text)
    what = refusal(tmp_path / "a.mp4", tmp_path / "a.csv")
    assert what.startswith("a.csv")
    assert said in what


TRUTH = "groundtruth_rect.txt"
Spoil = Callable[[Path], object]


def saying(text: str) -> Spoil:
    """Return what writes another truth."""
    return lambda folder: (folder / TRUTH).write_text(text, encoding="latin-1")


def nothing(folder: Path) -> None:
    """Leave a sequence as it is."""


def one_bad_mask(folder: Path) -> None:
    masks(folder / "masks", 4)
    (folder / "masks" / "00002.png").write_bytes(b"none")


@pytest.mark.parametrize(
    ("gone", "spoil", "what"),
    [
        ("", saying(ROW * 3), f"{TRUTH} is for 3 frames, but there are 4"),
        ("", saying("0,0,0,0\n" * 4), f"{TRUTH} has no frame with a target"),
        ("", saying("\xff\xfe1\x00"), "it is not text; save it as UTF-8"),
        (TRUTH, nothing, f"it has no truth; add {TRUTH}"),
        (TRUTH, lambda bad: (bad / TRUTH).mkdir(), f"there are no pictures in {TRUTH}/"),
        ("img/00000003.jpg", nothing, "the frame 00000003.jpg is missing after 00000002.jpg"),
        ("img", nothing, "there are no pictures in bad/"),
        (
            TRUTH,
            lambda bad: masks(bad / "masks", 4, "jpg"),
            "the mask 00000.jpg is JPEG, which alters zeros; save masks as PNG",
        ),
        (TRUTH, one_bad_mask, "the mask 00002.png cannot be read; replace it"),
        (TRUTH, lambda bad: masks(bad / "masks", 3), "masks is for 3 frames, but there are 4"),
    ],
)
def test_a_bad_sequence_is_named_and_the_others_go_on(
    tmp_path: Path, gone: str, spoil: Spoil, what: str
) -> None:
    bad = otb(tmp_path / "bad", ROW * 4, 4)
    for path in map(bad.joinpath, gone.split()):
        shutil.rmtree(path) if path.is_dir() else path.unlink()
    spoil(bad)
    otb(tmp_path / "good", ROW * 2)
    sequences, problems = load_dataset(tmp_path)
    assert [s.name for s in sequences] == ["good"]
    (problem,) = problems
    assert problem.where == "sequence bad"
    assert what in problem.what


def test_nothing_to_load(tmp_path: Path) -> None:
    with pytest.raises(SourceError, match=r"There is no file or folder .*nowhere; check the name"):
        load_dataset(tmp_path / "nowhere")
    with pytest.raises(SourceError, match=r"There is no sequence in .*groundtruth_rect\.txt"):
        load_dataset(tmp_path)
    (tmp_path / "a.mp4").touch()
    with pytest.raises(SourceError, match=r"a\.mp4 is one file; give the truth"):
        load_dataset(tmp_path / "a.mp4")
    with pytest.raises(SourceError, match=r"no file or folder .*b\.txt"):
        load_dataset(tmp_path / "a.mp4", annotation=tmp_path / "b.txt")
    frames(tmp_path)  # pictures alone are no dataset
    with pytest.raises(SourceError, match="There is no sequence"):
        load_dataset(tmp_path)
    (tmp_path / "list.txt").write_bytes(b"\xff\xfe")
    with pytest.raises(SourceError, match=r"list\.txt cannot be read: it is not text"):
        load_dataset(tmp_path)


def test_real_sequences(data: Path) -> None:
    sequences, problems = load_dataset(data / "sot", {"seg-*": 0})
    assert not problems
    by_name = {sequence.name: sequence for sequence in sequences}
    assert len(by_name) == 24
    absent = {name: int(np.isnan(s.boxes).any(axis=1).sum()) for name, s in by_name.items()}
    assert {name: count for name, count in absent.items() if count} == {"tld-pedestrian3": 28}
    assert by_name["David"].boxes.shape == (471, 4)
    assert by_name["David"].boxes[0].tolist() == [128, 79, 64, 78]
    assert by_name["seg-swan"].boxes[0].tolist() == [67, 38, 187, 153]
    for sequence in sequences:
        there = np.isfinite(sequence.boxes[:, 0])
        assert there[0]
        np.testing.assert_array_equal(np.isfinite(sequence.ellipses).all(axis=1), there)
        boxes = [Ellipse(*row).box for row in sequence.ellipses[there]]
        np.testing.assert_allclose(boxes, sequence.boxes[there], atol=1e-9)
        with open_source(sequence.source) as source:
            assert source.frame_count == len(sequence.boxes)
