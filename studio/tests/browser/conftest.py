"""One browser and one studio for all tests of the page; both end with these tests.

Playwright keeps a loop and a greenlet in the thread of the tests, in which others cannot run.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext

from browsers import CHROMIUM, Shown, browsing, film, visitors
from studios import Program


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:
        pytest.skip("there is no chromium; install it to test the studio's page")
    with browsing() as found:
        yield found


@pytest.fixture(scope="package")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("films")
    film(folder / "film.mp4")
    return folder


@pytest.fixture(scope="package")
def context(browser: Browser) -> BrowserContext:
    return visitors(browser)


@pytest.fixture(scope="package")
def studio(
    context: BrowserContext, films: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Program]:
    program = Program(films, tmp_path_factory.mktemp("data"))
    # While one page stays, so does the process that draws them all: to start it takes long.
    context.new_page().goto(f"{program.address}static/logo.svg")
    yield program
    program.close()


@pytest.fixture
def visit(context: BrowserContext, studio: Program) -> Iterator[Callable[[], Shown]]:
    """Return a function that opens the studio's page as one more visitor."""
    opened: list[Shown] = []

    def visitor() -> Shown:
        opened.append(Shown(context, studio.address))
        return opened[-1]

    yield visitor
    for shown in opened:
        shown.close()


@pytest.fixture
def shown(visit: Callable[[], Shown]) -> Shown:
    return visit()
