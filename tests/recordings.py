"""Recordings for tests of formats."""

import math

from motes import Ellipse, Status, Track
from motes.formats.recording import UNTIMED, FilmFacts, Recording

FACTS = FilmFacts(source="film.mp4", width=320, height=240, fps=25.0, frames=40)


def placed(
    frame: int,
    place: Ellipse,
    identity: int = 1,
    confidence: float = 1.0,
    status: Status = Status.TRACKING,
    label: str | None = None,
) -> Track:
    """Return an object that `Recording.of` takes."""
    return Track(
        frame, UNTIMED, place, confidence=confidence, status=status, identity=identity, label=label
    )


def turning(frames: int = 40) -> Recording:
    """Return one target that turns and grows on its way; it is absent in the frames 20 to 24."""
    objects = [
        placed(frame, ellipse(frame), 1, round(0.5 + frame / 100, 2))
        for frame in range(frames)
        if not 20 <= frame < 25
    ]
    return Recording.of(FACTS, objects, {frame: frame / 25 for frame in range(frames)})


def ellipse(frame: int) -> Ellipse:
    """Return the place of the target of `turning`."""
    x, y = 60 + 4.5 * frame, 120 + 40 * math.sin(frame / 8)
    return Ellipse(x, y, 20 + frame / 4, 12.0, 0.016 * frame + 0.1)


def crowd(label: str | None = "car") -> Recording:
    """Return two objects; the first has a class, the second is hidden in frames 10 to 14."""
    objects = []
    for frame in range(30):
        car = Ellipse.from_box((10 + 5 * frame, 40, 40, 24))
        walker = Ellipse.from_box((200 - 2 * frame, 100 + frame, 16, 48))
        hidden = 10 <= frame < 15
        status = Status.OCCLUDED if hidden else Status.TRACKING
        objects.append(placed(frame, car, 1, 0.9, label=label))
        objects.append(placed(frame, walker, 2, 0.0 if hidden else 0.8, status))
    return Recording.of(FACTS, objects, {frame: frame / 25 for frame in range(30)})
