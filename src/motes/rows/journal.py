"""A journal: the objects of each frame, in a file that grows with the run.

Annotation documents are complete only at the end of a run and are made from the journal; a run that
is killed loses no frame. The first line is a `Header`, each other line a `FrameRow`, all in JSON.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Self

import msgspec
import numpy as np

from motes.core.geometry import Box, Ellipse
from motes.core.labels import check_label
from motes.core.track import Status, Track, finite
from motes.mot.analytics.real_units import GroundPlace
from motes.rows.schema import DEVIATIONS

ENDING = ".rows.jsonl"
"""Added to the name of a document, this is the name of its journal."""


class ObjectRow(msgspec.Struct, frozen=True, array_like=True):
    """An object in a frame, with fields of `Track`.

    Attributes
    ----------
    mask
        Its pixels, in the compressed runs of COCO (`motes.formats.runs`); None without a mask.
    """

    identity: int
    ellipse: Ellipse
    confidence: float
    status: Status
    occluded_by: int | None = None
    label: str | None = None
    mask: str | None = None
    more: dict[str, float | str | None] = {}
    """Further columns of its row, by name, such as `speed`."""
    keyframe: bool = True
    """Whether a user has drawn it, or would have to: a tool that interpolates needs this one."""
    distance: float | None = None
    effective_sample_size: float | None = None
    """As in `Track`; None where they are not known."""
    bounds: Box | None = None
    """The box around the ellipse, where a file says it more exactly than the ellipse does."""

    @classmethod
    def of(cls, track: Track, further: Mapping[str, float | None] = {}) -> Self:
        """Return the row of an object, with further columns."""
        return cls(
            track.identity,
            Ellipse(*map(float, track.ellipse)),  # a caller may give NumPy numbers
            float(track.confidence),
            track.status,
            track.occluded_by,
            check_label(track.label) if track.label else None,
            more={**further},
            distance=finite(track.distance),
            effective_sample_size=finite(track.effective_sample_size),
        )

    @classmethod
    def of_target(cls, track: Track | None, further: Mapping[str, float | None] = {}) -> Self:
        """Return the row of the one target of a tracker, with the identity 1.

        Without a track it is searched for, and has no place.
        """
        if track is None:
            return cls.nowhere(1)
        return cls.of(track, further)

    @classmethod
    def nowhere(cls, identity: int, status: Status = Status.SEARCHING) -> Self:
        """Return the row of an object that has no place in a frame."""
        return cls(identity, Ellipse(*[math.nan] * 5), math.nan, status)

    def number(self, name: str) -> float:
        """Return the number in a further column; NaN where it is not known."""
        value = self.more.get(name)
        return float(value) if isinstance(value, int | float) else math.nan

    def track(self, frame: int, time: float) -> Track:
        """Return it as a track of that frame; what is not known is NaN."""
        size = self.effective_sample_size
        return Track(
            frame,
            time,
            self.ellipse,
            np.diag([self.number(name) ** 2 for name in DEVIATIONS]),
            self.confidence,
            self.status,
            math.nan if self.distance is None else self.distance,
            math.nan if size is None else size,
            outlier=self.number("outlier") == 1,
            identity=self.identity,
            label=self.label,
            occluded_by=self.occluded_by,
        )

    @property
    def box(self) -> Box:
        """The axis-parallel box around the ellipse; NaN for one without a finite angle."""
        if self.bounds is not None:
            return self.bounds
        return self.ellipse.box if math.isfinite(self.ellipse.theta) else Box(*[math.nan] * 4)

    @property
    def placed(self) -> bool:
        """Whether it has a place, perhaps only a guess."""
        return math.isfinite(self.ellipse.x)

    @property
    def searched(self) -> bool:
        """Whether it is searched for without a guess of its place; an absent one is not."""
        return not self.placed and self.status is not Status.ABSENT


class FrameRow(msgspec.Struct, frozen=True, omit_defaults=True):
    """A frame: its index, its time in seconds, its objects, and its file if it is an image.

    Attributes
    ----------
    searched
        Identities of objects that are searched for and have no place, where `objects` lacks them.
    """

    frame: int
    time: float
    objects: tuple[ObjectRow, ...]
    file: str | None = None
    searched: tuple[int, ...] = ()

    def values(self, each: ObjectRow, further: Sequence[str] = ()) -> list[Any]:
        """Return the fields of an object's row: those of `COLUMNS`, and of further columns."""
        return [
            self.frame, self.time, each.identity, each.label, *each.box, *each.ellipse,
            each.confidence, each.status.value, each.distance, each.effective_sample_size,
            each.occluded_by, *(each.more.get(name) for name in further),
        ]  # fmt: skip


class Header(msgspec.Struct, frozen=True, tag_field="motes", tag="rows 1"):
    """What all frames share: the source's name, the size in pixels, the usual class of objects."""

    source: str
    width: int
    height: int
    label: str


def journal_of(name: str) -> Path:
    """Return the path of a document's journal."""
    return Path(f"{Path(name)}{ENDING}")  # a folder's name may end in a slash


def text_name(name: str) -> str:
    """Return the name of a file with escapes for bytes that are no text, as of old disks."""
    return name.encode(errors="backslashreplace").decode()


def object_rows(
    tracks: Iterable[Track], places: Mapping[int, GroundPlace] = {}
) -> tuple[ObjectRow, ...]:
    """Return the rows of the objects in a frame, with their places on the ground, by identity."""
    known = {identity: place.columns for identity, place in places.items()}
    return tuple(ObjectRow.of(each, known.get(each.identity, {})) for each in tracks)
