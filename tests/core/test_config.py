"""Configuration checks itself, comes from and goes to plain values, and says its meanings."""

import importlib
import math
import pkgutil
import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st
from msgspec import Meta

import motes
from kinds import CONFIGS
from motes import ConfigError, MeanShift, ParticleFilter, Place, Regions
from motes.cli.load_config import value_of
from motes.core.config import Config, Count, Positive, Share, from_dict, from_toml
from motes.core.config_keys import meanings, words
from motes.cues.color import Color
from motes.cues.gradients import Hog
from motes.cues.sampling import EveryPixel, Lattice
from motes.cues.structure_tensor import Orientation
from motes.sot.filtering.appearance_rule import AppearanceRule, Calibration
from motes.sot.filtering.bin_updates import KalmanBins
from motes.sot.filtering.fusion import Fixed
from motes.sot.filtering.likelihood import Gaussian
from motes.sot.filtering.model_update import ExponentialForgetting, PerCue
from motes.sot.filtering.motion import Autoregressive, ConstantVelocity, Noise, RandomWalk
from motes.sot.filtering.resampling import Multinomial
from motes.sot.presets import PRESETS, TrackerConfig, configure, preset


@pytest.mark.parametrize(
    ("kind", "field", "values"),
    [
        (Gaussian, "sigma", [0, 1e-4, 1e7, math.nan, math.inf, -math.inf, "a", None, True, [1]]),
        (Noise, "position", [-0.1, 1e300, math.nan, math.inf, "0.1"]),
        (ConstantVelocity, "noise", [0.1, {"position": "a"}, None]),
        (Multinomial, "threshold", [-0.1, 1.5, math.nan]),
        (Color, "space", ["RGB", "lab"]),
        (Color, "bins", [(8, 8), (8, 8, 8, 8), (0, 8, 8), (8, 8, 65), (8.5, 8, 8), 8]),
        (Color, "sampling", ["lattice", 256, None]),
        (Lattice, "points", [0, 7, 65537, 10.5, math.nan]),
        (ParticleFilter, "particles", [0, -1, 1.5, "100", math.inf]),
        (ParticleFilter, "motion", ["random_walk", Noise(), None]),
        (ParticleFilter, "color", [Gaussian()]),
        (AppearanceRule, "fraction", [1, -0.1, math.nan]),
        (Calibration, "width", [0, math.nan]),
        (ExponentialForgetting, "learning_rate", [-0.01, 1.01, math.nan]),
        (Place, "box", [(math.nan, 0, 5, 5), (0, math.inf, 5, 5), (0, 0, 0, 5), (0, 0, 5)]),
        (Fixed, "weights", [{"color": each} for each in (0.0, -1.0, math.nan, 1e300, "much")]),
        (KalmanBins, "frames", [0, 1.5]),
        (KalmanBins, "alpha", [0, 0.6, math.nan]),
        (PerCue, "cues", [{"color": "kalman"}, {"color": PerCue()}]),
        (Autoregressive, "position_return", [1.0, -0.1, math.nan]),
        (Orientation, "kept_fraction", [1.1, math.nan]),
        (Hog, "cells", [0, 5]),
        (Hog, "rotation_normalized", [1]),
    ],
)
def test_values_that_make_no_sense(kind: type, field: str, values: list[Any]) -> None:
    for value in values:
        with pytest.raises(ConfigError, match=rf"^{field}[.\w\[\]]*: \S") as error:
            kind(**{field: value})
        assert "\n" not in str(error.value)


def test_every_part_survives_plain_values_and_toml() -> None:
    for config in CONFIGS.values():
        plain = config.to_dict()
        assert from_dict(plain, TrackerConfig) == config
        assert from_dict(msgspec.json.decode(msgspec.json.encode(plain)), TrackerConfig) == config
        assert from_dict(from_toml(config.to_toml(), "text"), TrackerConfig) == config


@pytest.mark.slow
@given(
    st.builds(
        ParticleFilter,
        particles=st.integers(1, 10_000),
        motion=st.builds(RandomWalk, noise=st.builds(Noise, position=st.floats(0, 1e6)))
        | st.builds(ConstantVelocity, persistence=st.floats(0, 1)),
        color=st.builds(
            Color,
            space=st.sampled_from(["rgb", "hsv", "hsv+v"]),
            bins=st.tuples(*[st.integers(1, 64)] * 3),
        ),
        hog=st.none() | st.builds(Hog, cells=st.integers(1, 4), rotation_normalized=st.booleans()),
        fusion=st.builds(Fixed, weights=st.dictionaries(st.just("color"), st.floats(0.1, 9))),
        likelihood=st.builds(Gaussian, sigma=st.floats(1e-3, 1e3), epsilon=st.floats(0, 1)),
        adaptation=st.builds(
            PerCue,
            cues=st.dictionaries(
                st.just("color"), st.builds(KalmanBins) | st.just(ExponentialForgetting())
            ),
        ),
    )
)
def test_any_particle_filter_survives_toml(config: ParticleFilter) -> None:
    assert from_dict(from_toml(config.to_toml(), "text"), TrackerConfig) == config


class Zone(Config, frozen=True):
    """With fields that may be None."""

    width: float | None = None
    height: float | None = None


class Zones(Config, frozen=True):
    """With a list of such."""

    zones: tuple[Zone, ...] = ()


def test_lists_with_fields_that_are_none_survive_toml() -> None:
    config = Zones((Zone(width=2.0), Zone(height=1.0)))
    assert from_dict(from_toml(config.to_toml(), "text"), Zones) == config


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"motion": {"noise": {"positon": 1}}}, "'motion.noise.positon'; did you mean 'position'?"),
        ({"kernels": 5}, "no key 'kernels'; known keys: "),  # kernel is one of color
        ({"confined": {"weight": 0}}, "Config has no key 'confined'; preset default has it."),
        ({"particles": "many"}, "Config particles: got 'many'; it takes integer, 1 to 1,000,000."),
        (
            {"motion": 3},
            "Config motion.type: this key is missing before 3; known are random_walk, ",
        ),
        ({"budget": 3}, "Config budget: got 3; it takes keys: min, max, error, bin."),
        ({"color": Color}, "color.Color'>; it takes a value of it, Color()."),  # the class itself
        ({"fusion": {"weights": {"color": 0}}}, "fusion.weights.color: got 0; it takes number, "),
        ({"motion": {"type": "teleport"}}, "motion.type: Invalid value 'teleport'"),
        (
            {"motion": {"type": "random_walk", "velocity": 1}},
            "'motion.velocity'; known keys: noise, type.",
        ),
    ],
)
def test_changes_that_do_not_fit(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError) as error:
        configure(preset("nummiaro"), changes)
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_changes() -> None:
    base: Any = preset("nummiaro")
    config: Any = configure(
        base, {"particles": 7, "motion": {"noise": {"angle": 0.5}}}, {"particles": 9}
    )
    assert config.particles == 9
    assert config.motion.noise == msgspec.structs.replace(base.motion.noise, angle=0.5)
    assert config.color == base.color
    assert base == PRESETS["nummiaro"]


def test_numbers_and_arrays_of_numpy_are_like_those_of_python() -> None:
    changes = {"particles": np.int64(200), "likelihood": {"sigma": np.float32(0.25)}}
    config = configure("nummiaro", changes, {"color": {"bins": np.full(3, 4)}})
    assert config == configure(
        "nummiaro", {"particles": 200, "likelihood": {"sigma": 0.25}, "color": {"bins": [4, 4, 4]}}
    )
    assert motes.Line(tuple(np.array([0, 0, 9, 9]))) == motes.Line((0, 0, 9, 9))
    assert motes.Ground(homography=np.eye(3)).homography == ((1, 0, 0), (0, 1, 0), (0, 0, 1))  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="particles"):
        configure("nummiaro", {"particles": np.float64(200.5)})


def test_a_change_of_type_starts_from_its_own_defaults() -> None:
    def changed(**changes: Any) -> Any:
        return configure(preset("nummiaro"), changes)

    base: Any = preset("nummiaro")
    assert changed(motion={"type": "random_walk"}).motion == RandomWalk()
    same = changed(motion={"type": "constant_velocity", "velocity": 2}).motion
    assert same == msgspec.structs.replace(base.motion, velocity=2.0)
    assert changed(color={"sampling": {"type": "every_pixel"}}).color.sampling == EveryPixel()
    assert changed(type="mean_shift") == MeanShift()


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.2", 0.2),
        ("-1e-3", -1e-3),
        ("true", True),
        ("random_walk", "random_walk"),
        ("'8'", "8"),
        ("8,8,4", [8, 8, 4]),
        ("{type = 'kalman'}", {"type": "kalman"}),
        pytest.param("1" * 5000, "1" * 5000, id="more digits than Python converts"),
    ],
)
def test_flags(text: str, value: Any) -> None:
    assert value_of(text) == value


@pytest.mark.parametrize("value", [{"points": [0, 0, 9, 9]}, 3])
def test_one_table_in_place_of_several_is_told_from_a_list(value: Any) -> None:
    """[line] in place of [[line]]."""
    takes = re.escape(f"Config line: got {value}; it takes a list of tables, as in [[line]].")
    with pytest.raises(ConfigError, match=f"^{takes}$"):
        from_dict({"line": value}, Regions)


@pytest.mark.parametrize("name", ["nummiaro", "maggio", "ng_delp", "zhao_pei"])
def test_a_printed_preset_reads_every_pixel(name: str) -> None:
    config = preset(f"{name}:printed")
    assert isinstance(config, ParticleFilter)
    assert {getattr(cue, "sampling", None) for cue in config.cues.values()} == {EveryPixel()}
    assert config.presence.in_frame or name != "nummiaro"


def test_extreme_but_allowed_values_work() -> None:
    """Neither overflows nor divides by zero, however sharp."""
    sharp = Calibration(middle=0.5, width=1e-300)
    assert [sharp.probability(d) for d in (0.0, 0.5, 1.0)] == [1, 0.5, 0]
    usual = Calibration(middle=0.3, width=0.1)
    for d in np.linspace(0, 1, 11):
        assert usual.probability(d) == pytest.approx(1 / (1 + math.exp((d - 0.3) / 0.1)))


def test_text_that_is_no_toml_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"^my.toml is not valid TOML: "):
        from_toml("a = = 1", "my.toml")
    deep = "[" * 5000 + "]" * 5000
    with pytest.raises(ConfigError, match=r"^this file is nested too deeply"):
        from_toml(f"x = {deep}", "this file")
    assert value_of(deep) == deep


class Small(Config, frozen=True, tag="small"):
    """A small one."""

    size: Count = 3
    """The size,
    in pixels."""
    left: float = 0.0
    right: float | None = None
    """The sides."""


class Large(Small, frozen=True, tag="large"):
    """A large one."""

    left: float = 0.0
    """The left side of a large one."""


def test_meanings_are_read_from_docstrings() -> None:
    assert meanings(Small) == {
        "size": "The size, in pixels.",
        "left": "The sides.",
        "right": "The sides.",
    }
    assert meanings(Large) == {**meanings(Small), "left": "The left side of a large one."}


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (int, "integer"),
        (Positive, "number, above 0, at most 1,000,000,000"),
        (Annotated[float, Meta(ge=0.25, lt=1)], "number, at least 0.25, below 1"),
        (Annotated[int, Meta(ge=8, multiple_of=8)], "integer, at least 8, multiple of 8"),
        (bool | None, "true or false"),
        (Literal["a", "b", "c"], '"a", "b" or "c"'),
        (Literal["a"], '"a"'),
        (tuple[Share, Share], "list of 2: number, 0 to 1"),
        (tuple[int, ...], "list: integer"),
        (Annotated[tuple[int, ...], Meta(min_length=6)], "list of at least 6: integer"),
        (Annotated[list[int], Meta(min_length=9, max_length=9)], "list of 9: integer"),
        (Annotated[list[int], Meta(max_length=4)], "list of 0 to 4: integer"),
        (str, "text"),
    ],
)
def test_types_in_words(kind: object, text: str) -> None:
    assert words(kind) == text


def configurations(kind: type) -> Iterator[type]:
    each: type
    for each in kind.__subclasses__():
        if each.__module__.startswith("motes.") and not each.__name__.startswith("_"):
            yield each
        yield from configurations(each)


def test_every_field_of_every_configuration_has_a_meaning() -> None:
    for module in pkgutil.walk_packages(motes.__path__, "motes."):
        if not module.name.startswith("motes.cli"):
            importlib.import_module(module.name)
    found = list(configurations(Config))
    assert len(found) > 40
    for kind in found:
        missing = {field.name for field in msgspec.structs.fields(kind)} - set(meanings(kind))
        assert not missing, f"{kind.__qualname__}: write a text below {missing}"
