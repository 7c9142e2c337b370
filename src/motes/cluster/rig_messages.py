"""The messages between handover actors and the program, beside messages about cameras.

- An *entry* is what a handover actor was sent. Its state follows from its entries, in their order.
- A `Batch` has entries, and the news that follow from them. The program holds the entries: a new
  process of the actor starts from them.
"""

from __future__ import annotations

import msgspec
from msgspec.structs import replace

from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import CameraEnded, CameraMessage


class Received(msgspec.Struct, frozen=True, tag=True):
    """A message of a camera, encoded, and when it came."""

    camera: str
    data: bytes
    time: float


class Died(msgspec.Struct, frozen=True, tag=True):
    """The actor of a camera has ended, for a reason, at a time."""

    camera: str
    why: str
    time: float


Entry = Received | Died


class Associated(msgspec.Struct, frozen=True, tag=True):
    """A report with the identities of its objects.

    Attributes
    ----------
    report
        The report, without what only an association needs.
    identities
        The identities in the group, by those in the camera.
    newest
        The newest identity of the group.
    live
        Whether its camera is live.
    """

    report: CameraReport
    identities: dict[int, int]
    newest: int
    live: bool


class Restart(msgspec.Struct, frozen=True, tag=True):
    """A camera must be started again, after a pause in seconds; `life` counts its starts."""

    camera: str
    life: int
    pause: float


class GroupEnded(msgspec.Struct, frozen=True, tag=True):
    """All cameras of a group have ended; with the attributes of its association."""

    handed: int
    merged: dict[int, int]


GroupNews = Associated | CameraMessage | CameraEnded | GroupEnded


class Batch(msgspec.Struct, frozen=True):
    """What happened in a handover actor since the last batch.

    Attributes
    ----------
    count
        The number of entries since the start of the run.
    entries
        The new ones, as an encoded list; empty if `state` has them.
    news
        What follows from them for the program.
    state
        The state after all entries, where it takes the place of all that the program holds.
    """

    count: int
    entries: bytes
    news: list[GroupNews | Restart]
    state: bytes | None = None


def for_rows(report: CameraReport) -> CameraReport:
    """Return a report with what rows need: a histogram is most of its bytes."""
    sightings = tuple(replace(each, histogram=None, covariance=()) for each in report.sightings)
    return replace(report, sightings=sightings)
