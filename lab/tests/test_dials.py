"""Films with dials: the truth against the pixels, each dial against its promise, the tables."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from motes.core.errors import ConfigError, SourceError
from motes_lab.cli import main
from motes_lab.datasets.sot import Sequence, load_dataset
from motes_lab.dials import experiment
from motes_lab.dials.cutout import Cutout, Pose
from motes_lab.dials.dial_clips import clip_name, dial_clips, write_clip
from motes_lab.dials.dial_film import DialFilm, scene_of
from motes_lab.dials.dials import Dials
from motes_lab.dials.experiment import Grid, Measured
from motes_lab.dials.scenes import FilmMaterials, Garden, SceneMaterials

SIZE = (220, 180)
FRAMES = 13


def plain(color: tuple[int, int, int], seed: int = 0) -> SceneMaterials:
    """Return a scene with a target of one color, a rectangle of 60x40."""
    scene = scene_of(Garden(), seed, SIZE)
    matte = np.zeros((50, 70), np.float32)
    matte[5:45, 5:65] = 1
    return scene._replace(target=Cutout(np.full((50, 70, 3), color, np.uint8), matte))


SCENE = plain((200, 60, 60))


def film(scene: SceneMaterials = SCENE, /, **dials: float) -> DialFilm:
    return DialFilm(scene, Dials(**dials), 3, SIZE, FRAMES)


def shown(scene: SceneMaterials = SCENE, /, **dials: float) -> NDArray[np.float64]:
    """Return all frames of a film, (frames, H, W, 3)."""
    return np.array([frame.pixels for frame, _ in film(scene, **dials)], np.float64)


def boxes(**dials: float) -> NDArray[np.float64]:
    return np.array([truth.box for _, truth in film(**dials)])


@pytest.mark.parametrize(
    "dials", [{}, {"turn": 0.4}, {"growth": 1.0}, {"proportions": 0.7}, {"small": 0.6}]
)
def test_the_box_is_what_the_pixels_show(dials: dict[str, float]) -> None:
    colors = ((250, 0, 250), (0, 250, 0))
    one, other = (shown(plain(color), **dials) for color in colors)
    for index, (pixels, box) in enumerate(
        zip(np.abs(one - other).sum(axis=3), boxes(**dials), strict=True)
    ):
        y, x = np.nonzero(pixels > 375)
        seen = [x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1]
        assert np.abs(np.array(seen) - box).max() < 1.5, (index, seen, box)


def test_equal_arguments_give_equal_bytes_and_one_dial_changes_one_thing() -> None:
    assert (shown(motion=0.5) == shown(motion=0.5)).all()
    for dial in ("light", "shade", "blur", "noise", "gray", "texture", "distractors", "occlusion"):
        assert (boxes(**{dial: 1.0}) == boxes()).all(), dial
    assert (DialFilm(SCENE, Dials(), 4, SIZE, FRAMES)[0][0].pixels != film()[0][0].pixels).any()


def test_motion_growth_turn_and_size() -> None:
    def steps(**dials: float) -> float:
        found = boxes(**dials)
        centers = found[:, :2] + found[:, 2:] / 2
        return float(np.hypot(*np.diff(centers, axis=0).T).max())

    def sides(**dials: float) -> NDArray[np.float64]:
        side: NDArray[np.float64] = np.sqrt(boxes(**dials)[:, 2:].prod(axis=1))
        return side

    assert sides() == pytest.approx(np.full(FRAMES, 48), abs=0.01)
    assert steps() < 0.05 * 48
    assert 0.3 * 48 < steps(motion=1.0) < 0.85 * 48
    assert 0.2 * 48 < steps(shake=1.0) < 4 * 0.35 * 48
    assert sides(small=1.0) == pytest.approx(np.full(FRAMES, 8), abs=0.01)
    grown = sides(growth=1.0)
    assert max(grown[-1] / grown[0], grown[0] / grown[-1]) == pytest.approx(4)
    first, *_, last = boxes(proportions=1.0)
    assert abs(math.log(first[2] / first[3] * last[3] / last[2])) == pytest.approx(math.log(4))
    turned = boxes(turn=0.25)  # by a right angle
    assert turned[-1, 2:] == pytest.approx(turned[0, 3:1:-1])


def test_light_color_noise_and_blur() -> None:
    easy = shown()
    ratio = shown(light=1.0)[-1].mean() / easy[-1].mean()
    assert ratio == pytest.approx(0.2, abs=0.03) or ratio > 1.5
    gray = shown(gray=1.0)
    assert np.ptp(gray, axis=3).max() <= 1
    noise = shown(noise=1.0)[0] - easy[0]
    inside = (easy[0] > 100) & (easy[0] < 155)  # where it is not cut off
    assert noise[inside].std() == pytest.approx(40, rel=0.15)

    def sharpness(pixels: NDArray[np.float64]) -> float:
        return float(np.abs(np.diff(pixels, axis=1)).mean())

    blurred = shown(blur=1.0)
    assert sharpness(blurred[3]) < 0.6 * sharpness(blurred[0])
    assert sharpness(blurred[0]) == pytest.approx(sharpness(easy[0]))
    shade = shown(shade=1.0)
    assert within(shade, -1).mean() < 0.3 * within(easy, -1).mean()
    assert within(shade, 0).mean() > 0.9 * within(easy, 0).mean()


def within(pixels: NDArray[np.float64], index: int) -> NDArray[np.float64]:
    """Return the pixels (n, 3) in the box of the easy film."""
    x, y, width, height = np.rint(boxes()[index]).astype(int).tolist()
    return pixels[index, y + 2 : y + height - 2, x + 2 : x + width - 2].reshape(-1, 3)


def test_texture_camouflage_roll_and_distractors() -> None:
    scene = scene_of(Garden(), 5, SIZE)
    mean, deviation = (
        np.stack([change(scene.target.inside, axis=0) for _ in range(1)])[0]
        for change in (np.mean, np.std)
    )
    flat = film(scene, texture=1.0)._cast.target.inside
    assert flat.std(axis=0).max() < 0.1 * deviation.max()
    assert flat.mean(axis=0) == pytest.approx(mean, abs=1)
    hidden = film(scene, camouflage=1.0)._cast.target.inside
    behind = scene.background.reshape(-1, 3)
    assert hidden.mean(axis=0) == pytest.approx(behind.mean(axis=0), abs=8)
    half = shown(scene, roll=0.5)[-1] - shown(scene)[-1]
    assert np.abs(half).mean() > 0.5
    copies = film(distractors=1.0)._cast.copies
    assert len(film(distractors=1.0)._play.copies(0)) == len(copies) == 4
    assert all((copy.pixels == SCENE.target.pixels).all() for copy in copies)
    near = film(distractors=0.01)
    assert len(near._play.copies(0)) == 1
    assert (near._cast.copies[0].pixels != SCENE.target.pixels).any()
    assert film()._play.copies(0) == []


@pytest.mark.parametrize("share", [0.3, 0.6, 1.0])
def test_occlusion_covers_its_share(share: float) -> None:
    visible = np.array([truth.visible for _, truth in film(occlusion=share)])
    assert visible.min() == pytest.approx(1 - share, abs=0.08)
    assert (visible[[0, 1, 2, -1, -2]] == 1).all()
    assert (visible < 1 - share / 2).sum() >= FRAMES // 4


def test_a_cutout_is_drawn_where_its_box_is() -> None:
    matte = np.zeros((30, 20), np.float32)
    matte[10:20, 4:14] = 1
    cutout = Cutout(np.full((30, 20, 3), 255, np.uint8), matte)
    pose = Pose(31.5, 20.5, 2.0, 1.0)
    picture = np.zeros((40, 60, 3), np.float32)
    part, drawn = cutout.draw(picture, pose)
    y, x = np.nonzero(picture[:, :, 0] > 127)
    assert cutout.box(pose) == (20, 16, 20, 10)
    assert [x.min(), y.min(), np.ptp(x) + 1, np.ptp(y) + 1] == [20, 16, 20, 10]
    assert picture[part][:, :, 0] / 255 == pytest.approx(drawn)
    _, outside = cutout.draw(picture, pose._replace(x=-100))
    assert not outside.size


def test_clips_of_a_seed_share_the_easy_one(tmp_path: Path) -> None:
    made = dial_clips(["gray", "occlusion"], [0, 1], [2], size=SIZE, frames=FRAMES)
    clips = {clip.name: clip for clip in made}
    assert list(clips) == ["easy-2", "gray-1.00-2", "occlusion-1.00-2"]
    covered = clips["occlusion-1.00-2"]
    assert 0 < np.isnan(covered.boxes).any(axis=1).sum() < FRAMES / 2
    write_clip(covered, tmp_path)
    (read,), problems = load_dataset(tmp_path)
    assert problems == []
    assert read.name == covered.name
    np.testing.assert_allclose(read.boxes, covered.boxes, atol=0.001)
    pixels = np.asarray(Image.open(sorted((tmp_path / read.name / "img").iterdir())[0]))
    assert np.abs(pixels.astype(int) - covered.frames[0].pixels).mean() < 4


def test_wrong_dials_are_refused() -> None:
    with pytest.raises(ConfigError, match="did you mean motion"):
        list(dial_clips(["motoin"]))
    with pytest.raises(ConfigError, match="motion is 2; a dial goes from 0 to 1"):
        Dials(motion=2)
    with pytest.raises(ConfigError, match="too small"):
        DialFilm(SCENE, Dials(), 0, (100, 100))


def real_film(folder: Path, seed: int) -> Sequence:
    """Return a sequence of one frame: a disk with stripes before noise."""
    pixels = np.random.default_rng(seed).integers(60, 120, (260, 380, 3)).astype(np.uint8)
    y, x = np.ogrid[:260, :380]
    disk = np.hypot(x - 200, y - 120) < 30
    pixels[disk] = np.where((x // 5 % 2 == 0)[0, :, None], (230, 40, 30), (240, 200, 40))[
        np.nonzero(disk)[1]
    ]
    folder.mkdir()
    Image.fromarray(pixels).save(folder / "0001.png")
    boxes = np.array([[170.0, 90, 60, 60]])
    return Sequence(str(seed), folder, boxes, np.zeros((1, 5)))


def test_objects_are_cut_out_of_films(tmp_path: Path) -> None:
    from motes_lab.datasets.film_cutouts import cut_out

    films = [real_film(tmp_path / str(seed), seed) for seed in range(3)]
    found = cut_out(films)
    assert len(found.objects) == len(found.frames) == 3
    for each in found.objects.values():
        area = math.pi * 30**2
        assert each.matte.sum() == pytest.approx(area, rel=0.12)  # the border pixel is left out
        assert each.inside[:, 0].min() > 200  # no pixel of the background
        assert ((each.matte > 0.1) & (each.matte < 0.9)).sum() > 100
    scene = scene_of(found, 1, SIZE)
    frame, truth = DialFilm(scene, Dials(), 1, SIZE, FRAMES)[0]
    x, y = (round(v) for v in (truth.box.x + truth.box.width / 2, truth.box.y + 24))
    assert frame.pixels[y, x, 0] > 180
    whole = replace(films[0], boxes=np.array([[0.0, 0, 380, 260]]))
    thin = replace(films[0], boxes=np.array([[195.0, 0, 3, 260]]))
    with pytest.raises(SourceError, match="1 objects can be cut out"):
        cut_out([films[1], whole, thin])
    with pytest.raises(SourceError, match="1 objects can be cut out"):
        cut_out(films[:1])


def test_an_object_is_never_before_its_own_film() -> None:
    films = {str(i): np.full((200, 300, 3), 40 * i, np.uint8) for i in range(3)}
    found = FilmMaterials(dict.fromkeys("01", SCENE.target) | {"2": SCENE.back}, films)
    for seed in range(20):
        scene = scene_of(found, seed, SIZE)
        assert scene.target is SCENE.target or scene.background.max() < 80


def by_hand(*names: str) -> Measured:
    """Return results in which the first tracker loses 0.2 and 0.4 with the dial, others half."""
    grid = Grid(("light", "noise"), (0.0, 0.5, 1.0), 2)
    aucs = {
        name: {
            clip_name(dial, level, scene): 0.9 - 0.4 * level / (1 + i) - 0.1 * scene
            for dial in grid.dials
            for level in grid.levels
            for scene in range(2)
        }
        for i, name in enumerate(names)
    }
    return Measured(grid, names, aucs)


def test_tables_of_dials() -> None:
    nano = "cv2:nano=a.onnx,b.onnx"
    now = by_hand("default", nano)
    table = experiment.means(now)
    assert table.head == ("dial", "default", "cv2:nano", "default minus cv2:nano")
    rows = {row[0].text: [cell.value for cell in row[1:]] for row in (*table.rows, *table.foot)}
    assert list(rows) == ["easy", "light", "noise", "mean of the dials"]
    assert rows["easy"] == pytest.approx([0.85, 0.85, 0])
    assert rows["light"] == pytest.approx([0.55, 0.7, -0.15])
    assert rows["mean of the dials"] == pytest.approx([0.55, 0.7, -0.15])
    assert table.rows[1][3].text == "-0.150 (-0.150 to -0.150)"
    assert len(experiment.levels(now).rows) == 6
    assert experiment.levels(now).rows[2][2].value == pytest.approx(0.45)


def test_dials_on_the_command_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(experiment, "DIALS", ("gray",))
    out, films = tmp_path / "out", tmp_path / "films"
    words = "experiment dials --tracker mean_shift --scenes 1 --frames 10"
    line = [*words.split(), "--out", str(out), "--films", str(films)]
    code = main(line)
    printed = capfd.readouterr()
    assert code == 0, printed.err
    assert {path.name for path in films.iterdir()} == {"easy-0", "gray-0.50-0", "gray-1.00-0"}
    rows = [*csv.DictReader(io.StringIO((out / "dials-levels.csv").read_text()))]
    assert [row["level"] for row in rows] == ["0", "0.5", "1"]
    assert float(rows[0]["mean_shift"]) > 0.3
    assert (out / "dials.png").stat().st_size > 1000
    assert main([*words.split(), "--films", str(films)]) == 5
    run = ["--tracker", "mean_shift", "--workers", "1", "--out", str(tmp_path / "run")]
    assert main(["evaluate", str(films), *run]) == 0
    again = tmp_path / "again"
    code = main(["experiment", "dials", "--evaluated", run[-1], "--out", str(again)])
    assert code == 0
    assert (again / "dials-levels.csv").read_text() == (out / "dials-levels.csv").read_text()
    assert main([*words.split(), "--frames", "2"]) == 2
