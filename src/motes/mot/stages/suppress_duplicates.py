"""Stage 1: of detections of the same object, the one with the highest score stays."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from motes.core.detection import Detection, best
from motes.core.frame import Frame
from motes.mot.boxes import as_rows
from motes.mot.detection_outcome import DetectionOutcome, LoggedDetection
from motes.mot.overlaps import without_duplicates
from motes.mot.scene_config import DetectionSelection


def suppress_duplicates(
    detections: Sequence[Detection], frame: Frame, config: DetectionSelection
) -> tuple[list[Detection], list[LoggedDetection]]:
    """Return the detections that can be objects, one for each, and the outcomes of the others.

    Those with the highest scores come first; of equal scores, the largest.
    """
    useful, log = list[Detection](), list[LoggedDetection]()
    for each in sorted(detections, key=lambda d: (-d.score, -d.box.width * d.box.height)):
        if not math.isfinite(each.score) or best([each], frame) is None:
            log.append(LoggedDetection(each, DetectionOutcome.USELESS))
        elif not _wanted(each, config):
            log.append(LoggedDetection(each, DetectionOutcome.UNWANTED))
        else:
            useful.append(each)
    log += [LoggedDetection(each, DetectionOutcome.SURPLUS) for each in useful[config.limit :]]
    useful = useful[: config.limit]
    kept = without_duplicates(as_rows(each.box for each in useful), config.duplicate_overlap)
    doubles = np.delete(np.arange(len(useful)), kept).tolist()
    log += [LoggedDetection(useful[i], DetectionOutcome.DOUBLE) for i in doubles]
    return [useful[i] for i in kept], log


def _wanted(each: Detection, config: DetectionSelection) -> bool:
    """Return whether a detection has a class and a score that are used."""
    known = not config.classes or each.label in config.classes
    return known and (config.least is None or each.score >= config.least)
