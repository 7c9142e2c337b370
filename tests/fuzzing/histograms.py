"""Files of `KnownTarget.save`."""

import numpy as np

from motes import Ellipse, Frame, KnownTarget
from motes.cues.color import Color

from .outcomes import check_finite, outcome, put, scratch


def seeds() -> list[bytes]:
    pixels = np.arange(48 * 64 * 3, dtype=np.uint8).reshape(48, 64, 3)
    frame, region = Frame(0, 0.0, pixels), Ellipse(30, 20, 9, 6, 0.3)
    path = scratch() / "target.json"
    KnownTarget.learn(Color(bins=(4, 4, 4)), frame, region).save(path)
    return [path.read_bytes()]


def check(data: bytes) -> str:
    """Read a histogram: shares of one."""

    def read() -> None:
        target = KnownTarget.load(put("target.json", data))
        check_finite([*target.size, *target.size.box])
        shares = target.model.histogram
        check_finite(shares.tolist())
        assert abs(shares.sum() - 1) < 1e-5, shares
        assert (shares >= 0).all(), shares

    return outcome(read)
