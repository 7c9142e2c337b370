"""The commands and code of the README and of pages that go on from it, run as they stand there."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from clips import write_film
from motes import Status, synthetic
from motes.cli.app import commands as known_commands
from motes_lab.cli.app import app as lab_app
from pages import blocks, commands, run as run_command

ROOT = Path(__file__).parent.parent
README, MORE = ROOT / "README.md", ROOT / "docs/track.md"
PAGES = [
    README,
    *(ROOT / "docs" / f"{name}.md" for name in ("track", "watch", "detectors", "formats")),
]
BOX, FRAMES = "300,200,40,60", 12


@pytest.fixture(scope="module")
def video(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a clip whose target is where the README says."""
    path = tmp_path_factory.mktemp("readme") / "video.mp4"
    x, y, width, height = (int(value) for value in BOX.split(","))
    states = np.array(
        [[x + width / 2 + i, y + height / 2, width / 2, height / 2, 0] for i in range(FRAMES)]
    )
    clip = synthetic.Clip((640, 480), (synthetic.Target(states),))
    write_film(path, clip)
    return path


TASK = """<?xml version="1.0" encoding="utf-8"?>
<annotations><version>1.1</version><track id="0" label="cup">
<box frame="0" outside="0" occluded="0" keyframe="1" xtl="30" ytl="20" xbr="70" ybr="80"/>
<box frame="5" outside="0" occluded="0" keyframe="1" xtl="40" ytl="20" xbr="80" ybr="80"/>
</track></annotations>
"""
"""A box that somebody has drawn in two frames with CVAT."""


@pytest.fixture(scope="module")
def street(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a clip in which something walks by."""
    path = tmp_path_factory.mktemp("readme") / "street.mp4"
    states = np.array([[8 * i - 30, 120, 24, 17, 0] for i in range(45)], np.float64)
    write_film(path, synthetic.Clip((320, 240), (synthetic.Target(states),)))
    return path


@pytest.fixture
def folder(video: Path, street: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "video.mp4").symlink_to(video)
    (tmp_path / "street.mp4").symlink_to(street)
    (tmp_path / "task.xml").write_text(TASK, encoding="utf-8")
    (tmp_path / "labels").mkdir()
    (tmp_path / "labels" / "street_1.txt").write_text("0 0.5 0.5 0.1 0.2 0.9\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_command_runs(page: Path, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("cv2")
    pytest.importorskip("matplotlib")
    run = 0
    for block in blocks(page):
        if block.title:
            (folder / block.title).write_text(block.text, encoding="utf-8")
        for command in commands(block) if block.language == "sh" else ():
            run += 1
            assert run_command(command) == 0, (command, capfd.readouterr().err)
            output = re.search(r"^motes track .*-o (\S+\.csv)", command)
            if output and "--resume" not in command:
                rows = (folder / output[1]).read_text().splitlines()
                assert len(rows) == 1 + FRAMES * max(1, command.count("--init")), command
                last = dict(zip(rows[0].split(","), rows[-1].split(","), strict=True))
                assert last["status"] == "tracking", command
    assert run >= (1 if page.stem in ("README", "detectors") else 3)


@pytest.mark.slow
def test_python_code_runs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = (b.text for b in blocks(README) if b.language == "python")
    several, opencv, known = (b.text for b in blocks(MORE) if b.language == "python")
    assert len([line for line in code.splitlines() if line.strip()]) <= 10
    exec(code, {})
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == FRAMES
    assert all("tracking" in line for line in printed)
    exec(several, {})
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == FRAMES - 1
    assert all("tracking" in line for line in printed)

    for block in blocks(MORE):
        if block.title:
            (folder / block.title).write_text(block.text)
    exec(known, {})

    clip = synthetic.still((640, 480), target=(60, 100), frames=2)
    images = [clip[i][0].pixels[:, :, ::-1] for i in range(2)]
    names: dict[str, Any] = {"first_bgr_image": images[0], "next_bgr_image": images[1]}
    exec(opencv, names)
    assert names["ok"] is (names["tracker"].tracker.info.track.status is Status.TRACKING)


@pytest.mark.slow
def test_python_code_of_watch_runs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (code,) = (block.text for block in blocks(ROOT / "docs/watch.md") if block.language == "python")
    exec(code, {})
    assert "TRACKING" in capsys.readouterr().out.splitlines()[30]


def test_commands_in_the_table_of_the_readme_exist() -> None:
    named = re.findall(r"`(motes(?:-lab)?) ([a-z]+)`", README.read_text(encoding="utf-8"))
    assert len(named) > 8
    for program, name in named:
        assert name in (lab_app if program == "motes-lab" else known_commands([])), name


NUMBER = r"\d+(?:\.\d+)?"


def test_measured_numbers_are_those_of_the_tables_that_they_link_to() -> None:
    """Rounded to the digits that the README has."""
    parts = re.split(r"\n(?=- |\n)", README.read_text(encoding="utf-8"))
    linked = [
        (part, found) for part in parts if (found := re.search(r"\((lab\S+)#([\w-]+)\)", part))
    ]
    assert linked
    for part, found in linked:
        page = (ROOT / found[1]).read_text(encoding="utf-8")
        sections = re.split(r"^## (.*)$", page, flags=re.MULTILINE)
        titles = [
            re.sub(r"[^\w ]", "", title).lower().replace(" ", "-") for title in sections[1::2]
        ]
        section = sections[2 * titles.index(found[2]) + 2]
        measured = [float(number) for number in re.findall(NUMBER, section)]
        for number in re.findall(NUMBER, part.replace(found[0], "")):
            digits = len(number.partition(".")[2])
            assert number in {f"{each:.{digits}f}" for each in measured}, f"{number} in: {part}"
