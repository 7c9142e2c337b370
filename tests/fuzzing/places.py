"""TOML of places: where a target appears, lines and zones that are counted, cameras of a rig."""

import numpy as np

from motes import Box, Ellipse, EventCounter, Frame, Ground, Regions, Status, Track
from motes.sot.known_target import boxes_of, load_places
from motes_fleet.cameras.camera_report import CameraReport, ObjectReport
from motes_fleet.cameras.reidentification import CrossCameraAssociation
from motes_fleet.cameras.rig_config import Rig

from .outcomes import check_finite, outcome, put

EMPTY = np.zeros((48, 64, 3), np.uint8)
WALK = [(4.0 * i - 20, 2.0 * i + 3) for i in range(25)]
"""Where somebody walks: the upper left corner of a box."""


def doors() -> list[bytes]:
    return [
        b'[[place]]\nname = "door"\nbox = [10, 5, 30, 20]\n\n[[place]]\nname = "rim"\nborder = 4\n',
        b'place = [{box = [0.5, 1e1, 20, 20]}, {name = "\\u00e9", border = 10}]\n',
    ]


def check_doors(data: bytes) -> str:
    """Read places, and find them in a frame."""
    path = put("places.toml", data)
    return outcome(
        lambda: check_finite(np.ravel(boxes_of(load_places(path), Frame(0, 0.0, EMPTY))).tolist())
    )


def counted() -> list[bytes]:
    zones = b"""[[line]]
name = "gate"
points = [32, 0, 32, 48]

[[zone]]
points = [10, 10, 60, 10, 60, 40, 10, 40]
dwell = 0.5

[[zone]]
name = "bed"
points = [0, 0, 64.5, 0, 30, 4.8e1]

[ground]
"""
    return [
        zones + b"scale = 20\n",
        zones + b"homography = [[0.05, 0, 0], [0, 0.05, 0], [0, 0.001, 1]]\n",
        zones + b"points = [[0, 0, 0, 0], [64, 0, 3, 0], [64, 48, 3, 2], [0, 48, 0, 2.5]]\n",
    ]


def check_counted(data: bytes) -> str:
    """Read lines, zones and ground, and count somebody who walks."""

    def read() -> None:
        places = Regions.parse(data.decode(errors="replace"))
        counting = EventCounter(places)
        for index, (x, y) in enumerate(WALK):
            for event in counting.update([_walker(index, x, y)]):
                event.json()
                check_finite([event.x, event.y, event.speed, event.metres_per_second])
        if places.ground is not None:
            _check_ground(places.ground)

    return outcome(read)


def _check_ground(ground: Ground) -> None:
    for point in ((0.0, 0.0), (63.0, 47.0), (-1e4, 1e4)):
        check_finite(ground.metres(point) or ())


def _walker(index: int, x: float, y: float) -> Track:
    status = Status.TRACKING if index < len(WALK) - 1 else Status.LOST
    ellipse = Ellipse.from_box(Box(x, y, 10, 20))
    return Track(index, index / 10, ellipse, np.eye(5), 0.9, status, 0.1, 80.0)


def rigs() -> list[bytes]:
    return [
        b"""[[camera]]
name = "hall"
source = "hall.mp4"
detector = "background"
place = [{name = "door", box = [0, 0, 20, 40]}]

[[camera]]
name = "yard"
source = "0"
offset = 1.5
[[camera.place]]
name = "gate"
border = 10

[[passage]]
between = ["hall/door", "yard/gate"]
seconds = [0, 4.5]
distance = 0.5
scale = 1.5

[[overlap]]
cameras = ["hall", "yard"]
homography = [[1, 0, 5], [0, 1, 0], [0, 0.001, 1]]
reach = 1
"""
    ]


def check_rig(data: bytes) -> str:
    """Read a rig, and hand somebody over from its first camera to its last one."""

    def read() -> None:
        rig = Rig.parse(data.decode(errors="replace"))
        handover, cameras = CrossCameraAssociation(rig), rig.camera
        for index, (x, y) in enumerate(WALK):
            for camera in (cameras[0], cameras[-1]):
                handover.update(_report(camera.name, index, x, y))

    return outcome(read)


def _report(camera: str, index: int, x: float, y: float) -> CameraReport:
    histogram = np.full(8, 1 / 8, np.float32).tobytes()
    status = Status.TRACKING if index % 5 else Status.OCCLUDED
    seen = ObjectReport(
        1,
        status,
        Box(x, y, 10, 20),
        0.9,
        None,
        bool(index % 5),
        ("door",),
        histogram,
        look=histogram,
    )
    return CameraReport(camera, index, index / 10, (seen,))
