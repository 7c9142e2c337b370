"""Packages that add parts of every kind, and touch no file of ours.

They are in tests/plugins. docs/extend.md shows one of them, and names the others.
"""

import importlib
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from clips import write_film
from commands import Go, running
from motes import (
    Discriminative,
    Ellipse,
    Frame,
    ParticleFilter,
    Tracker,
    TrackerConfig,
    configure,
    preset,
    scene_config,
    synthetic,
)
from motes.core import registry
from motes.core.config import from_dict, from_toml
from motes.core.config_keys import keys
from motes.core.errors import ConfigError, FormatError, PluginError
from motes.core.types import Floats
from motes.cues.base import CUES
from motes.cues.color import Color
from motes.formats.registry import FORMATS
from motes.mot.scene_config import DETECTORS, WatchConfig, named_detector
from motes.sot.discriminative.expert import EXPERTS, Confined
from motes.sot.filtering.motion import MOTIONS, RandomWalk
from motes.testing import check_cue, check_detector, check_expert, check_motion
from pages import run_page

PLUGINS = Path(__file__).parent / "plugins"
PAGE = Path(__file__).parent.parent / "docs/extend.md"
CLIP = synthetic.still((160, 120), target=(40, 30), frames=8)


def install(folder: Path, name: str, points: dict[str, dict[str, str]]) -> None:
    """Write what an installer writes for a package: its metadata with its entry points."""
    info = folder / f"{name.replace('-', '_')}-0.1.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 0.1\n")
    groups = (
        "\n".join([f"[{group}]", *(f"{key} = {value}" for key, value in entries.items())])
        for group, entries in points.items()
    )
    (info / "entry_points.txt").write_text("\n\n".join(groups) + "\n")


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Return a folder on the path to install packages in; they are gone after the test."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))
    before = set(sys.modules)
    registry._entry_points.cache_clear()
    yield folder
    registry._entry_points.cache_clear()
    for name in set(sys.modules) - before:
        if name.startswith("motes_"):
            del sys.modules[name]


@pytest.fixture
def installed(site: Path) -> Path:
    """Return the folder with the packages of tests/plugins installed."""
    for package in sorted(PLUGINS.iterdir()):
        [module] = package.glob("*.py")
        (site / module.name).write_bytes(module.read_bytes())
        project = tomllib.loads((package / "pyproject.toml").read_text())["project"]
        install(site, project["name"], project["entry-points"])
    return site


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> tuple[str, str]:
    """Return a video and the target's box in its first frame."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    write_film(path, CLIP)
    return str(path), ",".join(f"{value:.1f}" for value in CLIP[0][1][0].ellipse.box)


@pytest.fixture
def go(film: tuple[str, str], installed: Path, here: Path, capfd: pytest.CaptureFixture[str]) -> Go:
    """Run a command with the packages installed."""
    return running(capfd, FILM=film[0], BOX=film[1])


@pytest.mark.slow
def test_they_are_known_and_keep_the_rules(installed: Path) -> None:
    assert CUES.names()[-1] == "hue"
    assert MOTIONS.names()[-1] == "drift"
    assert DETECTORS.names()[-1] == "bright"
    assert EXPERTS.names()[-1] == "patch"
    check_cue(CUES.resolve("hue")())
    check_motion(MOTIONS.resolve("drift")())
    check_detector(DETECTORS.resolve("bright")())
    check_expert(EXPERTS.resolve("patch")())
    names = {key.path for key in keys(TrackerConfig)}
    assert {"hue", "color"} <= names
    assert not {"extra_cues", "extra_experts"} & names
    assert "patch" in names


@pytest.mark.slow
def test_options_reach_them(go: Go) -> None:
    line = "track FILM --init BOX --preset nummiaro --set hue.bins=12 --set hue.points=64 "
    line += "--set motion.type=drift --set motion.noise=0.4 "
    code, output, error = go(line + "--dump-config")
    assert code == 0, error
    assert "[hue]\nbins = 12\npoints = 64\n" in output
    assert 'type = "drift"\nflow = 0.0\nnoise = 0.4' in output
    assert "extra_cues" not in output
    Path("mine.toml").write_text(output)
    code, _, error = go(line + "-o options.csv")
    assert code == 0, error
    code, _, error = go("track FILM --init BOX --config mine.toml -o file.csv")
    assert code == 0, error
    rows = Path("options.csv").read_text()
    assert rows == Path("file.csv").read_text()
    assert ",tracking," in rows.splitlines()[-1]
    assert go("track FILM --init BOX --preset nummiaro -o color.csv")[0] == 0
    assert rows != Path("color.csv").read_text()


def test_options_add_an_expert_to_the_default_tracker(go: Go) -> None:
    line = "track FILM --init BOX --set patch.weight=3 "
    code, output, error = go(line + "--dump-config")
    assert code == 0, error
    assert "[patch]\nweight = 3.0" in output
    code, _, error = go(line + "-o patch.csv")
    assert code == 0, error
    assert go("track FILM --init BOX -o alone.csv")[0] == 0
    assert Path("patch.csv").read_text() != Path("alone.csv").read_text()
    code, _, error = go("track FILM --init BOX --set hue.bins=12 --dump-config")
    assert "takes no cue 'hue'" in error


def test_a_format_is_written_and_read(go: Go) -> None:
    """By its ending and by its name, by the commands that write formats and by those that read."""
    track = "track FILM --init BOX --preset nummiaro "
    for line in (
        track + "-o rows.csv",
        track + "-o its.boxes",
        track + "-o named.txt --format boxes",
        "convert rows.csv converted.boxes",
        "convert its.boxes again.csv --fps 25",
        "convert named.txt --from boxes -o further.csv --fps 25",
        "draw FILM converted.boxes -o drawn.mp4",
    ):
        code, _, error = go(line)
        assert code == 0, (line, error)
    lines = Path("its.boxes").read_text()
    assert lines.count("\n") == len(CLIP)
    assert lines == Path("named.txt").read_text()
    np.testing.assert_allclose(np.loadtxt("converted.boxes"), np.loadtxt("its.boxes"), atol=0.011)
    again = Path("again.csv").read_text()
    assert again == Path("further.csv").read_text()
    assert again.splitlines()[1].split(",")[4:8] == [f"{float(n):.3f}" for n in lines.split()[1:5]]
    _, output, _ = go("convert --list")
    assert re.search(r"^boxes +yes +yes +\.boxes +boxes$", output, re.M)
    code, _, error = go("convert rows.csv rows.bxoes")
    assert (code, ".yolo, .boxes; rename it" in error) == (2, True)


def test_a_damaged_file_of_a_format(go: Go) -> None:
    Path("bad.boxes").write_text("0 1 2 3\n")
    code, _, error = go("convert bad.boxes rows.csv")
    assert code == 3
    assert error.startswith("motes: error: bad.boxes is damaged, or not of the format boxes: ")


def test_a_tracker_is_saved_and_loaded(installed: Path, tmp_path: Path) -> None:
    changes = {
        "hue": {"bins": 12},
        "motion": {"type": "drift"},
        "particles": 60,
        "presence": {"max_positions": 100},
    }
    config = configure(preset("nummiaro:adaptive"), changes)
    assert list(config.cues) == ["color", "hue"]
    tracker = Tracker(config, seed=3)
    tracker.init(CLIP[0][0], CLIP[0][1][0].ellipse)
    for i in range(1, 4):
        tracker.update(CLIP[i][0])
    assert set(tracker.info.cue_weights) == {"color", "hue"}
    tracker.save(tmp_path / "state")
    again = Tracker.load(tmp_path / "state")
    assert again.config == config
    for i in range(4, 8):
        mine, its = tracker.update(CLIP[i][0]), again.update(CLIP[i][0])
        assert mine.ellipse == its.ellipse
        np.testing.assert_array_equal(tracker.info.weights, again.info.weights)


def test_a_saved_tracker_needs_the_package(
    installed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cases: dict[str, dict[str, Any]] = {
        "unknown key 'hue'": {"hue": {}, "presence": {"max_positions": 100}},
        "motion.type: Invalid value 'drift'; known are ": {"motion": {"type": "drift"}},
    }
    for unknown, changes in cases.items():
        tracker = Tracker(configure(preset("nummiaro"), changes))
        tracker.init(CLIP[0][0], CLIP[0][1][0].ellipse)
        tracker.save(tmp_path / "state")
        with monkeypatch.context() as without:
            without.setattr(registry, "_entry_points", lambda group: ())
            with pytest.raises(FormatError, match="the package that adds it is missing") as error:
                Tracker.load(tmp_path / "state")
            assert unknown in str(error.value)


def test_values_in_python_need_no_entry_point(installed: Path) -> None:
    hue: Any = importlib.import_module("motes_hue").Hue(bins=5)
    drift: Any = importlib.import_module("motes_drift").Drift(flow=1.0)
    config = ParticleFilter(color=Color(), extra_cues={"hue": hue}, motion=drift)
    assert from_dict(config.to_dict(), TrackerConfig) == config
    assert from_dict(from_toml(config.to_toml(), "it"), TrackerConfig) == config
    assert config.to_dict()["hue"] == {"bins": 5, "points": 256}
    with pytest.raises(
        ConfigError,
        match="extra_cues names 'motion', which is the name of another key; choose another name",
    ):
        ParticleFilter(color=Color(), extra_cues={"motion": hue})
    with pytest.raises(ConfigError, match="no key 'extra_cues'"):
        from_dict({"color": {}, "extra_cues": {"hue": {}}}, ParticleFilter)


def test_scenes_take_them_too(installed: Path) -> None:
    plain = {"tracker": {"hue": {"bins": 9}, "motion": {"type": "drift"}}}
    plain |= {"detector": {"type": "bright", "level": 99}}
    config: WatchConfig = from_dict(plain, WatchConfig)
    assert list(config.tracker.cues) == ["hue"]
    assert from_dict(config.to_dict(), WatchConfig) == config
    assert len(named_detector("bright")(CLIP[0][0])) <= 1
    with pytest.raises(
        ConfigError,
        match=r"A detector is background, .*people, faces, bright, MODULE:CALLABLE, or an .onnx",
    ):
        named_detector("brihgt")
    with pytest.raises(ConfigError, match=r"Config tracker\.hue\.bins: got 'x'; it takes integer"):
        from_dict({"tracker": {"hue": {"bins": "x"}}}, WatchConfig)
    assert scene_config().tracker.extra_cues == {}


@pytest.mark.slow
def test_the_page_runs(
    installed: Path,
    film: tuple[str, str],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    (installed / "film.mp4").symlink_to(film[0])
    monkeypatch.chdir(installed)
    assert run_page(PAGE, capfd) > 0
    assert "tracking" in Path("hue.csv").read_text()


@pytest.mark.parametrize(
    ("code", "name", "message"),
    [
        ("import nowhere", "X", "cannot be loaded: ModuleNotFoundError: No module named 'nowhere'"),
        ("x = = 1", "X", "cannot be loaded: SyntaxError: "),
        ("raise SystemExit('no')", "X", "cannot be loaded: SystemExit: no; update or uninstall"),
        ("", "X", "cannot be loaded: AttributeError: "),
        ("def X(): ...", "X", "is not a subclass of motes.core.config.Config."),
        (
            "from motes.core.config import Config\nclass X(Config, frozen=True, tag='odd'): ...",
            "X",
            "is not a subclass of motes.sot.filtering.motion.Motion.",
        ),
        (
            "from motes.sot.filtering.motion import RandomWalk as X",
            "X",
            "has the tag 'random_walk'; its tag and its entry point need one name.",
        ),
    ],
)
def test_packages_that_are_broken(code: str, name: str, message: str, site: Path) -> None:
    (site / "motes_odd.py").write_text(code)
    install(site, "motes-odd", {"motes.motions": {"odd": f"motes_odd:{name}"}})
    with pytest.raises(PluginError) as error:
        configure(preset("nummiaro"), {"motion": {"type": "odd"}})
    assert str(error.value).startswith("The motion model 'odd' of package motes-odd ")
    assert message in str(error.value)
    assert "\n" not in str(error.value)
    # Whoever does not ask for it is not bothered, whatever else is wrong.
    configure(preset("nummiaro"), {"motion": {"type": "random_walk"}})
    with pytest.raises(ConfigError, match="did you mean 'particles'"):
        configure(preset("nummiaro"), {"particels": 5})


class Emptying(RandomWalk, frozen=True, tag="emptying"):
    """A motion model that loses a particle."""

    def ellipses(self, states: Floats) -> Floats:
        """Return NaN for the last one."""
        ellipses = super().ellipses(states).copy()
        ellipses[-1, 2] = np.nan if len(states) > 1 else 20.0
        return ellipses


class Blind(Color, frozen=True):
    """A cue that divides by zero where it sees nothing."""

    def distances(self, model: Any, frame: Frame, ellipses: Floats) -> Floats:
        """Return NaN for all."""
        return np.full(len(ellipses), np.nan)


class Mute(Confined, frozen=True):
    """An expert that divides by zero."""

    def log_odds(self, sight: Any, place: Ellipse) -> float:
        """Return NaN."""
        return np.nan


@pytest.mark.parametrize(
    ("config", "part"),
    [
        (ParticleFilter(color=Color(), motion=Emptying()), "motion model 'emptying'"),
        (ParticleFilter(color=Color(), extra_cues={"blind": Blind()}), "cue 'blind'"),
        (Discriminative(extra_experts={"mute": Mute()}), "expert 'mute'"),
    ],
)
def test_no_number_is_not_followed(config: TrackerConfig, part: str) -> None:
    def follow() -> None:
        tracker = Tracker(config)
        for frame, (truth,) in CLIP:
            tracker.update(frame) if frame.index else tracker.init(frame, truth.ellipse)

    with pytest.raises(PluginError, match=f"The {part} returns NaN or infinity; correct it"):
        follow()


def test_a_format_that_is_none(site: Path) -> None:
    install(site, "motes-odd", {"motes.formats": {"odd": "pathlib:Path"}})
    with pytest.raises(PluginError, match=r"odd is no motes\.formats\.registry\.Format\."):
        FORMATS.resolve("odd")


@pytest.mark.parametrize(
    ("group", "base", "changes"),
    [
        ("trackers", "motes.sot.mean_shift:MeanShift", {"type": "odd"}),
        ("likelihoods", "motes.sot.filtering.likelihood:Exponential", {"likelihood": "odd"}),
        ("fusions", "motes.sot.filtering.fusion:Fixed", {"fusion": "odd"}),
        ("resamplings", "motes.sot.filtering.resampling:Systematic", {"resampling": "odd"}),
        ("model_updates", "motes.sot.filtering.bin_updates:GaussianBins", {"adaptation": "odd"}),
    ],
)
def test_all_other_interfaces_are_open(
    group: str, base: str, changes: dict[str, str], site: Path, tmp_path: Path
) -> None:
    module, name = base.split(":")
    code = f"from {module} import {name}\nclass Odd({name}, frozen=True, tag='odd'): ..."
    (site / "motes_odd.py").write_text(code)
    install(site, "motes-odd", {f"motes.{group}": {"odd": "motes_odd:Odd"}})
    nested = {key: tag if key == "type" else {"type": tag} for key, tag in changes.items()}
    config = configure(preset("nummiaro"), nested)
    tracker = Tracker(config)
    tracker.init(CLIP[0][0], CLIP[0][1][0].ellipse)
    tracker.update(CLIP[1][0])
    tracker.save(tmp_path / "state")
    again = Tracker.load(tmp_path / "state")
    assert again.config == config
    assert again.update(CLIP[2][0]).ellipse == tracker.update(CLIP[2][0]).ellipse
    text = config.to_toml()
    assert 'type = "odd"' in text
    assert configure(preset("default"), from_toml(text, "it")) == config


def test_two_packages_with_one_name(site: Path) -> None:
    for name in ("motes-one", "motes-two"):
        install(site, name, {"motes.cues": {"hue": "motes_hue:Hue"}})
    with pytest.raises(PluginError) as error:
        configure(preset("nummiaro"), {"hue": {}})
    assert re.fullmatch(
        r"package motes-(one|two) and package motes-(one|two) both add a cue 'hue'; uninstall one "
        r"of them\.",
        str(error.value),
    )


def test_a_package_takes_no_name_of_ours(site: Path) -> None:
    install(site, "motes-one", {"motes.cues": {"color": "motes_hue:Hue"}})
    with pytest.raises(PluginError, match="package motes-one adds a cue 'color', which motes has"):
        CUES.names()
