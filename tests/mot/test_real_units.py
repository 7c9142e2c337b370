"""Places in metres, speeds and lenses, against OpenCV, sampling and known motion."""

import math

import numpy as np
import pytest
from msgspec.structs import replace

from forks import in_a_child
from lens_files import lens_file
from motes import ConfigError, Ellipse, EventCounter, Ground, Regions, Status, Track
from motes.core.track import GROUND
from motes.mot.analytics.lens import Lens
from motes.mot.analytics.real_units import (
    GroundMotion,
    RealUnits,
    motion_in_hindsight,
    place_of,
    seen_live,
)
from sightings import seen, told

MATRIX = (500.0, 0.0, 320.0, 0.0, 480.0, 240.0, 0.0, 0.0, 1.0)
DISTORTIONS = {
    4: (-0.3, 0.12, 0.001, -0.002),
    5: (-0.3, 0.12, 0.001, -0.002, -0.02),
    8: (0.4, -0.2, 0.001, -0.002, 0.05, 0.7, -0.1, 0.02),
}
COVARIANCE = np.diag([4.0, 1.0, 0.5, 0.5, 1e-4])
COVARIANCE[:2, :2] += 0.3


def track(
    frame: int, x: float, y: float, status: Status = Status.TRACKING, covariance: float = 1.0
) -> Track:
    ellipse = Ellipse(x, y, 20.0, 12.0, 0.2)
    return Track(frame, frame / 25, ellipse, COVARIANCE * covariance, 0.9, status, 0.1, 99.0)


@pytest.mark.parametrize("count", DISTORTIONS)
def test_a_lens_is_that_of_opencv(count: int) -> None:
    cv2 = pytest.importorskip("cv2", reason="OpenCV is not installed")
    matrix, distortion = np.reshape(MATRIX, (3, 3)), np.array(DISTORTIONS[count])
    rng = np.random.default_rng(0)
    rays = np.hstack([rng.uniform(-0.5, 0.5, (50, 2)), np.ones((50, 1))])
    seen, _ = cv2.projectPoints(rays, np.zeros(3), np.zeros(3), matrix, distortion)
    lens = Lens(MATRIX, DISTORTIONS[count])
    for ray, pixel in zip(rays @ matrix.T, seen[:, 0].tolist(), strict=True):
        place = lens.undistorted((pixel[0], pixel[1]))
        assert place == pytest.approx(ray[:2], abs=1e-6)


LENS = lens_file(focal=9.0, distortion=[0.0] * 5, size=(640, 480))


def test_a_lens_is_read_as_opencv_wrote_it() -> None:
    """Coefficients of a tilted sensor that are 0, and the capitals of older samples."""
    text = lens_file(9.0, [0.1] * 8 + [0.0] * 6, (640, 480))
    lens = Lens.parse(text.replace("camera_matrix", "Camera_Matrix"))
    assert lens == Lens((9.0, 0, 320, 0, 9, 240, 0, 0, 1), (0.1,) * 8, (640, 480))


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "camera_matrix:" + " " * 1_800_000,
        "camera_matrix: !!opencv-matrix\n" * 60_000,
        "image_width:\n" * 140_000,
        "<camera_matrix " * 120_000,
        "<image_width>" + "1\n" * 800_000,
    ],
    ids=["blanks", "matrices", "widths", "attributes", "numbers"],
)
def test_the_time_for_a_file_grows_with_its_length(text: str) -> None:
    """With the square of it, that was more than 150 s, and a child lives for 20."""
    assert "It has no camera_matrix" in in_a_child(lambda: Lens.parse(text))


def test_a_point_that_no_lens_sees_has_no_place() -> None:
    """The folded part of a model, and a pole of it; never a number that means nothing."""
    folded = Lens((100.0, 0, 50, 0, 100, 50, 0, 0, 1), (-1.0, 0, 0, 0))
    assert folded.undistorted((55.0, 50.0)) is not None
    assert folded.undistorted((150.0, 50.0)) is None
    assert RealUnits(Ground(scale=9.0), folded).metres(Ellipse(150, 50, 5, 5)) is None
    square = ((0.0, 0.0, 0.0, 0.0), (300.0, 0.0, 2.0, 0.0), (0.0, 300.0, 0.0, 2.0),
              (300.0, 300.0, 2.0, 2.0))  # fmt: skip
    with pytest.raises(ConfigError, match="no place for the ground's point"):
        RealUnits(Ground(points=square), folded).corrected()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no camera_matrix and distortion_coefficients"),
        (LENS.replace("camera_matrix", "matrix"), "no camera_matrix"),
        (LENS.replace("cols: 5", "cols: 6"), "no camera_matrix"),
        (LENS.replace("[ 9.0,", "[ 1e999,"), "matrix"),
        (LENS.replace("[ 9.0,", "[ .nan,"), "matrix"),
        (lens_file(distortion=[0.0] * 6), "has 6 coefficients"),
        (LENS.replace("[ 9.0,", "[ 0,"), "needs focal lengths above 0"),
        (LENS.replace(" 640", " -640"), "Pictures of -640x480 pixels"),
        (LENS.replace(" 640", " wide"), r"Pictures of 1.79769e\+308x480 pixels"),
    ],
)
def test_other_files_are_refused(text: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        Lens.parse(text)


def test_metres_are_those_of_the_scale_or_of_the_foot() -> None:
    ellipse = Ellipse(99.5, 49.5, 10.0, 20.0)
    assert RealUnits(Ground(scale=50.0)).metres(ellipse) == pytest.approx((1.99, 0.99))
    square = ((0.0, 0.0, 0.0, 0.0), (100.0, 0.0, 2.0, 0.0), (0.0, 100.0, 0.0, 2.0),
              (100.0, 100.0, 2.0, 2.0))  # fmt: skip
    flat = RealUnits(Ground(points=square))
    assert flat.metres(ellipse) == pytest.approx((1.99, 0.02 * 69), abs=1e-9)
    lens = Lens(MATRIX, DISTORTIONS[5])
    turned = RealUnits(Ground(points=square), lens).corrected()
    for x, y, metres_x, metres_y in square:  # seen through the lens, they are where they were
        place = lens.undistorted((x, y))
        assert place is not None
        assert turned.ground.metres(place) == pytest.approx((metres_x, metres_y), abs=1e-6)


def test_covariances_are_those_of_samples() -> None:
    ground = Ground(homography=((0.02, 0.001, -1.0), (0.0005, 0.03, -2.0), (1e-5, 4e-4, 1.0)))
    units = RealUnits(ground, Lens(MATRIX, DISTORTIONS[5]))
    found = place_of(units, track(0, 200, 150))
    assert found is not None
    rng = np.random.default_rng(0)
    mean = np.array(track(0, 200, 150).ellipse)
    drawn = rng.multivariate_normal(mean, COVARIANCE, 4000)
    places = np.array([units.metres(Ellipse(*each)) for each in drawn.tolist()])
    np.testing.assert_allclose(found[0], places.mean(axis=0), atol=4e-3)
    np.testing.assert_allclose(found[1], np.cov(places.T), rtol=0.12, atol=2e-5)


@pytest.mark.slow
def test_speeds_are_near_and_their_deviations_honest() -> None:
    """Over many noisy walks at 2 m/s, about 95 % of the intervals hold the truth."""
    rng = np.random.default_rng(1)
    factor = np.linalg.cholesky(COVARIANCE[:2, :2])
    inside, errors, deviations = [], [], []
    for _ in range(200):
        motion = GroundMotion(RealUnits(Ground(scale=50.0)))
        for frame in range(20):
            x, y = [3.2 * frame, 2.4 * frame] + factor @ rng.normal(size=2)
            (place,) = motion.update([track(frame, x, y)])
        speed, deviation = place.number("speed"), place.number("speed_std")
        errors.append(speed - 2.0)
        deviations.append(deviation)
        inside.append(abs(speed - 2.0) < 1.96 * deviation)
    assert abs(np.mean(errors)) < 0.03
    assert 0.9 < np.mean(inside) <= 1.0
    assert np.std(errors) == pytest.approx(np.mean(deviations), rel=0.3)


def test_a_live_speed_is_that_of_a_quarter_of_a_second_ago_and_none_in_hindsight() -> None:
    """A fall, 9.81 m/s², at 50 frames a second: a line is true in the middle of its time."""
    units = RealUnits(Ground(scale=50.0))
    motion = GroundMotion(units)
    times = np.arange(60) / 50
    tracks = [replace(track(n, 10.0, 50 * 4.905 * t**2), time=t) for n, t in enumerate(times)]
    live = [motion.update([each])[0].number("speed") for each in tracks]
    np.testing.assert_allclose(live[25:], 9.81 * (times[25:] - 0.25), atol=0.1)  # half a frame
    after = [place["speed"] or 0.0 for place in motion_in_hindsight(units, tracks)]
    np.testing.assert_allclose(after[13:-13], 9.81 * times[13:-13], atol=1e-6)


def test_a_row_of_a_live_run_is_as_sure_as_it_says_but_never_exact() -> None:
    places = {"x_m": 1.0, "y_m": 2.0, "x_m_std": 0.3, "y_m_std": 0.0}
    row = replace(track(0, 0.0, 0.0), further=places)
    live = seen_live(row)
    assert live is not None
    assert live.place.tolist() == [1, 2]
    np.testing.assert_allclose(live.covariance, np.diag([0.09, 0.0]), atol=1e-12)
    assert live.covariance[1, 1] > 0
    assert seen_live(replace(row, further={})) is None


def test_a_box_that_was_drawn_does_not_hold_the_line() -> None:
    """The first box has no deviation, and yet may be off, as it is by hand."""
    motion = GroundMotion(RealUnits(Ground(scale=50.0)))
    (first,) = motion.update([track(0, 3.0, 0.0, covariance=1e-24)])  # by rounding
    assert [first.further[name] for name in GROUND[:4]] == [0.06, 0.0, None, None]
    live = seen_live(first)
    assert live is not None
    assert np.isfinite(live.covariance).all()
    places = [motion.update([track(n, 2.0 * n, 0.0)])[0] for n in range(1, 8)]
    x = np.array([3.0, *(2.0 * n for n in range(1, 8))]) / 50
    assert places[-1].number("speed") == pytest.approx(np.polyfit(np.arange(8) / 25, x, 1)[0])


def test_no_line_in_hindsight_goes_beyond_a_keyframe() -> None:
    """So rows on its other side stay, whatever is corrected here."""
    units = RealUnits(Ground(scale=50.0))
    marked = track(6, 12.0, 0.0, covariance=0.0)
    before = [track(n, 2.0 * n, 0.0) for n in range(6)]
    parts = [motion_in_hindsight(units, [*before, marked, *after]) for after in (
        [track(n, 2.0 * n, 0.0) for n in range(7, 12)],
        [track(n, 9.0 * n, 0.0) for n in range(7, 12)],
        [],
    )]  # fmt: skip
    assert parts[0][:7] == parts[1][:7] == parts[2]
    assert [place["speed"] for place in parts[0]] == pytest.approx([1.0] * 12)


def test_nothing_is_measured_while_the_target_is_lost() -> None:
    motion = GroundMotion(RealUnits(Ground(scale=50.0)))
    for frame in range(5):
        (place,) = motion.update([track(frame, 10.0 * frame, 0.0)])
    assert place.number("speed") == pytest.approx(5.0)
    assert not motion.update([track(5, 900.0, 0.0, Status.LOST)])[0].further
    assert not motion.update([Track.nowhere(5, 0.2)])[0].further
    (place,) = motion.update([track(6, 600.0, 0.0)])
    assert place.further["x_m"] == pytest.approx(12.0)
    assert place.further["speed"] is None  # the way to where it was found again is no motion
    seen = (0, 200, 0, 200), (100, 200, 100, 200), (0, 300, 0, 150), (100, 300, 50, 150)
    horizon = RealUnits(Ground(points=seen))  # at y = 100
    assert motion.note is None
    above = GroundMotion(horizon)
    assert [above.update([track(n, 5.0, 50.0)])[0].further for n in range(2)] == [{}, {}]
    assert "Frame 0: object 1 is on the horizon" in str(above.note)


def test_the_speed_of_an_object_that_the_edge_cuts_is_that_of_before() -> None:
    motion = GroundMotion(RealUnits(Ground(scale=50.0)), (200, 100))
    for frame in range(40):
        (place,) = motion.update([track(frame, min(60.0 + 5 * frame, 185.0), 50.0)])
    assert place.number("x_m") == pytest.approx(3.7)
    assert place.number("speed") == pytest.approx(2.5)


def seen_by_a_camera(x: float, y: float) -> tuple[float, float]:
    """Return the pixel of a point on the ground: 5 m high, 30 degrees down, 500 pixels focal."""
    tilt, height, focal = math.radians(30), 5.0, 500.0
    depth = y * math.cos(tilt) + height * math.sin(tilt)
    down = height * math.cos(tilt) - y * math.sin(tilt)
    return 320 + focal * x / depth, 240 + focal * down / depth


GRID = [(float(x), float(y)) for x in (-2, 0, 3) for y in (4, 7, 15)]
POINTS = tuple((*seen_by_a_camera(*metres), *metres) for metres in GRID)


def test_points_of_a_camera() -> None:
    """Four of them say where all others are, and more say the same."""
    for points in (POINTS, (POINTS[0], POINTS[2], POINTS[6], POINTS[8])):
        ground = Ground(points=points)
        for x, y in [(0.5, 5.0), (-4.0, 30.0), (9.0, 2.0)]:
            assert ground.metres(seen_by_a_camera(x, y)) == pytest.approx((x, y))
        horizon = 240 - 500 * math.tan(math.radians(30))
        assert ground.metres((100, horizon - 1)) is None
        assert ground.metres((100, horizon + 1)) is not None


@pytest.mark.parametrize("factor", [1, -1])
def test_a_homography_is_taken_times_anything(factor: float) -> None:
    """OpenCV's have a 1 at the end; then w is negative on the ground below a horizon."""
    matrix = factor * np.array([[2, 0, 1], [0, 4, -2], [0, 0, 2]])
    ground = Ground(homography=matrix.tolist())
    assert ground.metres((10, 20)) == (10.5, 39)


def test_speeds_in_metres() -> None:
    """Ten pixels in a quarter of a second, at 20 pixels in a metre."""
    counting = EventCounter(Regions(ground=Ground(scale=20)))
    events = told(counting, *(seen(i, (10 * i, 40)) for i in range(5)))
    events += told(counting, seen(5, (100, 40)))
    assert events[0].metres_per_second is None
    (gone,) = told(counting, seen(6, (100, 40), Status.LOST))
    assert gone.speed is not None
    assert gone.speed > 0
    assert gone.metres_per_second == pytest.approx(gone.speed / 20)
    assert gone.fields()["metres_per_second"] == round(gone.speed / 20, 3)
    tiny = replace(gone, metres_per_second=1.23456789e-6)  # under a microscope
    assert tiny.fields()["metres_per_second"] == 1.2346e-6
    assert replace(gone, metres_per_second=1e-16).fields()["metres_per_second"] == 0


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({}, "exactly one of scale, homography and points"),
        ({"scale": 3, "points": POINTS}, "exactly one of"),
        ({"scale": 0}, "it takes number, 1e-09 to "),
        ({"homography": (1, 2, 3)}, r"homography\[0\]: got 1; it takes list of 3: number"),
        ({"homography": ((1, 2, 3), (2, 4, 6), (0, 0, 1))}, "onto a line"),
        ({"points": POINTS[:3]}, r"four points or more, each \[x, y, X, Y\], and has 3; add"),
        ({"points": [(i, i, i, 2 * i) for i in range(5)]}, "on a line"),
        ({"points": [(0, 0, 0, 0), (9, 9, 9, 0), (9, 0, 9, 9), (0, 9, 0, 9)]}, "horizon"),
    ],
)
def test_what_is_no_ground(values: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        Ground(**values)  # type: ignore[arg-type]


def test_noise_on_many_points_averages_out() -> None:
    moves = np.random.default_rng(0).normal(0, 0.5, (len(POINTS), 2)).tolist()
    noisy = tuple(
        (x + dx, y + dy, far, near)
        for (x, y, far, near), (dx, dy) in zip(POINTS, moves, strict=True)
    )
    found = Ground(points=noisy).metres(seen_by_a_camera(1, 6))
    assert found == pytest.approx((1, 6), abs=0.1)


def test_speed_does_not_depend_on_the_distance() -> None:
    speeds = []
    for y in (4.0, 12.0):
        counting = EventCounter(Regions.parse(f"[ground]\npoints = {[list(p) for p in POINTS]}"))
        feet = [seen_by_a_camera(0.5 * i, y) for i in range(5)]
        told(counting, *(seen(i, foot) for i, foot in enumerate(feet)))
        (gone,) = told(counting, seen(5, feet[-1], Status.LOST))
        speeds.append(gone.metres_per_second)
    assert speeds == pytest.approx([2.0, 2.0], rel=1e-6)  # half a metre in a quarter of a second
