"""Several targets: each as if it were alone, whatever the threads."""

from __future__ import annotations

import numpy as np
import pytest

from motes import ConfigError, SourceError, Tracker, Trackers, synthetic
from motes.core.geometry import Box

CLIP = [frame for frame, _ in synthetic.demo((160, 120), frames=6)]
REGIONS = [Box(20, 30, 20, 30), Box(60.5, 40, 24, 20), Box(100, 20, 30, 40)]


@pytest.mark.slow
@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("preset", ["nummiaro:adaptive", "ng_delp"])
def test_each_is_followed_as_if_alone(preset: str, threads: int) -> None:
    with Trackers(preset, seed=3, threads=threads) as trackers:
        tracks = [trackers.init(CLIP[0], REGIONS)] + [trackers.update(f) for f in CLIP[1:]]
    for i, region in enumerate(REGIONS):
        alone = Tracker(preset, seed=3 + i)
        for index, frame in enumerate(CLIP):
            track = alone.update(frame) if index else alone.init(frame, region)
            assert tracks[index][i].ellipse == track.ellipse
            assert tracks[index][i].confidence == track.confidence
        np.testing.assert_array_equal(trackers.each[i].info.ellipses, alone.info.ellipses)


def test_images_count_as_frames() -> None:
    trackers = Trackers()
    trackers.init(CLIP[0].pixels, REGIONS)
    found = [trackers.update(frame.pixels) for frame in CLIP[1:3]]
    assert [[track.frame for track in tracks] for tracks in found] == [[1] * 3, [2] * 3]
    assert found[1][0].time == pytest.approx(2 / 25)


def test_init_starts_afresh() -> None:
    trackers = Trackers()
    first = trackers.init(CLIP[0], REGIONS)
    trackers.update(CLIP[1])
    again = trackers.init(CLIP[0], REGIONS[:2])
    assert [track.ellipse for track in again] == [track.ellipse for track in first[:2]]
    assert len(trackers.update(CLIP[1])) == 2


def test_what_is_refused() -> None:
    with pytest.raises(ConfigError, match="1 or more threads; got 0"):
        Trackers(threads=0)
    with pytest.raises(ConfigError, match="nothing to follow"):
        Trackers().init(CLIP[0], [])
    with pytest.raises(ConfigError, match="no targets yet"):
        Trackers().update(CLIP[0])
    trackers = Trackers()
    trackers.init(CLIP[0], REGIONS)
    with pytest.raises(ConfigError, match="center outside"):
        trackers.init(CLIP[0], [REGIONS[0], (500, 5, 10, 10)])
    assert len(trackers.update(CLIP[1])) == 3  # what was followed before still is
    with pytest.raises(SourceError, match="160x120"):
        trackers.update(np.zeros((50, 50, 3), np.uint8))


@pytest.mark.parametrize("threads", [1, 2])
def test_a_frame_s_planes_are_shared(threads: int) -> None:
    """Targets in the same place read the same plane of edges."""
    frames = [frame for frame, _ in synthetic.still((160, 120), target=(30, 40), frames=2)]
    with Trackers("ng_delp", threads=threads) as trackers:
        trackers.init(frames[0], [Box(65, 40, 30, 40)] * 4)
        frames[1].cache.clear()
        trackers.update(frames[1])
    assert len(frames[1].cache) == 1


@pytest.mark.parametrize("threads", [1, 2])
def test_nothing_goes_on_after_close(threads: int) -> None:
    with Trackers(threads=threads) as trackers:
        trackers.init(CLIP[0], REGIONS)
    with pytest.raises(ConfigError, match="are closed; make new ones"):
        trackers.update(CLIP[1])
    with pytest.raises(ConfigError, match="are closed; make new ones"):
        trackers.init(CLIP[0], REGIONS)


def test_regions_may_be_an_array() -> None:
    assert len(Trackers("nummiaro").init(CLIP[0], np.array(REGIONS))) == 3  # type: ignore[arg-type]
    for regions in (None, np.empty((0, 4))):
        with pytest.raises(ConfigError, match="nothing to follow"):
            Trackers().init(CLIP[0], regions)  # type: ignore[arg-type]
