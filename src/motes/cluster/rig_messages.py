"""What a handover actor sends to the program, beside messages about its cameras."""

from __future__ import annotations

import msgspec
from msgspec.structs import replace

from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import CameraEnded, CameraMessage


class Associated(msgspec.Struct, frozen=True, tag=True):
    """A report with the identities of its objects.

    Attributes
    ----------
    report
        The report, without what only an association needs.
    identities
        The identities in the rig, by those in the camera.
    newest
        The newest identity of the part of the rig.
    live
        Whether its camera is live.
    """

    report: CameraReport
    identities: dict[int, int]
    newest: int
    live: bool


class PartEnded(msgspec.Struct, frozen=True, tag=True):
    """All cameras of a part have ended; with the attributes of its association."""

    handed: int
    merged: dict[int, int]


PartNews = Associated | CameraMessage | CameraEnded | PartEnded


def for_rows(report: CameraReport) -> CameraReport:
    """Return a report with what rows need: a histogram is most of its bytes."""
    sightings = tuple(replace(each, histogram=None, covariance=()) for each in report.sightings)
    return replace(report, sightings=sightings)
