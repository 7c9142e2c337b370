"""A server that ends, and another one that goes on."""

import subprocess
import sys
from pathlib import Path

import pytest

from motes.cli import main
from motes_studio import messages
from studios import Page, Program, begin, film, looking, running
from waiting import PATIENCE

pytestmark = pytest.mark.slow

INTERRUPTED = """
import asyncio
import signal
import sys

from motes.cli import main

begin = asyncio.BaseEventLoop.__init__


def interrupted(loop):
    signal.raise_signal(signal.SIGINT)
    begin(loop)


asyncio.BaseEventLoop.__init__ = interrupted
sys.exit(main(["studio", "--headless", "--port", "0", "--data", sys.argv[1]]))
"""


def test_ctrl_c_at_once_ends_it_in_one_line(tmp_path: Path) -> None:
    """It comes while the loop is made, in which an interrupt would leave half a loop."""
    line = [sys.executable, "-c", INTERRUPTED, str(tmp_path)]
    done = subprocess.run(line, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 130
    assert done.stderr.count("\n") == 1, done.stderr


def test_two_do_not_use_the_same_data(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """The second one is refused, and names the first one, until that is killed."""
    # An empty host is refused only once the data are its own, so that it does not begin to serve.
    line = ["studio", "--headless", "--data", str(tmp_path), "--host", ""]
    with Program(tmp_path, tmp_path) as program:
        assert main(line) == 5
        assert capfd.readouterr().err == (
            f"motes: error: Another motes studio uses {tmp_path}; use that one, at "
            f"{program.address}, or give another --data.\n"
        )
        program.kill()
    assert main(line) == 2
    assert "The host is empty" in capfd.readouterr().err


def test_a_run_of_many_objects_begins_again(tmp_path: Path) -> None:
    """Frames that were found before are not there twice."""
    frames = 80

    def found(page: Page) -> list[int]:
        return [each.frame for rows in page.of(messages.FoundScene) for each in rows.frames]

    folder, going_on = tmp_path / "films", {"waiting", "running"}
    folder.mkdir()
    film(folder / "film.mkv", frames)
    with Program(folder, tmp_path / "data") as program, program.client() as client:
        session = begin(client)
        with looking(client, session) as page:
            page.do("watch", seed=2)
            page.until(lambda: found(page))
            program.kill()
    for runs in (1, 0):
        with running(folder, tmp_path / "data") as client, looking(client, session) as page:
            assert len(page.jobs) == runs
            page.until(lambda: not {each.status for each in page.jobs.values()} & going_on)
            assert all(each.status == "done" for each in page.jobs.values()), page.jobs
            page.until(lambda: len(found(page)) >= frames)
            assert found(page) == [*range(frames)]
