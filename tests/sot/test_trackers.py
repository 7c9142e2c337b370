"""Several targets in one video, whatever the threads."""

import copy
import itertools
import pickle
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from motes import Box, ConfigError, FormatError, Frame, SourceError, Tracker, Trackers, synthetic
from motes.sot.discriminative.tracker import Discriminative

REGIONS = [Box(20, 30, 20, 30), Box(60.5, 40, 24, 20), Box(100, 20, 30, 40)]


@cache
def clip() -> list[Frame]:
    return [frame for frame, _ in synthetic.demo((160, 120), frames=6)]


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("preset", ["nummiaro:adaptive", "ng_delp"])
def test_each_is_followed_as_if_alone(preset: str, threads: int) -> None:
    with Trackers(preset, seed=3, threads=threads) as trackers:
        tracks = [trackers.init(clip()[0], REGIONS)] + [trackers.update(f) for f in clip()[1:]]
    for i, region in enumerate(REGIONS):
        alone = Tracker(preset, seed=3 + i)
        for index, frame in enumerate(clip()):
            track = alone.update(frame) if index else alone.init(frame, region)
            assert tracks[index][i].ellipse == track.ellipse
            assert tracks[index][i].confidence == track.confidence
        np.testing.assert_array_equal(trackers.each[i].info.ellipses, alone.info.ellipses)


def test_one_of_several_is_corrected() -> None:
    """It goes on from there as a tracker alone does, and so do the others from where they are."""
    trackers, alone = Trackers("nummiaro"), Tracker("nummiaro", seed=1)
    trackers.init(clip()[0], REGIONS)
    alone.init(clip()[0], REGIONS[1])
    moved = REGIONS[1]._replace(x=64)
    assert [each.correct(moved).identity for each in (trackers.each[1], alone)] == [2, 1]
    found = trackers.update(clip()[1])
    assert [each.identity for each in found] == [1, 2, 3]
    assert [each.info.track.identity for each in trackers.each] == [1, 2, 3]
    assert found[1].ellipse == alone.update(clip()[1]).ellipse


def test_what_is_refused() -> None:
    with pytest.raises(ConfigError, match="1 or more threads; got 0"):
        Trackers(threads=0)
    Trackers("nummiaro", threads=np.int64(2)).close()  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="No preset 'csrt'"):
        Trackers("csrt")
    with pytest.raises(ConfigError, match="nothing to follow"):
        Trackers().init(clip()[0], [])
    for regions in (None, iter(REGIONS)):
        with pytest.raises(ConfigError, match="Give a list of regions; got "):
            Trackers().init(clip()[0], regions)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match="no targets yet"):
        Trackers().update(clip()[0])
    trackers = Trackers()
    trackers.init(clip()[0], REGIONS)
    with pytest.raises(ConfigError, match="center outside"):
        trackers.init(clip()[0], [REGIONS[0], (500, 5, 10, 10)])
    assert len(trackers.update(clip()[1])) == 3  # what was followed before still is
    with pytest.raises(SourceError, match="160x120"):
        trackers.update(np.zeros((50, 50, 3), np.uint8))
    trackers.close()
    with pytest.raises(ConfigError, match="are closed; make new ones"):
        trackers.update(clip()[1])
    with pytest.raises(ConfigError, match="are closed; make new ones"):
        trackers.init(clip()[0], REGIONS)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_frame_s_planes_are_shared(threads: int) -> None:
    """Targets in the same place read the same plane of edges."""
    frames = [frame for frame, _ in synthetic.still((160, 120), target=(30, 40), frames=2)]
    with Trackers("ng_delp", threads=threads) as trackers:
        trackers.init(frames[0], [Box(65, 40, 30, 40)] * 4)
        frames[1].cache.clear()
        trackers.update(frames[1])
    assert len(frames[1].cache) == 1


@pytest.mark.parametrize(("conflicts", "asks"), [(0, 1), (1, 2), (9, 3)])
def test_who_looks_elsewhere_may_find_a_third_one(
    conflicts: int, asks: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Steps are taken anew until nobody is where another one is, but not for ever."""
    asked: list[tuple[list[Any], list[Any]]] = []

    def displaced(
        self: Discriminative, before: list[Any], after: list[Any], stacked: set[tuple[int, int]]
    ) -> dict[int, Any]:
        asked.append(([*before], [*after]))
        return {0: replace(before[0])} if len(asked) <= conflicts else {}

    monkeypatch.setattr(Discriminative, "displaced", displaced)
    trackers = Trackers()
    trackers.init(clip()[0], REGIONS)
    trackers.update(clip()[1])
    assert len(asked) == asks
    for (before, after), (again, anew) in itertools.pairwise(asked):
        assert before[0] is not again[0]
        assert after[0] is not anew[0]
        assert (before[1:], after[1:]) == (again[1:], anew[1:])


def test_objects_come_and_go() -> None:
    """What was there before is followed as if nothing had happened."""
    trackers, alone = Trackers("nummiaro", seed=3), Tracker("nummiaro", seed=4)
    trackers.init(clip()[0], REGIONS[:1])
    trackers.update(clip()[1])
    first = trackers.add(REGIONS[1])
    assert first.identity == 2
    assert first.ellipse == alone.init(clip()[1], REGIONS[1]).ellipse
    trackers.update(clip()[2])
    trackers.remove(1)
    alone.update(clip()[2])
    [track] = trackers.update(clip()[3])
    assert track.identity == 2
    assert track.ellipse == alone.update(clip()[3]).ellipse
    trackers.remove(2)
    assert trackers.update(clip()[4]) == []
    third = trackers.add(REGIONS[2])
    assert (third.frame, third.identity) == (4, 3)
    for identity in (1, -1, None):
        with pytest.raises(ConfigError, match=f"no object {identity}; the identities are 3"):
            trackers.remove(identity)  # type: ignore[arg-type]


@pytest.mark.parametrize("threads", [1, 3])
def test_saved_trackers_go_on(tmp_path: Path, threads: int) -> None:
    trackers = Trackers("nummiaro", seed=3, bgr=True)
    with pytest.raises(ConfigError, match="no targets yet"):
        trackers.save(tmp_path / "saved")
    bgr = [frame.pixels[:, :, ::-1] for frame in clip()]
    trackers.init(bgr[0], REGIONS)
    trackers.update(bgr[1])
    trackers.remove(2)
    trackers.save(tmp_path / "saved")
    with Trackers.load(tmp_path / "saved", threads=threads) as other:
        for each in (trackers, other):
            each.add(REGIONS[0])
        for picture in bgr[2:4]:
            found, again = trackers.update(picture), other.update(picture)
            assert [track.ellipse for track in found] == [track.ellipse for track in again]
            assert [track.time for track in found] == [track.time for track in again]
            assert [track.identity for track in found + again] == [1, 3, 4, 1, 3, 4]
    for broken in (b"", (tmp_path / "saved").read_bytes()[:-9]):
        (tmp_path / "broken").write_bytes(broken)
        with pytest.raises(FormatError, match=r"is not a saved tracker|is damaged"):
            Trackers.load(tmp_path / "broken")
    with pytest.raises(FormatError, match=r"holds several targets, for Trackers\.load"):
        Tracker.load(tmp_path / "saved")
    trackers.each[0].save(tmp_path / "one")
    with pytest.raises(FormatError, match=r"holds a single target, for Tracker\.load"):
        Trackers.load(tmp_path / "one")


@pytest.mark.parametrize(
    "twice", [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))]
)
def test_a_copy_is_independent(twice: Callable[[Trackers], Trackers]) -> None:
    with Trackers("nummiaro", threads=2) as trackers:
        trackers.init(clip()[0], REGIONS)
        trackers.update(clip()[1])
        with twice(trackers) as other:
            found = other.update(clip()[2])
            other.remove(1)
        again = trackers.update(clip()[2])
        assert [track.ellipse for track in found] == [track.ellipse for track in again]
