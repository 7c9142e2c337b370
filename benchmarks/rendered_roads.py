"""Roads drawn with vehicles whose crossings of a line are known.

A camera on a bridge or beside a road looks at lanes in perspective. Vehicles are blocks with a
cabin of glass. Some are as dark as the asphalt's shade, some go side by side, each has a shadow,
and the camera changes its exposure. All numbers are drawn from a seed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np

from motes.core.frame import Frame
from motes.core.types import Floats

WIDTH, HEIGHT, FPS = 480, 270, 25.0
LANE, LENGTH = 3.5, 90.0
"""Width of a lane and length of the road that is seen, in metres."""


class Vehicle(NamedTuple):
    """A block of length, width and height in metres, from `start` seconds on in a lane."""

    start: float
    lane: int
    speed: float
    size: tuple[float, float, float]
    color: tuple[float, float, float]


class Road(NamedTuple):
    """A road: its camera (3, 4), its lanes' directions, its vehicles, and how light changes."""

    camera: Floats
    lanes: tuple[int, ...]
    vehicles: tuple[Vehicle, ...]
    seconds: float
    gains: Floats
    asphalt: float
    line: tuple[float, float, float, float]
    across: float

    def crossings(self) -> tuple[list[int], list[int]]:
        """Return the frames in which vehicles' near ends pass the line, away and towards."""
        sides: tuple[list[int], list[int]] = ([], [])
        for each in self.vehicles:
            away = self.lanes[each.lane] > 0
            way = self.across + each.size[0] if away else LENGTH - self.across
            frame = round((each.start + way / each.speed) * FPS)
            if 0 <= frame < self.seconds * FPS:
                sides[not away].append(frame)
        return sorted(sides[0]), sorted(sides[1])


def road(seed: int) -> Road:
    """Return the road of a seed."""
    rng = np.random.default_rng(seed)
    lanes = ((1, 1, -1, -1), (1, 1), (1, -1), (1, 1, 1))[rng.integers(4)]
    middle = len(lanes) * LANE / 2
    beside = rng.uniform(-8, 8)
    eye = np.array([middle + beside, -rng.uniform(6, 14), rng.uniform(7, 12)])
    camera = _camera(eye, np.array([middle, LENGTH * 0.35, 0.0]), rng.uniform(420, 560))
    vehicles: list[Vehicle] = []
    seconds, asphalt = 16.0, rng.uniform(95, 150)
    pace = rng.uniform(9, 20)
    for lane in range(len(lanes)):
        time = rng.uniform(-4, 2)
        while time < seconds:
            vehicles.append(_vehicle(rng, time, lane, pace, asphalt))
            time += rng.uniform(1.0, 5.0) + vehicles[-1].size[0] / pace
    gains = np.ones(int(seconds * FPS))
    for _ in range(2):  # the exposure rises or falls within some frames
        at = rng.integers(100, len(gains) - 50)
        gains[at:] *= np.interp(np.arange(len(gains) - at), [0, 8], [1, rng.uniform(0.8, 1.25)])
    across = LENGTH * rng.uniform(0.15, 0.3)
    ends = _seen(camera, np.array([[-2, across, 0], [len(lanes) * LANE + 2, across, 0]]))
    line = (*ends[0].tolist(), *ends[1].tolist())
    return Road(camera, lanes, tuple(vehicles), seconds, gains, asphalt, line, across)


def _vehicle(
    rng: np.random.Generator, time: float, lane: int, pace: float, asphalt: float
) -> Vehicle:
    """Return a vehicle: three of ten are of the road's own dark gray, one of ten a truck."""
    size = (rng.uniform(3.8, 4.8), rng.uniform(1.7, 1.9), rng.uniform(1.4, 1.7))
    if rng.random() < 0.1:
        size = (rng.uniform(7, 11), 2.5, rng.uniform(3, 3.8))
    color = np.full(3, asphalt * rng.uniform(0.45, 0.75))
    if rng.random() >= 0.3:
        color = rng.uniform(20, 235, 3)
    red, green, blue = color.tolist()
    return Vehicle(time, lane, pace * rng.uniform(0.97, 1.03), size, (red, green, blue))


def frames(of: Road, seed: int) -> Iterator[Frame]:
    """Yield the pictures of a road, compressed as a camera does."""
    rng = np.random.default_rng((seed, 1))
    ground = _ground(of, rng)
    for n in range(len(of.gains)):
        picture, time = ground.copy(), n / FPS
        there = []
        for each in of.vehicles:
            way = (time - each.start) * each.speed
            if -12 < way < LENGTH + 12:
                there.append((way if of.lanes[each.lane] > 0 else LENGTH - way, each))
        for way, each in sorted(there, key=lambda pair: -pair[0]):
            _draw(picture, of, way, each)
        noisy = picture * of.gains[n] + rng.normal(0, 2, picture.shape)
        coded = cv2.imencode(".jpg", noisy.clip(0, 255).astype(np.uint8), [1, 60])[1]
        decoded = np.asarray(cv2.imdecode(coded, 1), np.uint8)
        yield Frame(n, time, np.ascontiguousarray(decoded[:, :, ::-1]))


def _draw(picture: Floats, of: Road, way: float, each: Vehicle) -> None:
    """Draw a vehicle whose front or rear is `way` metres along the road, and its shadow."""
    long, wide, high = each.size
    left = each.lane * LANE + (LANE - wide) / 2
    near, far = (way - long, way) if of.lanes[each.lane] > 0 else (way, way + long)
    mask = np.zeros(picture.shape[:2], np.uint8)
    corners = [
        (left, near),
        (left + wide + 0.7 * high, near),
        (left + wide + 0.7 * high, far),
        (left, far),
    ]
    shadow = _seen(of.camera, np.array([(x, y, 0.0) for x, y in corners]))
    cv2.fillConvexPoly(mask, np.rint(shadow * 4).astype(np.int32), 1, cv2.LINE_8, 2)
    picture[mask > 0] *= 0.6
    glass = of.asphalt * 0.7
    body = [
        (near, far, 0.3, 0.55 * high, 1.0),
        (near + 0.2 * long, far - 0.15 * long, 0.55 * high, high, 0.0),
    ]
    if high > 2:
        body = [(near, far, 0.4, high, 1.0)]
    for begin, end, low, top, own in body:
        for face, light in _faces(left, left + wide, begin, end, low, top, of.camera):
            color = own * np.array(each.color) + (1 - own) * glass
            color = np.array(each.color) if light == 1.0 else color * light
            points = np.rint(_seen(of.camera, face) * 4).astype(np.int32)
            cv2.fillConvexPoly(picture, points, color.tolist(), cv2.LINE_8, 2)


def _faces(
    left: float, right: float, near: float, far: float, low: float, top: float, camera: Floats
) -> list[tuple[Floats, float]]:
    """Return the faces of a block that a camera above sees, the roof last, with their light."""
    eye = -np.linalg.inv(camera[:, :3]) @ camera[:, 3]
    faces = []
    side = right if eye[0] > (left + right) / 2 else left
    faces.append(([(side, near, low), (side, far, low), (side, far, top), (side, near, top)], 0.75))
    faces.append(
        ([(left, near, low), (right, near, low), (right, near, top), (left, near, top)], 0.85)
    )
    faces.append(
        ([(left, near, top), (right, near, top), (right, far, top), (left, far, top)], 1.0)
    )
    return [(np.array(face), light) for face, light in faces]


def _ground(of: Road, rng: np.random.Generator) -> Floats:
    """Return the empty road."""
    coarse = rng.normal(0, 10, (HEIGHT // 3, WIDTH // 3, 3))
    texture = np.asarray(cv2.resize(coarse, (WIDTH, HEIGHT)), np.float64)
    picture: Floats = np.array([70.0, 110.0, 80.0]) + 2 * texture
    wide = len(of.lanes) * LANE
    mask = np.zeros((HEIGHT, WIDTH), np.uint8)
    corners = np.array([(-1, 1, 0), (wide + 1, 1, 0), (wide + 1, 400, 0), (-1, 400, 0)], float)
    cv2.fillConvexPoly(mask, np.rint(_seen(of.camera, corners)).astype(np.int32), 1)
    picture[mask > 0] = of.asphalt + texture[mask > 0] * 0.5
    for lane in range(len(of.lanes) + 1):
        for start in range(1, 200, 8):
            x = lane * LANE
            dash = [
                (x - 0.1, start, 0),
                (x + 0.1, start, 0),
                (x + 0.1, start + 4, 0),
                (x - 0.1, start + 4, 0),
            ]
            points = np.rint(_seen(of.camera, np.array(dash, float)) * 4).astype(np.int32)
            cv2.fillConvexPoly(picture, points, (210, 210, 210), cv2.LINE_8, 2)
    return picture


def _camera(eye: Floats, target: Floats, focal: float) -> Floats:
    """Return the matrix (3, 4) of a camera at a place that looks at another."""
    ahead = (target - eye) / np.linalg.norm(target - eye)
    right = np.cross(ahead, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    turn = np.array([right, np.cross(ahead, right), ahead])
    inner = np.array([[focal, 0, WIDTH / 2], [0, focal, HEIGHT / 2], [0, 0, 1]])
    camera: Floats = inner @ np.hstack([turn, -turn @ eye[:, None]])
    return camera


def _seen(camera: Floats, points: Floats) -> Floats:
    """Return where points (n, 3) are in the picture, (n, 2)."""
    at = np.hstack([points, np.ones((len(points), 1))]) @ camera.T
    places: Floats = at[:, :2] / np.maximum(at[:, 2:], 0.5)
    return places
