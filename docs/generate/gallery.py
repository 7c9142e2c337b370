"""Render the pictures of docs/gallery.md into docs/images/gallery: `make gallery`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from motes import Detection, Scene, Tracker, synthetic
from motes.mot.analytics.events import EventCounter
from motes.mot.analytics.regions import Line, Regions, Zone
from motes.mot.detection.background import BackgroundDetector
from motes.output.overlay import draw, font
from motes.output.scene_overlay import draw_scene
from motes.synthetic import Clip, Target, Truth
from motes.synthetic.painted_film import PaintedFilm

FOLDER = Path(__file__).parent.parent / "images" / "gallery"
SIZE = (320, 240)
HIGH = 200
"""Height of the README's animation."""
Pixels = NDArray[np.uint8]


def followed(clip: Clip, tracker: Tracker, moments: Sequence[int]) -> list[Pixels]:
    """Return the frames of a clip at these moments, with particles, estimate and status.

    Of a frame larger than `SIZE`, that much around the target.
    """
    shown = []
    for frame, (truth, *_) in clip:
        track = tracker.update(frame) if frame.index else tracker.init(frame, truth.ellipse)
        if frame.index in moments:
            info = tracker.info
            label = f"{frame.index}: {track.status} {track.confidence:.2f}"
            dots = {"particles": info.ellipses, "weights": info.weights}
            (width, height), center = SIZE, truth.ellipse[:2]
            left = int(np.clip(center[0] - width / 2, 0, frame.width - width))
            top = int(np.clip(center[1] - height / 2, 0, frame.height - height))
            drawn = Image.fromarray(draw(frame.pixels, track, label="", **dots))
            drawn = drawn.crop((left, top, left + width, top + height))
            ImageDraw.Draw(drawn).text(
                (8, 6), label, "white", font(14), stroke_width=2, stroke_fill="black"
            )
            shown.append(np.array(drawn))
    return shown


def walker(first: int, speed: float, y: float, shirt: tuple[int, int, int]) -> Target:
    """Return a person who enters at frame `first`, with this speed in pixels a frame."""
    walked = speed * np.maximum(np.arange(160) - first, 0)
    x = walked + (-20 if speed > 0 else SIZE[0] + 20)
    states = [(place, y, 26, 12, -math.pi / 2) for place in x]
    return Target(np.array(states, np.float64), (shirt, (40, 36, 44), (214, 170, 140)))


def watched(clip: Clip, moments: Sequence[int], places: Regions) -> list[Pixels]:
    """Return the frames at these moments, with identities and ways; detections are the truth's.

    Nobody who is covered for the most part is detected.
    """
    truths: dict[int, Sequence[Truth]] = {}
    scene = Scene(lambda frame: _seen(truths[frame.index]), seed=0)
    trails: dict[int, list[tuple[float, float]]] = {}
    shown = []
    for frame, there in clip:
        truths[frame.index] = there
        objects = scene.update(frame)
        for each in objects:
            x, y, width, height = each.track.box
            trails.setdefault(each.identity, []).append((x + width / 2, y + height))
        if frame.index in moments:
            ways = {each.identity: trails[each.identity] for each in objects}
            shown.append(draw_scene(frame.pixels, objects, ways, places))
    return shown


def _seen(truths: Sequence[Truth]) -> list[Detection]:
    return [Detection(truth.ellipse.box) for truth in truths if truth.visible > 0.5]


def save(name: str, pictures: Sequence[Pixels]) -> None:
    """Write pictures side by side, with a white gap between them."""
    gap = np.full((pictures[0].shape[0], 6, 3), 255, np.uint8)
    row = [part for picture in pictures for part in (picture, gap)][:-1]
    Image.fromarray(np.hstack(row)).save(FOLDER / f"{name}.webp", quality=70, method=6)


def front() -> None:
    """Write the animation of the README: the three films of the demo, followed and counted."""
    beetle = enumerate(clip_of(synthetic.demo((480, 360)), Tracker(seed=0)))
    street = counted(synthetic.Street())
    player = enumerate(clip_of(synthetic.Pitch(), Tracker(seed=0)))
    shown = []
    for (number, first), second, (_, third) in zip(beetle, street, player, strict=False):
        if number % 3 == 0:
            films = [Image.fromarray(pixels) for pixels in (first, second, third)]
            films = [film.resize((film.width * HIGH // film.height, HIGH)) for film in films]
            shown.append(Image.fromarray(np.hstack([np.asarray(film) for film in films])))
    path = FOLDER.parent / "front.webp"
    shown[0].save(path, save_all=True, append_images=shown[1:], duration=120, loop=0, quality=45)


def clip_of(clip: Clip | PaintedFilm, tracker: Tracker) -> Iterator[Pixels]:
    """Yield the frames of a clip with particles, estimate and status."""
    for frame, (truth, *_) in clip:
        track = tracker.update(frame) if frame.index else tracker.init(frame, truth.ellipse)
        info = tracker.info
        label = f"{track.status} {track.confidence:.2f}"
        yield draw(frame.pixels, track, particles=info.ellipses, weights=info.weights, label=label)


def counted(film: PaintedFilm) -> Iterator[Pixels]:
    """Yield the frames of a film with all objects and what was counted."""
    regions = Regions(line=(Line(points=(150, 130, 150, 235), name="line"),))
    counter, scene, crossed = EventCounter(regions), Scene(BackgroundDetector(), seed=0), 0
    for frame, _ in film:
        objects = scene.update(frame)
        crossed += sum(event.event == "crosses" for event in counter.update(objects))
        yield draw_scene(frame.pixels, objects, {}, regions, (f"{crossed} counted",))


def main() -> None:
    """Render all pictures."""
    front()
    FOLDER.mkdir(parents=True, exist_ok=True)
    clip = synthetic.demo()
    save("recover", followed(clip, Tracker("nummiaro", seed=0), (40, 61, 100)))
    save("grow", followed(clip, Tracker("default", seed=0), (20, 118, 155)))
    turning = synthetic.turning()
    save("turn", followed(turning, Tracker("maggio", seed=0), (10, 40, 70)))
    jumping = synthetic.jumping(size=SIZE, frames=40)
    save("leap", followed(jumping, Tracker("nummiaro", seed=0), (12, 20, 24)))
    hall = Clip(
        SIZE,
        (
            walker(0, 3, 70, (200, 60, 50)),
            walker(0, -3, 82, (60, 90, 190)),
            walker(20, 2.5, 180, (90, 170, 90)),
        ),
    )
    line = Line(points=(160, 240, 160, 0), name="door")
    zone = Zone(points=(215, 4, 316, 4, 316, 236, 215, 236), name="counter")
    save("watch", watched(hall, (40, 58, 90), Regions(line=(line,), zone=(zone,))))


if __name__ == "__main__":
    main()
