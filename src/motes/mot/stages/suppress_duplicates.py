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
    useful = [each for each in detections if _useful(each, frame) and _wanted(each, config)]
    useful.sort(key=lambda each: (-each.score, -each.box.width * each.box.height))
    surplus = max(len(useful) - config.limit, 0)
    useful = useful[: config.limit]
    kept = without_duplicates(as_rows(each.box for each in useful), DUPLICATE)
    return [useful[i] for i in kept], surplus


def _useful(each: Detection, frame: Frame) -> bool:
    """Return whether a tracker can start on a detection."""
    return math.isfinite(each.score) and usable(each, frame)


def _wanted(each: Detection, config: DetectionSelection) -> bool:
    """Return whether a detection has a class and a score that are used."""
    known = not config.classes or each.label in config.classes
    return known and (config.least is None or each.score >= config.least)
