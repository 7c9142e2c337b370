"""Take the pictures of the studio's main views, on rendered films: docs/images/studio."""

from __future__ import annotations

import io
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from browsers import Shown, browsing, visitors
from motes.synthetic import crossing
from motes.video.writer import VideoWriter
from studios import Program

OUT = Path(__file__).parents[1] / "images" / "studio"
TARGET = (95.8, 347.6, 35.8, 25.1)
"""The target of the sample film in its first frame: center and half-axes."""


@contextmanager
def page(browser: Browser, address: str, colors: str = "dark") -> Iterator[Shown]:
    """Open the studio as a visitor."""
    shown = Shown(visitors(browser, color_scheme=colors), address)
    yield shown
    shown.close()


def save(shown: Shown, name: str) -> None:
    """Take a picture once all layers have come."""
    shown.page.mouse.move(2, 2)
    shown.page.evaluate("document.activeElement.blur()")
    shown.page.wait_for_timeout(1500)
    path = OUT / f"{name}.webp"
    Image.open(io.BytesIO(shown.page.screenshot())).save(path, quality=90)
    print(path)


def sample(shown: Shown, preset: str = "default", button: str = "Open the sample film") -> None:
    """Open the sample film by a button, draw the target, and track it."""
    shown.page.get_by_role("button", name=button).first.click()
    shown.until("s.pictured === 0")
    x, y, a, b = TARGET
    shown.draw((x - a, y - b), (x + a, y + b), key="e")
    if preset != "default":
        shown.choose_tracker("#left", preset)
        shown.until(f"s.session.objects[0].preset === '{preset}'")
    shown.track()


def one_object(browser: Browser, address: str) -> None:
    """Take the pictures of tracking, of doubtful frames and of a command line."""
    with page(browser, address) as shown:
        sample(shown)
        shown.go(20)
        shown.page.get_by_label("Covariance").check()
        save(shown, "tracked")
        shown.page.get_by_role("tab", name="Doubts").click()
        shown.page.keyboard.press("n")
        shown.until("s.doubtful !== null && s.pictured === s.doubtful")
        save(shown, "doubts")
    with page(browser, address, "light") as shown:
        sample(shown, "nummiaro", "New session of ")
        shown.page.keyboard.press("c")
        save(shown, "command")


def many_objects(browser: Browser, address: str) -> None:
    """Take the picture of the many-object mode."""
    with page(browser, address) as shown:
        shown.open("crossing.mp4")
        film = shown.state("s.film")
        width, height = film["width"], film["height"]
        shown.page.get_by_role("button", name="Draw a line that is counted").click()
        shown.drag((width / 2, height * 0.1), (width / 2, height * 0.5), (width / 2, height * 0.9))
        shown.until("s.session.places.lines.length === 1")
        shown.page.get_by_role("button", name="Track all that moves").click()
        shown.until("[...s.jobs.values()].some(({ status }) => status === 'done')")
        shown.go(round(film["frames"] * 0.35))
        shown.page.keyboard.press("v")
        save(shown, "counted")


def main() -> None:
    """Render films, run a studio, and take all pictures."""
    OUT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, browsing() as browser:
        films = Path(folder, "films")
        films.mkdir()
        with VideoWriter(films / "crossing.mp4", 25) as writer:
            for frame, _ in crossing():
                writer.write(frame.pixels, frame.time)
        program = Program(films, Path(folder, "data"))
        try:
            one_object(browser, program.address)
            many_objects(browser, program.address)
            with page(browser, program.address) as shown:
                shown.page.get_by_label("Sessions", exact=True).get_by_role("link").first.wait_for()
                save(shown, "films")
        finally:
            program.close()


if __name__ == "__main__":
    main()
