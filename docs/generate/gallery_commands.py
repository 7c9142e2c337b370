"""What each command makes, for docs/gallery.md: its picture, or what it prints as a picture."""

from __future__ import annotations

import html
import platform
import shlex
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

from motes import open_source
from motes.core.types import Bytes

ROOT = Path(__file__).resolve().parents[2]
COLUMNS, LINE, LETTER = 92, 19, 8.4
"""Letters in a line of a terminal's picture; height of a line and width of a letter, in pixels."""

AT = """video => new Promise(done => {
    video.pause(); video.controls = false; video.onseeked = done; video.currentTime = 1.6;
})"""
"""Shows a film of a page at a moment."""


class Command(NamedTuple):
    """A command of the page.

    Attributes
    ----------
    line
        As it is typed, in a folder with films/beetle.mp4 and films/street.mp4 of `motes demo`.
        Later ones read what earlier ones have written.
    shows
        What its picture shows.
    picture
        Makes the picture from the folder; None where the picture is what the command prints.
    """

    line: str
    shows: str
    picture: Callable[[Path], Bytes] | None = None

    @property
    def name(self) -> str:
        """The name of the command."""
        return self.line.split()[1]

    @property
    def file(self) -> str:
        """The name of its picture."""
        return f"{self.name}.{'webp' if self.picture else 'svg'}"


def side_by_side(pictures: Iterable[Bytes], height: int = 216) -> Bytes:
    """Return pictures in a row, all of one height, with a white gap between them."""
    gap, parts = np.full((height, 6, 3), 255, np.uint8), []
    for pixels in pictures:
        image = Image.fromarray(pixels)
        size = image.width * height // image.height, height
        parts += [np.asarray(image.resize(size, Image.Resampling.LANCZOS)), gap]
    return np.hstack(parts[:-1])


def moments(path: Path, indices: Sequence[int]) -> list[Bytes]:
    """Return frames of a film."""
    with open_source(path) as frames:
        return [frame.pixels for frame in frames if frame.index in indices]


def tracked(folder: Path) -> Bytes:
    """Return three frames of the track's overlay."""
    return side_by_side(moments(folder / "track.mp4", (20, 118, 160)))


def sheet(folder: Path) -> Bytes:
    """Return the contact sheet."""
    return np.array(Image.open(folder / "doubts.png").convert("RGB"))


def refined(folder: Path) -> Bytes:
    """Return a frame as it was followed, and after the correction."""
    after = folder / "after.mp4"
    printed(f"motes draw films/beetle.mp4 track.csv -o {after.name}", folder)
    return side_by_side([moments(folder / name, (150,))[0] for name in ("track.mp4", after.name)])


def drawn(folder: Path) -> Bytes:
    """Return the figures of all objects."""
    names = ("heatmap", "paths", "slit")
    pictures = (Image.open(folder / f"figures/objects.{name}.png") for name in names)
    return side_by_side(np.array(picture.convert("RGB")) for picture in pictures)


def watched(folder: Path) -> Bytes:
    """Return two frames of the scene's overlay."""
    return side_by_side(moments(folder / "watched.mp4", (40, 95)))


def page(folder: Path) -> Bytes:
    """Return the demo's page in a browser, its films at one moment."""
    sys.path.insert(0, str(ROOT / "tests"))
    from browsers import browsing

    picture = folder / "page.png"
    with browsing() as browser:
        shown = browser.new_page(viewport={"width": 1100, "height": 620})
        shown.goto((folder / "demo" / "index.html").as_uri())
        shown.evaluate("() => Promise.all([...document.querySelectorAll('video')].map(" + AT + "))")
        shown.screenshot(path=picture, full_page=True)
    return side_by_side([np.array(Image.open(picture).convert("RGB"))], 1100)


COMMANDS = (
    Command("motes demo --out demo", "The page of three films that the demo makes", page),
    Command(
        "motes track films/beetle.mp4 --init 47,241,52,40 -o track.csv --overlay track.mp4",
        "The beetle with its ellipse in three frames",
        tracked,
    ),
    Command(
        "motes check films/beetle.mp4 track.csv --sheet doubts.png",
        "The doubtful frames, numbered by their gain",
        sheet,
    ),
    Command("motes smooth track.csv -o smooth.csv", "What smooth prints"),
    Command(
        "motes refine films/beetle.mp4 track.csv --at 150=339,228,96,84",
        "A frame before and after its correction",
        refined,
    ),
    Command(
        "motes watch films/street.mp4 --line 150,130,150,235 -o objects.csv --overlay watched.mp4",
        "Cars with numbers, and a line that they cross",
        watched,
    ),
    Command(
        "motes draw films/street.mp4 objects.csv --figures figures",
        "A heatmap, the paths of all cars, and the line through time",
        drawn,
    ),
    Command("motes convert track.csv track.xml --video films/beetle.mp4", "What convert prints"),
    Command("motes batch 'films/*.mp4' --do watch -o results", "What batch prints"),
    Command("motes config nummiaro motion.noise", "The keys inside motion.noise"),
    Command("motes network get --help", "How a trained network is got"),
    Command("motes doctor", "The parts that doctor finds"),
)
"""The studio's picture is one of docs/generate/studio_pictures.py."""


def printed(line: str, folder: Path, code: int = 0) -> str:
    """Run a command in a folder, and return what it prints.

    Raises
    ------
    RuntimeError
        If it ends with another exit code.
    """
    words = [sys.executable, "-m", *shlex.split(line)]
    run = subprocess.run(
        words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    if run.returncode != code:
        raise RuntimeError(f"{line} ended with exit code {run.returncode}: {run.stdout}")
    # The picture is of any machine; how often a batch says how far it is depends on the machine.
    text = "".join(row for row in run.stdout.splitlines(keepends=True) if " jobs/s" not in row)
    return text.replace(str(ROOT), "...").replace(platform.platform(), platform.system())


def terminal(line: str, text: str) -> str:
    """Return a picture (SVG) of a terminal with a command and what it prints."""
    lines = [f"$ {line}"]
    for row in text.splitlines():
        lines += textwrap.wrap(row, COLUMNS, subsequent_indent="  ", replace_whitespace=False)
    width, height = round(COLUMNS * LETTER) + 24, LINE * len(lines) + 20
    rows = "\n".join(
        f'<text x="12" y="{LINE * (number + 1) + 6}" textLength="{LETTER * len(row):.0f}"'
        f' xml:space="preserve">{html.escape(row)}</text>'
        for number, row in enumerate(lines)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}">\n'
        f'<rect width="{width}" height="{height}" rx="8" fill="#1d2430"/>\n'
        f'<g font-family="monospace" font-size="14" fill="#e4e8ee">\n{rows}\n</g></svg>\n'
    )
