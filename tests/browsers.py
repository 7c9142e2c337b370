"""The page of a studio, in a browser without a window."""

import json
import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, BrowserContext, Locator, Page, sync_playwright

from clips import write_film
from motes.synthetic.clips import still
from waiting import PATIENCE

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
FRAMES = 40
CORNERS = (135, 79), (195, 159)
"""Corners of the target in the first frame."""
MIDDLE = 165.0, 119.0
START = "import('/static/main.js').then(({ app }) => "


def film(path: Path, frames: int = FRAMES) -> Path:
    """Write a film with a target that is nearly at rest."""
    write_film(path, still((320, 240), target=(60, 80), frames=frames))
    return path


@contextmanager
def browsing() -> Iterator[Browser]:
    """Give a browser."""
    # One process draws all pages of a context, and none is started in advance.
    options = ["--disable-gpu", "--disable-background-networking", "--process-per-site"]
    options += ["--disable-features=SpareRendererForSitePerProcess"]
    if os.geteuid() == 0:
        options.append("--no-sandbox")  # root has no sandbox
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        try:
            yield browser
        finally:
            browser.close()


def visitors(browser: Browser, **options: Any) -> BrowserContext:
    """Return a context for pages of visitors who have a clipboard."""
    given = {"viewport": {"width": 1280, "height": 720}, **options}
    context = browser.new_context(**given)
    context.grant_permissions(["clipboard-read", "clipboard-write"])
    context.set_default_timeout(1000 * PATIENCE)
    return context


class Shown:
    """The page of a studio, as a person uses it; `wrong` are errors, and requests to others."""

    def __init__(self, context: BrowserContext, address: str) -> None:
        self.context = context
        self.page: Page = context.new_page()
        self.wrong: list[str] = []
        self.page.on("pageerror", lambda error: self.wrong.append(str(error)))
        self.page.on(
            "console",
            lambda message: (
                self.wrong.append(message.text)
                if "Content Security Policy" in message.text
                else None
            ),
        )
        self.page.on("request", lambda request: self._check(request.url, address))
        self.address = address
        self.home()

    def _check(self, url: str, address: str) -> None:
        if not url.startswith((address, "data:", f"blob:{address}")):
            self.wrong.append(url)

    def close(self) -> None:
        """Close the page; fail if something on it was wrong."""
        self.page.close()
        assert not self.wrong, self.wrong

    def state(self, of: str) -> Any:
        """Return a value of the page's state, an expression over `s`."""
        return self.page.evaluate(f"{START} (s => {of})(app.store.state))")

    def until(self, of: str) -> None:
        """Wait until an expression over the page's state `s` is true."""
        self.wait(f"{START} (s => {of})(app.store.state))")

    def wait(self, expression: str) -> None:
        """Wait until an expression is true in the page.

        The page forbids what Playwright's own waiting does there, which is to evaluate texts. To
        ask from outside all the time would keep a core busy, so each question lasts a second.
        """
        asked = (
            "(async () => { for (let n = 0; n < 50; ++n) {"
            f"if (await ({expression})) return true;"
            "await new Promise(done => setTimeout(done, 20)); } return false; })()"
        )
        end = time.monotonic() + PATIENCE
        while not self.page.evaluate(asked):
            if time.monotonic() > end:
                where = self.state("[s.frame, s.pictured, s.connected, document.activeElement.id]")
                page = self.page.inner_text("body")
                raise AssertionError(f"waited {PATIENCE:g} s for {expression}: {where}\n{page}")

    def home(self) -> None:
        """Go to the first page, and wait until its films are listed."""
        self.page.goto(self.address)
        self.listed()

    def listed(self) -> None:
        """Wait until the first page lists its films: what it says of itself comes with them."""
        self.until("s.films")
        self.painted()

    def painted(self) -> None:
        """Wait until the page shows its state: it is drawn before the next paint."""
        self.page.evaluate(
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
        )

    def film(self, name: str = "film.mp4") -> Locator:
        """Return the button that opens a film in a new session; others may be listed with it."""
        entry = self.page.get_by_label("Films", exact=True).locator("li").filter(has_text=name)
        return entry.get_by_role("button").last  # "New session of …", if there is one already

    def open(self, name: str = "film.mp4", tracker: str = "mean_shift") -> str:
        """Open a film in a new session, with a quick tracker; return the session's name."""
        self.film(name).click()
        self.until("s.pictured === 0")
        self.take(tracker)
        return str(self.state("s.session.id"))

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point of the film is on the page."""
        found = self.page.evaluate(
            f"{START} {{ const {{ x, y }} = app.stage.canvas.getBoundingClientRect();"
            f"const at = app.viewNow().toScreen([{x}, {y}]); return [at[0] + x, at[1] + y]; }})"
        )
        return found[0], found[1]

    def take(self, preset: str, config: str | None = None) -> None:
        """Let objects that are drawn from now on have a tracker."""
        given = json.dumps({"preset": preset, "config": config, "seed": 0})
        self.page.evaluate(f"{START} app.store.set({{ tracker: {given} }}))")

    def choose_tracker(self, where: str, name: str) -> None:
        """Choose a tracker that the menu shows after "More" alone."""
        menu = self.page.locator(where).get_by_label("Tracker")
        menu.select_option(label="More …")
        menu.select_option(name)

    def drag(self, *points: tuple[float, float]) -> None:
        """Drag from a point of the film over others to the last one."""
        self.page.mouse.move(*self.at(*points[0]))
        self.page.mouse.down()
        for point in points[1:]:
            self.page.mouse.move(*self.at(*point), steps=3)
        self.page.mouse.up()

    def draw(self, first: tuple[float, float] = CORNERS[0], last: tuple[float, float] = CORNERS[1],
             key: str = "b") -> int:  # fmt: skip
        """Draw a new object, and return its number."""
        count = int(self.state("s.session.objects.length"))
        self.page.keyboard.press(key)
        self.drag(first, last)
        self.until(f"s.session.objects.length === {count + 1} && !s.draft")
        return int(self.state("s.session.objects.at(-1).object"))

    def track(self) -> None:
        """Track all objects, and wait for the result."""
        self.page.keyboard.press("t")
        self.tracked()

    def tracked(self) -> None:
        """Wait until all objects are tracked."""
        self.until("s.session.objects.every(({ tracked }) => tracked)")
        self.settle()

    def settle(self) -> None:
        """Wait until no run is under way, and all rows of what is tracked are results."""
        self.until(
            "s.session.objects.every(({ object, tracked, first, last }) => !tracked || Array.from("
            "{ length: last - first + 1 }, (_, at) => s.rows.get(object)?.[first + at])"
            ".every((row) => row?.final)) && [...s.jobs.values()].every(({ status }) => "
            "!['waiting', 'running'].includes(status))"
        )

    def go(self, frame: int) -> None:
        """Show a frame."""
        self.page.locator("#frame").fill(str(frame))
        self.page.locator("#frame").press("Enter")
        self.page.locator("canvas.over").first.focus()
        self.until(f"s.pictured === {frame}")
