"""The figures of `motes track --figures`: the numbers behind them, and that they are drawn."""

import math
import os
import tempfile
from collections.abc import Callable
from functools import cache
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from clips import write_film
from motes import (
    Ellipse,
    Frame,
    ParticleFilter,
    Status,
    StepInfo,
    Track,
    Tracker,
    TrackerConfig,
    configure,
    preset,
    synthetic,
)
from motes.cli import Moment, main
from motes.cues import Color
from motes.synthetic import Clip
from motes_lab.track_figures.charts import RhoSurface, Series
from motes_lab.track_figures.figures import (
    CUE_WEIGHTS,
    FIGURES,
    ORIENTATION,
    figures_of,
    surface_of,
)
from motes_lab.track_figures.sink import TrackFigures

Go = Callable[[str], tuple[int, str]]
VARIANTS = {
    "maggio, sum": ("maggio", {"fusion": {"type": "printed_mixture"}}),
    "maggio, spectra": ("maggio:O-ROH", {"orientation": {"form": "fourier"}}),
}
"""Weights of cues that change, and orientation alone by its spectrum."""


class Recorder(TrackFigures):
    """Figures that are looked at before they are written, with given times of mean shift."""

    def __init__(self, config: TrackerConfig) -> None:
        super().__init__(Path(tempfile.gettempdir()), config, overwrite=True)
        self.shift = math.nan

    def _compared(self, moment: Moment) -> float:
        return self.shift

    def add(self, frame: Frame, info: StepInfo, seconds: float = 0.001) -> None:
        """Record a frame."""
        self.write(Moment(frame, [info.track], info, seconds))

    def surface(self) -> RhoSurface | None:
        """Return the surface in the kept frame; None without one."""
        return None if self._kept is None else surface_of(self._config, *self._kept)


@cache  # its ground is rendered once
def clip() -> Clip:
    """Return a small clip with a target that grows."""
    return synthetic.growing((160, 120), 9, factor=1.5)


def recorded(name: str, frames: int) -> tuple[Recorder, Series]:
    """Return the figures of a run on a small clip, and the numbers that they should have."""
    base, changes = VARIANTS.get(name, (name, {}))
    config = configure(preset(base), changes)
    recorder, tracker, rows, cue_weights = Recorder(config), Tracker(config, seed=1), [], []
    for frame, (truth,) in islice(clip(), frames):
        track = tracker.update(frame) if frame.index else tracker.init(frame, truth.ellipse)
        seconds, mean_shift_seconds = (
            0.001 + frame.index,
            2.0 * frame.index if name == "nummiaro" else None,
        )
        recorder.shift = np.nan if mean_shift_seconds is None else mean_shift_seconds
        recorder.add(frame, tracker.info, seconds)
        cue_weights.append(list(tracker.info.cue_weights.values()))
        rows.append(
            (
                *(frame.index, *track.ellipse[:4], tracker.info.n_supporting),
                *(track.status == "tracking", seconds, recorder.shift),
            )
        )
    return recorder, Series(*[*np.array(rows, float).T, np.array(cue_weights)])


def seen(index: int, status: Status, x: float = 40.0) -> tuple[Frame, StepInfo]:
    """Return a gray frame and what a tracker says about it."""
    frame = Frame(index, index / 25, gray())
    model = Color().learn(frame, Ellipse(40, 30, 8, 6))
    track = Track(index, index / 25, Ellipse(x, 30, 8, 6), np.eye(5), 0.5, status, 0.1, 50.0)
    return frame, StepInfo(track, np.array([track.ellipse]), np.ones(1), 1,
        {"color": model}, {"color": 1.0},
    )  # fmt: skip


def gray() -> NDArray[np.uint8]:
    return np.full((60, 80, 3), 128, np.uint8)


def drawn(recorder: Recorder) -> list[str]:
    """Return the names of the figures; to make pictures of them takes most of the time."""
    figures = figures_of(recorder._config, recorder.series, 100, recorder._kept)
    return [name for name, _ in figures]


@pytest.fixture
def go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Go:
    """Track the target of a small film in a folder; return exit code and standard error."""
    monkeypatch.chdir(tmp_path)
    write_film("film.mkv", clip())
    box = ",".join(f"{value:.1f}" for value in clip()[0][1][0].ellipse.box)

    def run(options: str) -> tuple[int, str]:
        capfd.readouterr()
        code = main(["track", "film.mkv", "--init", box, *options.split()])
        return code, capfd.readouterr().err

    return run


def ink(path: Path) -> float:
    """Return the share of a picture's pixels that are not white."""
    return float((np.asarray(Image.open(path).convert("RGB")) < 250).any(axis=2).mean())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nummiaro", *VARIANTS])
def test_every_frame_leaves_its_numbers_and_all_figures_are_there(name: str) -> None:
    recorder, expected = recorded(name, 9)
    for kept, right in zip(recorder.series, expected, strict=True):
        np.testing.assert_array_equal(kept, right)
    more = [CUE_WEIGHTS] * (name == "maggio, sum") + [ORIENTATION] * name.startswith("maggio")
    assert drawn(recorder) == [*FIGURES, *more]


@pytest.mark.slow
def test_every_figure_has_its_picture(go: Go) -> None:
    code, said = go("--preset maggio --set fusion.type=printed_mixture --figures f")
    assert (code, said.rstrip().endswith("wrote 6 figures in f.")) == (0, True)
    assert sorted(os.listdir("f")) == sorted([*FIGURES, CUE_WEIGHTS, ORIENTATION])
    for path in Path("f").iterdir():
        with Image.open(path) as image:
            assert image.width >= 800
        assert 0.01 < ink(path) < 0.9, path
        assert path.stat().st_size < 200_000, path


def test_the_surface_of_two_cues_is_their_mean() -> None:
    recorder, _ = recorded("maggio", 1)
    surface = recorder.surface()
    assert surface is not None
    frame, (truth,) = clip()[0]
    tracker = Tracker(recorder._config, seed=1)
    tracker.init(frame, truth.ellipse)
    center = tracker.info.track.ellipse
    place = np.array([center._replace(x=surface.x[40], y=surface.y[20])])
    rho = sum(
        tracker.info.cue_weights[name]
        * (1 - cue.distances(tracker.info.models[name], frame, place)[0] ** 2)
        for name, cue in recorder._config.cues.items()
    )
    assert surface.rho[20, 40] == pytest.approx(float(rho), abs=1e-6)


def test_the_surface_is_rho_at_each_place() -> None:
    recorder, _ = recorded("nummiaro", 1)
    surface = recorder.surface()
    assert surface is not None
    frame, (truth,) = clip()[0]
    config = preset("nummiaro")
    assert isinstance(config, ParticleFilter)
    cue = config.color
    assert cue is not None
    model = cue.learn(frame, truth.ellipse)
    for row, column in ((0, 60), (17, 42), (60, 0)):
        place = truth.ellipse._replace(x=surface.x[column], y=surface.y[row])
        seen_there = cue.histograms(frame, np.array([place]))[0]
        rho = float(np.sqrt(seen_there * model.histogram).sum())  # equation 6
        assert surface.rho[row, column] == pytest.approx(rho, abs=1e-9)
        points = np.array([[surface.x[column] + 0.01, surface.y[row] - 0.01]])
        assert surface.height(points) == pytest.approx(rho)


def test_one_frame_is_kept_of_many_and_it_is_a_tracked_one() -> None:
    recorder = Recorder(preset("nummiaro"))
    kept = []
    for index in range(12):
        status = Status.TRACKING if index % 2 else Status.SEARCHING
        recorder.add(*seen(index, status))
        surface = recorder.surface()
        kept.append(surface and surface.frame)
    # Tracked are 1, 3, 5, 7, 9, 11; of these the first, second and fourth are kept in turn.
    assert kept == [None, 1, 1, 3, 3, 3, 3, 7, 7, 7, 7, 7]


def test_figures_are_of_the_default_tracker_too() -> None:
    recorder, _ = recorded("default", 1)
    surface = recorder.surface()
    assert surface is not None
    assert surface.samples.shape == (0, 2)
    assert np.isnan(recorder.series.n_supporting).all()


def test_a_folder_in_which_nothing_is_made_is_removed(go: Go) -> None:
    Path("rows.csv").touch()
    for folder in ("new", "new/deep"):
        code, _ = go(f"--figures {folder} -o rows.csv")
        assert (code, Path("new").exists()) == (5, False)
    Path("mine").mkdir()
    assert go("--figures mine -o rows.csv")[0] == 5
    assert Path("mine").exists()
