"""What a tracker compares around its estimate: the numbers of the papers' figures."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motes import synthetic
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.core.track import Status, Track
from motes.core.types import Floats
from motes.cues.color import Color
from motes.cues.structure_tensor import Orientation
from motes.output.surfaces import orientation_of, rho_surface
from motes.sot.particle_filter import ParticleFilter
from motes.sot.presets import preset
from motes.sot.step_info import StepInfo
from motes.sot.tracker import Tracker

FRAME, (TRUTH,) = synthetic.growing((160, 120), 1, factor=1.5)[0]


def begun(name: str) -> tuple[Tracker, tuple[Floats, Floats, Floats]]:
    """Return a tracker on the first frame of a small clip, and the surface around its estimate."""
    tracker = Tracker(name, seed=1)
    tracker.init(FRAME, TRUTH.ellipse)
    return tracker, rho_surface(tracker.config, FRAME, tracker.info)


def disk(x: float, y: float) -> NDArray[np.uint8]:
    """Return a red disk with a blue ring, 16 pixels in radius in all, on gray."""
    pixels = np.full((120, 160, 3), 128, np.uint8)
    rows, columns = np.mgrid[:120, :160]
    radius = np.hypot(columns - x, rows - y)
    pixels[radius <= 16], pixels[radius <= 9] = (20, 40, 200), (220, 30, 30)
    return pixels


@pytest.mark.parametrize("form", ["rotated", "fourier"])
def test_a_region_has_two_orientation_histograms(form: str) -> None:
    """What a tracker compares is among the two, and like the model where it just learned it."""
    cue = Orientation(bins=36, form=form)  # type: ignore[arg-type]
    rotated, spectrum = orientation_of(cue, FRAME, TRUTH.ellipse)
    assert (rotated.size, spectrum.size) == (36, 19)
    assert rotated.sum() == pytest.approx(1)
    magnitudes = np.abs(np.fft.rfft(rotated))
    np.testing.assert_allclose(spectrum, magnitudes / magnitudes.sum(), atol=0.04)
    model = cue.learn(FRAME, TRUTH.ellipse).histogram
    np.testing.assert_allclose(model, rotated if form == "rotated" else spectrum, atol=1e-9)


def test_the_surface_of_two_cues_is_their_mean() -> None:
    tracker, (x, y, found) = begun("maggio")
    center = tracker.info.track.ellipse
    place = np.array([center._replace(x=x[40], y=y[20])])
    rho = sum(
        tracker.info.cue_weights[name]
        * (1 - cue.distances(tracker.info.models[name], FRAME, place)[0] ** 2)
        for name, cue in tracker.config.cues.items()
    )
    assert found[20, 40] == pytest.approx(float(rho), abs=1e-6)


def test_the_surface_has_its_maximum_at_the_target() -> None:
    tracker = Tracker("nummiaro", seed=1)
    frame = Frame(0, 0.0, disk(83, 58))
    tracker.init(frame, (83, 58, 16, 16, 0))
    x, y, rho = rho_surface(tracker.config, frame, tracker.info)
    row, column = np.unravel_index(rho.argmax(), rho.shape)
    assert (x[column], y[row]) == pytest.approx((83, 58), abs=1.5)
    assert rho.max() > 0.95
    assert rho[0, 0] < 0.2


def test_the_surface_is_rho_at_each_place() -> None:
    _, (x, y, found) = begun("nummiaro")
    config = preset("nummiaro")
    assert isinstance(config, ParticleFilter)
    cue = config.color
    assert cue is not None
    model = cue.learn(FRAME, TRUTH.ellipse)
    for row, column in ((0, 60), (17, 42), (60, 0)):
        place = TRUTH.ellipse._replace(x=x[column], y=y[row])
        seen_there = cue.histograms(FRAME, np.array([place]))[0]
        rho = float(np.sqrt(seen_there * model.histogram).sum())  # equation 6
        assert found[row, column] == pytest.approx(rho, abs=1e-9)


def test_the_surface_stays_inside_the_frame() -> None:
    frame = Frame(0, 0.0, np.full((60, 80, 3), 128, np.uint8))
    model = Color().learn(frame, Ellipse(40, 30, 8, 6))
    track = Track(0, 0.0, Ellipse(2, 30, 8, 6), np.eye(5), 0.5, Status.TRACKING, 0.1, 50.0)
    info = StepInfo(track, np.array([track.ellipse]), np.ones(1), 1, {"color": model}, {"color": 1})
    x, y, _ = rho_surface(preset("nummiaro"), frame, info)
    assert (x[0], x[-1], y[0], y[-1]) == pytest.approx((0, 18, 14, 46))
