"""Four mice of one color in an arena, rendered: how many of their places are right.

    python benchmarks/mice.py [--films 6]

They wander, stop, turn, and go to each other; they touch in about a sixth of the frames. Each is
marked in the first frame, by an upright box or by an ellipse, and all are followed by one
`Trackers`. A place is right within half a body's length of the mouse's own center, whatever the
status. `sure` is the share of the wrong ones that are tracked with a confidence of one half.

With `watch` none is marked: a `Scene` finds them before their background, and a mouse is the object
that is nearest to it after a second.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from typing import TypeAlias

import cv2
import numpy as np

from motes import Scene, Status, Track, Trackers, named_detector
from motes.core.frame import Frame
from motes.core.types import Floats

WIDTH, HEIGHT, FRAMES, MICE, RATE = 800, 600, 600, 4, 25
LONG, THIN = 26, 13
"""Half-axes of a body without its head, in pixels."""
NEAR = 26
"""Largest distance of a right place, in pixels."""
Place: TypeAlias = tuple[Track | None, Floats]
WAYS = (
    ("default", "box"), ("default", "ellipse"), ("maggio", "box"), ("maggio", "ellipse"),
    ("watch", ""),
)  # fmt: skip


def walk(rng: np.random.Generator) -> Floats:
    """Return the ways (frames, mice, 3): x, y and the direction of the head."""
    places = np.array([[200, 150], [600, 150], [200, 450], [600, 450]], float)
    angles, speeds = rng.uniform(0, 2 * np.pi, MICE), np.full(MICE, 3.0)
    goals, rests = rng.uniform(80, (WIDTH - 80, HEIGHT - 80), (MICE, 2)), np.zeros(MICE, int)
    ways = np.zeros((FRAMES, MICE, 3))
    for n in range(FRAMES):
        for k in range(MICE):
            if np.hypot(*(goals[k] - places[k])) < 30 or rng.random() < 0.004:
                alone = rng.random() < 0.5
                goals[k] = rng.uniform(70, (WIDTH - 70, HEIGHT - 70))
                if not alone:
                    goals[k] = places[rng.integers(MICE)] + rng.normal(0, 20, 2)
                rests[k] = rng.integers(10, 40) if rng.random() < 0.3 else rests[k]
            wanted = 0.2 if rests[k] else rng.uniform(3, 6)
            rests[k] = max(rests[k] - 1, 0)
            toward = np.arctan2(*(goals[k] - places[k])[::-1])
            turn = (toward - angles[k] + np.pi) % (2 * np.pi) - np.pi
            angles[k] += np.clip(turn, -0.18, 0.18) + rng.normal(0, 0.05)
            speeds[k] += 0.2 * (wanted - speeds[k])
            places[k] += speeds[k] * np.array([np.cos(angles[k]), np.sin(angles[k])])
        for i in range(MICE):
            for j in range(i):  # bodies push each other away
                apart = places[i] - places[j]
                distance = np.hypot(*apart)
                push = apart / (distance + 1e-6) * max(30 - distance, 0) / 2
                places[i] += push
                places[j] -= push
        places = places.clip(45, (WIDTH - 45, HEIGHT - 45))
        ways[n, :, :2], ways[n, :, 2] = places, angles
    return ways


def arena(rng: np.random.Generator) -> Floats:
    """Return the floor and its walls."""
    rough = rng.normal(0, 5, (HEIGHT // 10, WIDTH // 10)).astype(np.float32)
    smooth = cv2.resize(rough, (WIDTH, HEIGHT))[..., None]
    floor: Floats = np.repeat(205.0 + smooth, 3, axis=2)
    cv2.rectangle(floor, (20, 20), (WIDTH - 20, HEIGHT - 20), (120, 120, 120), 6)
    return floor


def picture(floor: Floats, mice: Floats, rng: np.random.Generator) -> Floats:
    """Return a frame: dark bodies, heads with ears, and camera noise."""
    image = floor.copy()
    for x, y, angle in mice.tolist():
        along, across = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        center = np.array([x, y])
        tail = (center - along * (LONG - 4), center - along * (LONG + 22))
        begin, end = (point.astype(int).tolist() for point in tail)
        cv2.line(image, begin, end, (110, 90, 90), 2)
        body = (center.tolist(), (2 * LONG, 2 * THIN), np.degrees(angle))
        cv2.ellipse(image, body, (40, 42, 45), -1, cv2.LINE_AA)
        head = center + along * (LONG - 3)
        cv2.circle(image, head.astype(int).tolist(), 9, (50, 52, 55), -1, cv2.LINE_AA)
        for side in (-8, 8):
            ear = head + side * across - 4 * along
            cv2.circle(image, ear.astype(int).tolist(), 4, (95, 75, 80), -1, cv2.LINE_AA)
    noisy: Floats = cv2.GaussianBlur(image, (3, 3), 0) + rng.normal(0, 3, image.shape)
    return noisy


def regions(mice: Floats, form: str) -> list[tuple[float, ...]]:
    """Return how the mice of a frame are marked."""
    if form == "ellipse":
        return [(x, y, LONG + 4, THIN + 1, angle) for x, y, angle in mice.tolist()]
    side = 2 * LONG + 4
    return [(x - side / 2, y - side / 2, side, side) for x, y, _ in mice.tolist()]


def marked(preset: str, form: str, frames: Sequence[Frame], ways: Floats) -> Iterator[Place]:
    """Yield where each mouse is followed to, after the first frame, and where it is."""
    trackers = Trackers(preset, seed=0)
    trackers.init(frames[0], regions(ways[0], form))
    for frame in frames[1:]:
        yield from zip(trackers.update(frame), ways[frame.index, :, :2], strict=True)


def watched(frames: Sequence[Frame], ways: Floats) -> Iterator[Place]:
    """Yield the object that was nearest to each mouse after a second, and where the mouse is."""
    scene, own = Scene(named_detector("background"), seed=0), [0] * MICE
    scene.prepare(frames)
    for frame, tracks in scene.watch(frames):
        places = ways[frame.index, :, :2]
        if frame.index == RATE and tracks:
            centers = np.array([each.ellipse[:2] for each in tracks])
            apart = np.linalg.norm(centers - places[:, None], axis=2)
            own = [tracks[n].identity for n in apart.argmin(axis=1)]
        if frame.index > RATE:
            known = {each.identity: each for each in tracks}
            yield from ((known.get(n), place) for n, place in zip(own, places, strict=True))


def main() -> None:
    """Print the shares of all films for each way."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--films", type=int, default=6)
    right: dict[tuple[str, str], list[bool]] = {way: [] for way in WAYS}
    sure: dict[tuple[str, str], list[bool]] = {way: [] for way in WAYS}
    for seed in range(parser.parse_args().films):
        rng = np.random.default_rng(seed)
        ways, floor = walk(rng), arena(rng)
        pictures = [picture(floor, mice, rng).clip(0, 255).astype(np.uint8) for mice in ways]
        frames = [Frame(n, n / RATE, pixels) for n, pixels in enumerate(pictures)]
        for way in WAYS:
            followed = watched(frames, ways) if way[0] == "watch" else marked(*way, frames, ways)
            for track, place in followed:
                here = track and np.linalg.norm(np.array(track.ellipse[:2]) - place) <= NEAR
                right[way].append(bool(here))
                if track and not here:
                    tracked = track.status is Status.TRACKING
                    sure[way].append(tracked and track.confidence >= 0.5)
        print(f"{seed + 1} films")
        for way in WAYS:
            shares = np.mean(right[way]), np.mean(sure[way] or [False])
            print(
                f"  {way[0]:8} {way[1]:8} right {shares[0]:.2f}, of the wrong sure {shares[1]:.2f}"
            )


if __name__ == "__main__":
    main()
