"""The objects of a frame, for other packages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from motes.core.optional import optional
from motes.core.track import Status
from motes.mot.tracked_object import SceneTrack


class SceneTracks(list[SceneTrack]):
    """The tracks of a frame, oldest first."""

    def to_supervision(self, names: Sequence[str] = ()) -> Any:
        """Return the visible objects as the `Detections` of supervision.

        They have `xyxy`, `confidence`, `tracker_id` and `data["class_name"]`, which is empty for
        an object without a class; and `class_id` if names of classes are given.

        Parameters
        ----------
        names
            Names of classes by their numbers. A class that is not among them has the number -1.

        Raises
        ------
        MissingDependencyError
            If supervision is not installed.
        """
        need = "Detections of supervision need that package"
        supervision = optional("supervision", need, "supervision")
        seen = [each for each in self if each.track.status is Status.TRACKING]
        numbers = {name: number for number, name in enumerate(names)}
        return supervision.Detections(
            xyxy=np.array([each.xyxy for each in seen], np.float64).reshape(-1, 4),
            confidence=np.array([each.track.confidence for each in seen], np.float64),
            class_id=np.array([numbers.get(each.label or "", -1) for each in seen], np.int64)
            if names
            else None,
            tracker_id=np.array([each.identity for each in seen], np.int64),
            data={"class_name": np.array([each.label or "" for each in seen], np.str_)},
        )
