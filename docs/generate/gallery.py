"""Make the pictures and texts of docs/gallery.md, and two of other pages: `make gallery`."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image, ImageDraw

from gallery_commands import COMMANDS, printed, side_by_side, terminal
from gallery_experts import picture
from gallery_films import KINDS, Kind
from motes import Frame, Scene, Status, Track, Tracker, synthetic
from motes.core.geometry import iou
from motes.core.types import Bytes
from motes.mot.analytics.event_counter import EventCounter
from motes.mot.analytics.regions import Line, Regions
from motes.mot.detection.background import BackgroundDetector
from motes.output.overlay import draw, font
from motes.output.scene_overlay import draw_scene
from motes.sot.algorithm import StepInfo
from motes.synthetic import Clip, Truth
from motes.synthetic.painted_film import PaintedFilm

PAGE = Path(__file__).parents[1] / "gallery.md"
FOLDER = PAGE.parent / "images" / "gallery"
EXPERTS = FOLDER.parent / "experts.webp"
"""The picture of docs/default-tracker.md."""
FILMS = "beetle.mp4", "street.mp4"
"""Films of the demo that the commands read."""
PART = 240, 180
"""Width and height of the part of a film that is shown."""
HIGH = 200
"""Height of the README's animation."""


class Score(NamedTuple):
    """The quality of a run."""

    half: float
    """Share of the frames with an IoU above 0.5, of those in which half of the target is
    visible."""
    missed: int
    admitted: int
    """Number of frames with an IoU below 0.1, and of those in which the tracker was not sure."""


def followed(kind: Kind) -> tuple[Score, list[Bytes]]:
    """Follow the target of a film; return the score, and its surroundings at three moments."""
    tracker, shown = Tracker(seed=0), []
    overlaps, visible, sure = [], [], []
    for frame, truth in kind.film():
        track = tracker.update(frame) if frame.index else tracker.init(frame, truth.ellipse)
        overlaps.append(iou(track.box, truth.ellipse.box))
        visible.append(truth.visible)
        sure.append(track.status is Status.TRACKING)
        if frame.index in kind.moments:
            shown.append(surroundings(frame, truth, track, tracker.info))
    overlap, seen = np.array(overlaps), np.array(visible) >= 0.5
    missed = overlap < 0.1
    score = Score(
        half=float((overlap[seen] > 0.5).mean()),
        missed=int(missed.sum()),
        admitted=int((missed & ~np.array(sure)).sum()),
    )
    return score, shown


def surroundings(frame: Frame, truth: Truth, track: Track, info: StepInfo) -> Bytes:
    """Return the part of a frame around the target, with particles, estimate and status."""
    drawn = draw(frame.pixels, track, label="", particles=info.ellipses, weights=info.weights)
    width, height = PART if frame.width >= PART[0] else (frame.width, frame.height)
    left = int(np.clip(truth.ellipse.x - width / 2, 0, frame.width - width))
    top = int(np.clip(truth.ellipse.y - height / 2, 0, frame.height - height))
    part = Image.fromarray(drawn[top : top + height, left : left + width])
    part = part.resize((part.width * PART[1] // part.height, PART[1]))
    label = f"{frame.index}: {track.status} {track.confidence:.2f}"
    pen = ImageDraw.Draw(part)
    pen.text((8, 6), label, "white", font(14), stroke_width=2, stroke_fill="black")
    return np.array(part)


def film_text(kind: Kind, score: Score) -> str:
    """Return what the page says of a film."""
    admitted = f", admitted: {score.admitted}" if score.missed else ""
    return (
        f"### {kind.title}\n\n![{kind.title}](images/gallery/{kind.name}.webp)\n\n"
        f"{kind.words[0].upper()}{kind.words[1:]}. IoU above 0.5: {score.half:.0%}; off:"
        f" {score.missed}{admitted}.\n"
    )


def command_text() -> str:
    """Return what the page says of the commands."""
    shown = [(each.line, each.shows, f"gallery/{each.file}") for each in COMMANDS]
    studio = "motes studio films", "A film in the studio, with its target", "studio/tracked.webp"
    return "\n".join(
        f"### motes {line.split()[1]}\n\n`{line}`\n\n![{shows}](images/{file})\n"
        for line, shows, file in (*shown, studio)
    )


def write(block: str, text: str) -> None:
    """Replace the text between two marks of the page."""
    page = PAGE.read_text(encoding="utf-8")
    head, begin, rest = page.partition(f"<!-- {block} -->\n")
    _, end, tail = rest.partition(f"<!-- end {block} -->\n")
    PAGE.write_text(f"{head}{begin}\n{text}\n{end}{tail}", encoding="utf-8")


def save(name: str, pixels: Bytes) -> None:
    """Write a picture of the page."""
    Image.fromarray(pixels).save(FOLDER / name, quality=70, method=6)


def front() -> None:
    """Write the animation of the README: the three films of the demo, followed and counted."""
    beetle = enumerate(clip_of(synthetic.demo((480, 360)), Tracker(seed=0)))
    street = counted(synthetic.Street())
    player = enumerate(clip_of(synthetic.Pitch(), Tracker(seed=0)))
    shown = []
    for (number, first), second, (_, third) in zip(beetle, street, player, strict=False):
        if number % 4 == 0:
            films = [Image.fromarray(pixels) for pixels in (first, second, third)]
            films = [film.resize((film.width * HIGH // film.height, HIGH)) for film in films]
            shown.append(Image.fromarray(np.hstack([np.asarray(film) for film in films])))
    path = FOLDER.parent / "front.webp"
    shown[0].save(path, save_all=True, append_images=shown[1:], duration=160, loop=0, quality=45)


def clip_of(clip: Clip | PaintedFilm, tracker: Tracker) -> Iterator[Bytes]:
    """Yield the frames of a clip with particles, estimate and status."""
    for frame, (truth, *_) in clip:
        track = tracker.update(frame) if frame.index else tracker.init(frame, truth.ellipse)
        info = tracker.info
        label = f"{track.status} {track.confidence:.2f}"
        yield draw(frame.pixels, track, particles=info.ellipses, weights=info.weights, label=label)


def counted(film: PaintedFilm) -> Iterator[Bytes]:
    """Yield the frames of a film with all objects and what was counted."""
    regions = Regions(line=(Line(points=(150, 130, 150, 235), name="line"),))
    counter, scene, crossed = EventCounter(regions), Scene(BackgroundDetector(), seed=0), 0
    for frame, _ in film:
        objects = scene.update(frame)
        crossed += sum(event.event == "crosses" for event in counter.update(objects))
        yield draw_scene(frame.pixels, objects, {}, regions, (f"{crossed} counted",))


def films() -> None:
    """Follow all kinds of film, and write their pictures and texts."""
    texts = []
    for kind in KINDS:
        score, shown = followed(kind)
        save(f"{kind.name}.webp", side_by_side(shown, PART[1]))
        texts.append(film_text(kind, score))
    write("films", "\n".join(texts))


def commands(folder: Path) -> None:
    """Run all commands in a folder, and write their pictures and texts."""
    printed(COMMANDS[0].line, folder)
    (folder / "films").mkdir()
    for film in FILMS:
        shutil.copy(folder / "demo" / film, folder / "films")
    for command in COMMANDS:
        text = "" if command is COMMANDS[0] else printed(command.line, folder)
        if command.picture is None:
            (FOLDER / command.file).write_text(terminal(command.line, text), encoding="utf-8")
        else:
            save(command.file, command.picture(folder))
    write("commands", command_text())


def main() -> None:
    """Make all pictures, and the page's texts."""
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as folder:
        commands(Path(folder))
    films()
    Image.fromarray(picture()).save(EXPERTS, quality=70, method=6)
    front()


if __name__ == "__main__":
    main()
