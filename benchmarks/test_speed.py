"""Speed of one update, beside OpenCV's trackers in the same run.

python -m pytest benchmarks --benchmark-enable --benchmark-only
"""

from __future__ import annotations

import copy
from typing import Any

import pytest

from motes import Tracker
from motes.synthetic.clips import still
from motes_lab.adapters.opencv import PEERS, peer
from motes_lab.speed.measure import MAIN, OURS, SIZE, TARGETS, Film

FRAMES = 31


def rerun(benchmark: Any, start: Any, images: list[Any]) -> None:
    """Time updates one by one over the clip, starting again at its end."""
    state: dict[str, Any] = {"left": []}

    def setup() -> tuple[tuple[Any], dict[str, Any]]:
        if not state["left"]:
            state["tracker"], state["left"] = start(), images[:0:-1]
        return (copy.deepcopy(state["left"].pop()),), {}  # just written, as by a decoder

    benchmark.pedantic(lambda image: state["tracker"].update(image), setup=setup, rounds=200)


@pytest.mark.parametrize("target", TARGETS, ids="{0[0]}x{0[1]}".format)
@pytest.mark.parametrize("preset", OURS)
def test_update(benchmark: Any, preset: str, target: tuple[int, int]) -> None:
    frames, (region,) = Film.of(still(SIZE, target, FRAMES))
    tracker = Tracker(preset)
    tracker.init(frames[0], region)
    rerun(benchmark, lambda: copy.copy(tracker), frames)


@pytest.mark.parametrize("name", PEERS)
def test_peer(benchmark: Any, name: str) -> None:
    pytest.importorskip("cv2")
    frames, (region,) = Film.of(still(SIZE, MAIN, FRAMES))
    images = [frame.pixels[:, :, ::-1].copy() for frame in frames]

    def start() -> Any:
        tracker = peer(name)
        tracker.init(images[0], [round(value) for value in region.box])
        return tracker

    rerun(benchmark, start, images)
