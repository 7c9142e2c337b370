"""Models that learn from two looks of a target, as from both keyframes of a stretch."""

from __future__ import annotations

import numpy as np
import pytest

from motes.core.errors import ConfigError
from motes.core.frame import Frame
from motes.core.geometry import Ellipse
from motes.cues.base import Cue
from motes.cues.color import Color, Posterior
from motes.cues.correlation_filter import Correlation
from motes.sot.tracker import Tracker

REGION = Ellipse(60, 50, 16, 20)
BOX = REGION.box


def look(seed: int, index: int = 0) -> Frame:
    """Return a frame with a target whose texture is drawn anew for each seed."""
    pixels = np.full((100, 120, 3), 90, np.uint8)
    blocks = np.random.default_rng(seed).integers(0, 256, (5, 4, 3), np.uint8)
    pixels[30:70, 44:76] = blocks.repeat(8, axis=0).repeat(8, axis=1)
    return Frame(index, index / 25, pixels)


@pytest.mark.parametrize("cue", [Color(), Correlation(), Posterior()])
def test_a_model_of_two_looks_is_near_to_both(cue: Cue) -> None:
    one, two, region = look(1), look(2), np.array([REGION])
    model = cue.learn(one, REGION)
    both = cue.learn_also(model, two, REGION)
    alone = [float(cue.distances(model, frame, region)[0]) for frame in (one, two)]
    found = [float(cue.distances(both, frame, region)[0]) for frame in (one, two)]
    assert alone[0] < 0.1 or cue == Posterior()
    assert found[1] < alone[1] - 0.1
    # The first look counts more in a correlation filter, whose first frame is its anchor.
    assert found[0] == pytest.approx(found[1], abs=0.3 if isinstance(cue, Correlation) else 0.05)


@pytest.mark.parametrize("name", ["default", "nummiaro", "mean_shift"])
def test_the_target_stays_where_it_is(name: str) -> None:
    tracker = Tracker(name)
    with pytest.raises(ConfigError, match="no target yet"):
        tracker.learn_also(look(2), BOX)
    before = tracker.init(look(1), BOX)
    alone = Tracker(name)
    alone.init(look(1), BOX)
    tracker.learn_also(look(2), BOX)
    assert tracker.info.track is before
    after = tracker.update(look(2, 1))
    assert after.ellipse[:2] == pytest.approx(REGION[:2], abs=2)
    assert after.distance < alone.update(look(2, 1)).distance or name == "default"
    with pytest.raises(ConfigError, match="outside the frame"):
        tracker.learn_also(look(2), (900, 900, 9, 9))
