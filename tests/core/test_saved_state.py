"""What `Tracker.load` takes can be followed; all else is refused in one line."""

import copy
import random
from pathlib import Path
from typing import Any

import msgspec
import pytest

from broken_states import CONFIGS, EXAMPLES, check, example, mutate
from motes.core.errors import FormatError
from motes.core.saved_state import sealed, unsealed
from motes.sot.tracker import FORMAT, Tracker
from motes.sot.trackers import _SavedGroup
from oracles import region, scene


@pytest.mark.slow
@pytest.mark.parametrize(("name", "moment"), EXAMPLES)
def test_what_was_saved_is_taken(name: str, moment: str) -> None:
    assert check(example(name, moment)) == "followed"


def test_who_renames_what_is_saved_of_several_targets_raises_the_version() -> None:
    names = ("config", "seed", "begun", "bgr", "frame", "objects", "stacked")
    assert (FORMAT, _SavedGroup.__struct_fields__) == (19, names)


def test_damage_is_refused() -> None:
    """A bit of each byte of the head and the digest, and bits and ends all over the file."""
    saved, rng = example("nummiaro", "tracking"), random.Random(0)
    for place in range(60):
        data = bytearray(saved)
        data[place] ^= 1 << place % 8
        assert check(bytes(data)) == "refused"
    for _ in range(60):
        data = bytearray(mutate(rng, saved))
        assert check(bytes(data)) == ("followed" if data == saved else "refused")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        *((data, "is not a saved tracker") for data in (b"", b"no tracker", b"\x80", b"\x91" * 9)),
        (msgspec.msgpack.encode({"motes": FORMAT - 1}), "or of another version of motes"),
        (sealed(FORMAT - 1, {}), "another version of motes"),
        (sealed(13, {}), "another version of motes"),  # whose belief was no running mean
        (sealed(FORMAT, {"config": {}}), "has no state of its configuration"),
        (example("nummiaro", "started")[:-1], "is damaged"),
        (example("nummiaro", "started").replace(b"\n", b"\r\n"), "is damaged"),
    ],
)
def test_what_is_no_saved_tracker(data: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / "state").write_bytes(data)
    with pytest.raises(FormatError, match=message) as caught:
        Tracker.load(tmp_path / "state")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("other", ["mean_shift", "maggio", "default", "all, by cue"])
def test_a_state_of_another_configuration_is_refused(other: str) -> None:
    mine, its = (unsealed(FORMAT, example(name, "tracking")) for name in ("nummiaro", other))
    assert check(sealed(FORMAT, {**mine, "config": its["config"]})) == "refused"


@pytest.mark.parametrize("twice", [copy.copy, copy.deepcopy])
@pytest.mark.parametrize("name", ["default", "all, by cue"])
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
