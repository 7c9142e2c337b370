"""`motes track` in metres: columns, and options that do not fit."""

import csv
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from commands import Tell
from lens_files import lens_file
from motes.rows.reader import read_track
from motes.synthetic.clips import crowd

TRACK = "track film --init 40,30,20,30 --preset nummiaro -o rows.csv"


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a film of twelve images."""
    folder = tmp_path_factory.mktemp("film")
    for frame, _ in crowd((120, 90), (20, 30), 12):
        Image.fromarray(frame.pixels).save(folder / f"{frame.index}.png")
    return folder


@pytest.fixture
def go(film: Path, here: Path, capfd: pytest.CaptureFixture[str]) -> Tell:
    """Run motes in a folder with the film."""
    Path("film").symlink_to(film)
    return Tell(capfd)


def test_rows_have_places_and_speeds(go: Tell) -> None:
    assert go(f"{TRACK} --scale 20")[0] == 0
    rows = read_track("rows.csv")
    seen = rows["status"] == "tracking"
    assert seen.any()
    np.testing.assert_allclose(rows["x_m"][seen], rows["x"][seen] / 20, atol=1e-4)
    assert (rows["x_m_std"][seen][1:] > 0).all()
    assert np.isfinite(rows["speed"][seen][3:]).all()
    assert go("track film --init 40,30,20,30 --preset nummiaro -o plain.csv")[0] == 0
    old = list(csv.reader(Path("plain.csv").read_text().splitlines()))
    new = list(csv.reader(Path("rows.csv").read_text().splitlines()))
    assert [row[: len(old[0])] for row in new] == old
    assert new[0][len(old[0]) :] == ["x_m", "y_m", "x_m_std", "y_m_std", "speed", "speed_std"]
    assert go("convert rows.csv rows.jsonl")[0] == 0
    assert (read_track("rows.jsonl")["speed"][seen] == rows["speed"][seen])[3:].all()


def test_several_objects_have_their_own_metres(go: Tell) -> None:
    Path("lens.yml").write_text(lens_file())
    units = "--scale 20 --lens lens.yml"
    assert go(f"{TRACK} --init 70,40,20,30 {units}")[0] == 0
    assert go(f"{TRACK.replace('rows', 'one')} {units}")[0] == 0
    rows, one = read_track("rows.csv"), read_track("one.csv")
    assert np.isfinite(rows["x_m"]).all()
    first = rows[rows["id"] == 1]
    for name in ("x_m", "y_m", "x_m_std", "speed", "speed_std"):
        np.testing.assert_array_equal(first[name], one[name], err_msg=name)
    assert go("draw film rows.csv -o drawn.mp4")[0] == 0


def test_micrometres_are_kept(go: Tell) -> None:
    assert go(f"{TRACK} --scale 1e6")[0] == 0
    assert go("convert rows.csv rows.jsonl")[0] == 0
    for name in ("rows.csv", "rows.jsonl"):
        rows = read_track(name)
        seen = rows["status"] == "tracking"
        np.testing.assert_allclose(rows["x_m"][seen], rows["x"][seen] / 1e6, rtol=1e-4)
        assert (rows["x_m_std"][seen][1:] > 0).all()


def test_the_ground_and_the_lens_are_files(go: Tell) -> None:
    Path("ground.toml").write_text("[ground]\nhomography = [[0.05, 0, 0], [0, 0.05, 0], [0, 0, 1]]")
    Path("lens.yml").write_text(lens_file())
    assert go(f"{TRACK} --ground ground.toml --lens lens.yml")[0] == 0
    assert np.isfinite(read_track("rows.csv")["x_m"]).any()
    Path("other.yml").write_text(lens_file(size=(640, 90)))
    said = "The lens was calibrated at 640x90, and film has 120x90 pixels"
    go.says("convert rows.csv metres.csv --scale 20 --lens other.yml", 2, said)


def test_a_target_on_the_horizon_is_told_once(go: Tell) -> None:
    points = "[[0, 200, 0, 200], [100, 200, 100, 200], [0, 300, 0, 150], [100, 300, 50, 150]]"
    Path("far.toml").write_text(f"[ground]\npoints = {points}")  # its horizon is at y = 100
    said = go.says(f"{TRACK} --ground far.toml", 0, "Frame 0: object 1 is on the horizon of the ")
    assert said.count("horizon") == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        ("--scale 20 --ground g.toml", 2, "Give either --scale or --ground"),
        ("--scale 0", 2, "--scale is 0; give pixels per metre, from 1e-9"),
        ("--scale 20 --lens damaged.yml", 2, "The lens maps nothing to the middle of film"),
        ("--ground g.toml", 2, "g.toml: it has no [ground]"),
        ("--scale 20 --lens g.toml", 2, "g.toml: It has no camera_matrix"),
        ("--scale 20 --lens other.yml", 2, "calibrated at 640x480, and film has 120x90 pixels"),
        ("--scale 20 --lens other.yml --init 1,1,9,9", 2, "calibrated at 640x480, and film has"),
    ],
)
def test_errors_are_one_line(go: Tell, line: str, code: int, message: str) -> None:
    Path("g.toml").write_text("[[line]]\npoints = [0, 0, 9, 9]\n")
    Path("other.yml").write_text(lens_file(size=(640, 480)))
    Path("damaged.yml").write_text(lens_file(focal=1e-9, distortion=[-1e9, 0.0, 0.0, 0.0]))
    go.says(f"{TRACK} {line}", code, message, lines=1)
    assert not Path("rows.csv").exists()


def test_each_detection_has_its_own_metres(go: Tell) -> None:
    """Several of a frame have no identity; none has a speed."""
    Path("det.txt").write_text("1,-1,10,10,20,40,0.9,-1,-1,-1\n1,-1,110,50,20,40,0.9,-1,-1,-1\n")
    assert go("convert det.txt det.csv --from mot-detections --scale 10")[0] == 0
    found = read_track("det.csv")
    np.testing.assert_allclose(found["x_m"], found["x"] / 10)
    assert np.isnan(found["speed"]).all()


def test_how_large_a_scale_makes_the_picture_is_said(go: Tell) -> None:
    """So a scale in pixels per centimetre, or in metres per pixel, is seen at once."""
    large = "With 20 pixels per metre, the picture is 6 x 4.5 m.\n"
    assert go.says(f"{TRACK} --scale 20", 0, large).count(large) == 1
    large = "With 0.05 pixels per metre, the picture is 2400 x 1800 m."
    go.says("convert rows.csv metres.csv --video film --scale 0.05", 0, large)


@pytest.mark.parametrize(
    ("order", "share", "told"),
    [((0, 1, 2, 3), 1, False), ((2, 3, 0, 1), 1, True), ((0, 1, 2, 3), 0.01, True)],
)
def test_points_whose_metres_are_first_or_that_are_shares_are_pointed_out(
    order: tuple[int, ...], share: float, told: bool, go: Tell
) -> None:
    points = [(20, 20, 0, 0), (100, 20, 8, 0), (110, 80, 8, 12), (10, 80, 0, 12)]
    given = [(x * share, y * share, *metres) for x, y, *metres in points]
    text = str([[point[place] for place in order] for point in given])
    Path("ground.toml").write_text(f"[ground]\npoints = {text}\n")
    said = "; a point is [x, y, X, Y], pixels first, and no shares of the picture."
    go.says(f"{TRACK} --ground ground.toml", 0, said, told=told)
