"""Of detections of the same object, the one with the highest score stays."""

from __future__ import annotations

import math
from collections.abc import Sequence

from motes.core.detection import Detection, usable
from motes.core.frame import Frame
from motes.mot.overlaps import as_rows, without_duplicates
from motes.mot.scene_config import DetectionSelection

DUPLICATE = 0.6
"""Of two detections of which one covers more than this share of the other, one is a duplicate."""


def suppress_duplicates(
    detections: Sequence[Detection], frame: Frame, config: DetectionSelection
) -> tuple[list[Detection], int]:
    """Return the detections that can be objects, one for each, and how many are beyond the limit.

    Those with the highest scores come first; of equal scores, the largest.
    """
    useful = [
        each
        for each in detections
        if math.isfinite(each.score)
        and usable(each, frame)
        and (not config.classes or each.label in config.classes)
        and (config.least is None or each.score >= config.least)
    ]
    useful.sort(key=lambda each: (-each.score, -each.box.width * each.box.height))
    surplus = max(len(useful) - config.limit, 0)
    useful = useful[: config.limit]
    kept = without_duplicates(as_rows(each.box for each in useful), DUPLICATE)
    return [useful[i] for i in kept], surplus
