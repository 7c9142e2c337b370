"""What the commands make, what they leave when cut short, and that they say so truly."""

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from clips import picture, write_pictures
from commands import Tell
from disks import fill
from motes import FormatError, VideoWriter, open_source
from motes.cli import outputs
from motes.core.files import PartialFile, leftovers

FRAMES = 7
COMMANDS = [
    "track film.mkv --init 20,10,20,20",
    "track film.mkv --init 20,10,20,20 --init 30,20,20,20",
    "watch film.mkv",
]


@pytest.fixture
def go(here: Path, capfd: pytest.CaptureFixture[str]) -> Tell:
    """Run motes in a folder with a film."""
    write_pictures("film.mkv", map(picture, range(FRAMES)))
    return Tell(capfd)


def pictures(path: Path | str) -> int:
    with open_source(path) as source:
        return len(list(source))


def rows_fail(patch: pytest.MonkeyPatch) -> None:
    """Let the rows of the fourth frame fail."""
    write = outputs.RowsOutput.write

    def fourth_fails(self: Any, step: Any) -> None:
        if step.frame.index == 3:
            raise FormatError("r.csv cannot be written: for a test.")
        write(self, step)

    patch.setattr(outputs.RowsOutput, "write", fourth_fails)


def interrupted(patch: pytest.MonkeyPatch) -> None:
    """Let Ctrl-C come while the overlay is finished."""
    settle = PartialFile.settle

    def interrupted(file: PartialFile) -> None:
        if file.path.name.startswith("o.mp4"):
            raise KeyboardInterrupt
        settle(file)

    patch.setattr(PartialFile, "settle", interrupted)


def without_room(patch: pytest.MonkeyPatch) -> None:
    """Let the disk be full in the end: the pictures had room, the film's index has not."""
    finish = VideoWriter._finish

    def filled(writer: VideoWriter, *, named: bool) -> None:
        fill(patch, "o.mp4")
        finish(writer, named=named)

    patch.setattr(VideoWriter, "_finish", filled)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize(
    ("fault", "expected", "kept"),
    [(rows_fail, 5, 4), (interrupted, 130, FRAMES), (without_room, 5, FRAMES - 1)],
)
def test_what_is_unfinished_stays_and_is_named(
    go: Tell,
    monkeypatch: pytest.MonkeyPatch,
    fault: Callable[[pytest.MonkeyPatch], None],
    expected: int,
    kept: int,
    command: str,
) -> None:
    fault(monkeypatch)
    code, error = go(f"{command} -o r.csv --overlay o.mp4")
    (left,) = leftovers("o.mp4")
    assert code == expected
    assert f"wrote {left} (unfinished), r.csv" in error
    assert ("o.mp4 cannot be written: No space left on device" in error) == (fault is without_room)
    assert pictures(left) == kept
    assert not Path("o.mp4").exists()


@pytest.mark.parametrize("command", COMMANDS)
def test_nothing_is_said_of_what_is_not_there(
    go: Tell, command: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(monkeypatch, "o.mp4")
    go.says(f"{command} -o r.csv --overlay o.mp4", 5, "wrote", told=False)
    assert os.listdir() == ["film.mkv"]


@pytest.mark.parametrize("command", COMMANDS)
def test_later_runs_name_what_is_unfinished_and_leave_it(go: Tell, command: str) -> None:
    left = PartialFile("o.mp4", ".mp4")
    left.close()
    code, error = go(f"{command} -o r.csv --overlay o.mp4")
    assert f"motes: {left.path} is an unfinished o.mp4, of a run that was killed" in error
    assert code in (0, 4)
    assert pictures("o.mp4") == FRAMES
    assert left.path.exists()


@pytest.mark.parametrize("command", COMMANDS)
def test_a_link_to_the_source_is_no_output(go: Tell, command: str) -> None:
    before = Path("film.mkv").read_bytes()
    Path("hard.mkv").hardlink_to("film.mkv")
    Path("rows.csv").hardlink_to("film.mkv")
    Path("soft.mkv").symlink_to("film.mkv")
    for option in ("--overlay hard.mkv", "--overlay soft.mkv", "-o rows.csv"):
        go.says(f"{command} {option} --overwrite", 2, "film.mkv is the source and cannot be an")
    assert Path("film.mkv").read_bytes() == before


@pytest.mark.parametrize("command", COMMANDS)
def test_a_source_under_a_former_name_of_partial_files(go: Tell, command: str) -> None:
    """The run once wrote over its own source, and then removed it."""
    name = "o.mp4.partial.mp4"
    Path(name).write_bytes(Path("film.mkv").read_bytes())
    code, error = go(f"{command} --overlay o.mp4".replace("film.mkv", name))
    assert code in (0, 4)
    assert re.search(r"wrote o\.mp4\W", error)
    assert pictures("o.mp4") == FRAMES
    assert Path(name).read_bytes() == Path("film.mkv").read_bytes()
