"""What `Tracker.load` takes can be followed; all else is refused in one line."""

from __future__ import annotations

import copy
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from broken_states import CONFIGS, PLAIN, changed, check, example, part, places
from motes.core.errors import FormatError
from motes.sot.tracker import FORMAT, Tracker
from oracles import region, scene

HERE = Path(__file__).parents[1]
LEARNING = [name for name in CONFIGS if name.startswith("all")]


def load(path: Path, data: bytes) -> Tracker:
    path.write_bytes(data)
    return Tracker.load(path)


def apart(code: str) -> str:
    """Return what a process of its own prints that must end well: a signal is seen, too."""
    path = os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-W", "error::RuntimeWarning", "-c", code],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", ["default", *LEARNING])
def test_what_was_saved_is_taken(name: str) -> None:
    for moment in ("started", "tracking", "lost"):
        assert check(example(name, moment)) == "followed"


@pytest.mark.slow
def test_no_damage_harms_anybody() -> None:
    """Every array in other shapes, types and numbers; changes of bytes; all kinds of it."""
    code = """if True:
        import random
        from broken_states import check, every_broken_array, example, main, with_other_bytes
        for name, moment in (("mean_shift", "lost"), ("nummiaro", "searching")):
            for where, data in every_broken_array(example(name, moment)):
                print(where, check(data))
        rng = random.Random(0)
        for _ in range(50):
            print("bytes", check(with_other_bytes(rng, example("mean_shift", "lost"))))
        main(seed=5, count=30)
    """
    *lines, last = apart(code).splitlines()
    assert {"frame.2 refused", "frame.2 followed", "state.states refused"} <= set(lines)
    assert {line.split()[1] for line in lines} == {"refused", "followed"}
    assert last.startswith("followed: ")


@pytest.mark.parametrize(
    ("name", "where", "message"),
    [
        ("nummiaro", "models.color.histogram", r"models.color.histogram is float64 of shape"),
        ("mean_shift", "model.anchor", r"model.anchor is float64 of shape \(256,\), not"),
        ("default", "correlation.numerator", r"correlation.numerator is complex64 of shape \(15,"),
        (
            "default",
            "appearance.directions.histogram",
            r"appearance.directions.histogram is float64",
        ),
        ("all, by cue", "memories.hog.mean", r"memories.hog.mean is float64 of shape \(4,\)"),
        ("maggio", "weights.values", r"weights.values is float64 of shape \(75,\)"),
    ],
)
def test_half_an_array_is_refused_by_name(
    name: str, where: str, message: str, tmp_path: Path
) -> None:
    saved, keys = example(name, "tracking"), ("state", *where.split("."))
    dtype, shape, data = part(msgspec.msgpack.decode(saved), keys)
    half = [dtype, [shape[0] // 2, *shape[1:]], data[: len(data) // 2]]
    with pytest.raises(FormatError, match=rf"is not a saved tracker \(state.{message}"):
        load(tmp_path / "state", changed(saved, keys, half))


@pytest.mark.parametrize(
    ("name", "where", "number", "message"),
    [
        ("nummiaro", "states", np.nan, "state.states holds nan"),
        ("nummiaro", "states", 1e300, r"state.states holds 1e\+300"),
        ("nummiaro", "states", 0.0, "state.states holds 0"),
        ("all, by cue", "states", -2.0, "state.states holds -2"),
        ("nummiaro", "weights.log", np.inf, "state.weights.log holds inf"),
        ("nummiaro", "weights.values", 0.0, "state.weights.values sums to 0, not 1"),
        ("nummiaro", "search_regions", 0.0, "state.search_regions holds 0"),
        ("default", "factors", 0.0, "state.factors holds 0"),
        ("default", "posterior.inside", -1.0, "state.posterior.inside holds -1"),
        ("default", "correlation.power", np.inf, "state.correlation.power holds inf"),
        ("default", "scale.numerator", np.nan, "state.scale.numerator holds nan"),
    ],
)
def test_numbers_that_cannot_be_are_refused(
    name: str, where: str, number: float, message: str, tmp_path: Path
) -> None:
    saved, keys = example(name, "tracking"), ("state", *where.split("."))
    dtype, shape, _ = part(msgspec.msgpack.decode(saved), keys)
    data = np.full(shape, number, dtype).tobytes()
    with pytest.raises(FormatError, match=message):
        load(tmp_path / "state", changed(saved, keys, [dtype, shape, data]))


@pytest.mark.parametrize(
    ("name", "where", "value", "message"),
    [
        ("default", "ellipse", [3.0, 4.0, 0.0, 5.0, 0.0], "state.ellipse holds 0"),
        ("default", "ellipse", [3.0, 1e300, 7.0, 5.0, 0.0], "state.ellipse holds 1e"),
        ("default", "time", 0.0, "state.time is 0; 0.16 follows from the rest"),
        ("default", "scale.rows", 1, "state.scale.rows is 1"),
        ("default", "posterior.a", 9.0, "state.posterior.a is 9"),
        ("default", "standing", ["lost", 0, 0, -1], "state.standing.contradicted is -1"),
        ("default", "experts.confined.seen", -1, "state.experts.confined.seen is -1"),
        ("default", "experts.confined.reference", -0.5, "experts.confined.reference"),
        ("nummiaro", "reference_size", [3.0, 4.0, 1e9, 5.0, 0.0], "does not fit into the frame"),
        ("nummiaro", "backgrounds", {}, "state.backgrounds has , not color"),
        ("nummiaro", "frames_missed", -1, "state.frames_missed is -1"),
        ("maggio", "models.orientation.scale", 1e12, "at `state.models.orientation.scale"),
    ],
)
def test_values_that_cannot_be_are_refused(
    name: str, where: str, value: Any, message: str, tmp_path: Path
) -> None:
    data = changed(example(name, "tracking"), ("state", *where.split(".")), value)
    with pytest.raises(FormatError, match=message):
        load(tmp_path / "state", data)


@pytest.mark.parametrize(
    "data",
    [
        *(b"", b"no tracker", b"\x80", b"\xc0", b"\x01", b"\x90", b"\x91" * 100_000),
        msgspec.msgpack.encode({"motes": FORMAT, "config": {}, "seed": 0}),
        msgspec.msgpack.encode([2]),
        changed(example("nummiaro", "started"), ("random",), "[" * 100_000),
        changed(example("nummiaro", "started"), ("random",), "{}"),
        changed(example("nummiaro", "started"), ("frame", 2), ["f8,((", [1], b"12345678"]),
        changed(example("nummiaro", "started"), ("frame", 2), ["|u1", [2, 2], b"1234"]),
        changed(example("nummiaro", "started"), ("frame", 1), 1e300),
        changed(example("nummiaro", "started"), ("seed",), (1 << 64) - 1)[:-1],
    ],
)
def test_what_is_no_saved_tracker_at_all(data: bytes, tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="is not a saved tracker") as caught:
        load(tmp_path / "state", data)
    assert "\n" not in str(caught.value)


WHOLE = msgspec.msgpack.decode(example("zhao_pei", "tracking"))
JSON = st.recursive(
    st.sampled_from(PLAIN) | st.integers(-(1 << 63), (1 << 64) - 1) | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=5,
)


@pytest.mark.slow
@given(st.sampled_from([where for where in places(WHOLE) if where]), JSON)
def test_any_value_anywhere(where: tuple[Any, ...], value: Any) -> None:
    assert check(changed(example("zhao_pei", "tracking"), where, value)) in ("refused", "followed")


@pytest.mark.parametrize("twice", [copy.copy, copy.deepcopy])
@pytest.mark.parametrize("name", ["default", "nummiaro", "mean_shift", "all, by cue"])
def test_a_copy_goes_on_by_itself(name: str, twice: Any) -> None:
    tracker = Tracker(CONFIGS[name], 3)
    tracker.init(scene(0, (30, 36)), region((30, 36)))
    frames = [scene(index, (30.0 + index, 36)) for index in range(1, 6)]
    tracker.update(frames[0])
    other = twice(tracker)
    first = [tracker.update(frame).ellipse for frame in frames[1:]]
    assert [other.update(frame).ellipse for frame in frames[1:]] == first
    begun = tracker.init(frames[0], region((31, 36))), other.init(frames[0], region((31, 36)))
    assert begun[0].ellipse == begun[1].ellipse
