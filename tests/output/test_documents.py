"""Documents of a run: made at its end, and of its rows where it was killed or the disk was full."""

import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from clips import write_film
from commands import Go, running
from motes import Ellipse, FormatError, SourceError, Status, Track, open_source, read_track
from motes.cli import main
from motes.cli.option_groups import OutputOptions
from motes.cli.outputs import DocumentOutput
from motes.formats.coco import write as coco
from motes.formats.rows import recording_of_journal
from motes.rows.schema import FrameRow, Header
from motes.rows.writer import JournalWriter
from motes.synthetic.clips import crowd

FRAMES = 12
BOX = "--init 60,40,20,30 --preset mean_shift"


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of images: 0.png to 11.png."""
    folder = tmp_path_factory.mktemp("film")
    for frame, _ in crowd((200, 160), (20, 30), FRAMES):
        Image.fromarray(frame.pixels).save(folder / f"{frame.index}.png")
    return folder


@pytest.fixture
def go(film: Path, here: Path, capfd: pytest.CaptureFixture[str]) -> Go:
    """Run motes in an empty folder; FILM in the arguments is the folder of images."""
    return running(capfd, FILM=film)


def here() -> set[str]:
    return {path.name for path in Path().iterdir()}


def test_a_run_leaves_out_frames_in_which_the_target_is_searched_for(
    film: Path, tmp_path: Path
) -> None:
    """Also where it has no place, which a journal does not keep; an absence is kept."""
    states = [Status.SEARCHING, Status.ABSENT]
    objects = [Track(0, 0.0, Ellipse(50, 40, 8, 6, 0))]
    objects += [Track.nowhere(0, 0.0, state) for state in states]
    with open_source(film) as source:
        output = DocumentOutput(
            str(tmp_path / "a.yolo"), "yolo", source, OutputOptions(label="object")
        )
        for frame, each in enumerate(objects):
            output.add(FrameRow(frame, frame / 25, (each,)))
        output.__exit__(None, None, None)
    assert output.result is not None
    assert output.result.endswith(
        "a.yolo without 1 frame in which a target is lost or searched for"
    )
    assert {path.stem for path in (tmp_path / "a.yolo/labels").glob("*.txt")} == {"0", "2"}


def test_how_long_a_film_goes_on_may_not_be_known(tmp_path: Path) -> None:
    """As of a camera, or of a film that is gone when its run ends: its track stays open."""
    path = tmp_path / "film.mkv"
    write_film(path, crowd((200, 160), (20, 30), 3))
    for gone in (False, True):
        with open_source(path, end=1) as source:
            document = tmp_path / f"{gone}.xml"
            output = DocumentOutput(str(document), "cvat", source, OutputOptions(label="object"))
            output.add(FrameRow(0, 0.0, (Track(0, 0.0, Ellipse(50, 40, 8, 6, 0), identity=1),)))
            if gone:
                path.unlink()
            output.__exit__(None, None, None)
        assert document.read_text().count('outside="1"') == (not gone)


@pytest.mark.parametrize("label", ["", " ", "a\nb", "a\x01b", "\ud800"])
def test_a_label_that_no_tool_takes(
    tmp_path: Path, film: Path, label: str, capfd: pytest.CaptureFixture[str]
) -> None:
    for command in (["track", str(film), "--init", "60,40,20,30"], ["watch", str(film)]):
        assert main([*command, "-o", str(tmp_path / "a.json"), "--label", label]) == 2
        assert capfd.readouterr()[1].splitlines()[-1].startswith("motes: error: --label: ")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("command", [f"track FILM {BOX}", f"track FILM {BOX} --init 5,5,20,20",
                                     "track FILM --at 2=60,40,20,30", "watch FILM"])  # fmt: skip
def test_rows_keep_a_label(go: Go, command: str) -> None:
    for name, label in (("a", "--label sea-bird"), ("plain", "")):
        assert go(f"{command} {label} -o {name}.csv --overlay {name}.mp4")[0] == 0
    assert {*read_track("a.csv")["label"]} == {"sea-bird"}
    assert Path("a.mp4").read_bytes() != Path("plain.mp4").read_bytes()
    assert go(f"{command} --label car -o a.txt")[0] == 0
    assert {line.split(",")[7] for line in Path("a.txt").read_text().split()} == {"3"}
    for name, reason in (("b.txt", "mot has no class sheep"), ("b.otb.txt", "otb holds no")):
        code, _, error = go(f"{command} --label sheep -o {name}")
        assert code == 2
        assert reason in error
    if command == f"track FILM {BOX}":
        assert go(f"{command} --label sea-bird --overlay alone.mp4")[0] == 0
        assert Path("alone.mp4").read_bytes() == Path("a.mp4").read_bytes()
        assert go("smooth a.csv -o b.csv")[0] == 0
        assert {*read_track("b.csv")["label"]} == {"sea-bird"}
    if "--at" in command:
        assert go("refine FILM a.csv --at 4=62,41,20,30")[0] == 0
        assert {*read_track("a.csv")["label"]} == {"sea-bird"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        "track FILM --init 5,5,20,20 --init 60,20,180,130 --preset mean_shift -o a.csv",
        "track FILM --at 2=60,20,180,130 --preset mean_shift -o a.csv",
        "refine FILM b.csv --at 2=60,20,180,130",
        "watch FILM --like 60,20,180,130 -o a.csv",
    ],
)
def test_corners_that_were_given_as_a_box_get_a_line(go: Go, line: str) -> None:
    assert go(f"track FILM {BOX} -o b.csv")[0] == 0
    code, _, error = go(line)
    assert code in (0, 4)  # 4 is of `watch`, which finds nothing like it
    told = [each for each in error.splitlines() if "corners x1,y1,x2,y2" in each]
    assert len(told) == 1
    assert "give 60,20,120,110 (x,y,width,height)" in told[0]
    assert "corners" not in go(f"track FILM {BOX} -o c.csv")[2]


PROGRAM = """
import os, signal, sys
from motes.cli import main
from motes.cli.outputs import DocumentOutput
from motes.cli import outputs

add = outputs.DocumentOutput.add

def last(self, picture):
    add(self, picture)
    if picture.frame == 7:
        os.kill(os.getpid(), getattr(signal, sys.argv[1]))

outputs.DocumentOutput.add = last
sys.exit(main(sys.argv[2:]))
"""
"""motes that gets a signal in frame 7."""


def signaled(name: str, film: Path, line: str) -> subprocess.CompletedProcess[str]:
    words = [str(film) if word == "FILM" else word for word in line.split()]
    command = [sys.executable, "-c", PROGRAM, name, *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.slow
def test_a_killed_run_loses_no_frame(go: Go, film: Path) -> None:
    ended = signaled("SIGKILL", film, f"track FILM {BOX} -o a.json")
    assert ended.returncode == -signal.SIGKILL, ended.stderr
    assert here() == {"a.json.rows.jsonl"}
    code, _, error = go(f"track FILM {BOX} -o a.json --overwrite")  # which would lose them
    assert (code, "motes convert a.json.rows.jsonl -o a.json, " in error) == (5, True)
    Path("a.xml.rows.jsonl").touch()
    remedy = f"motes convert a.xml.rows.jsonl -o a.xml --video {film} --fps 25, then"
    assert remedy in go(f"track FILM {BOX} -o a.xml")[2]
    Path("a.xml.rows.jsonl").unlink()
    for name in ("a.json", "a.xml", "a.txt", "a.csv", "a.jsonl", "a.vot.txt"):
        until = " --video FILM" * (name == "a.xml")
        code, _, error = go(f"convert a.json.rows.jsonl -o {name}{until}")
        assert (code, "with the 8 frames in a.json.rows.jsonl." in error) == (0, True)
        assert go(f"track FILM {BOX} --end 8 -o whole-{name}")[0] == 0
        assert Path(name).read_bytes() == Path(f"whole-{name}").read_bytes()


@pytest.mark.slow
def test_ctrl_c_gives_a_whole_document(tmp_path: Path, film: Path) -> None:
    ended = signaled("SIGINT", film, f"track FILM {BOX} -o {tmp_path}/a.json")
    assert ended.returncode == 130, ended.stderr
    assert "interrupted after 8 frames" in ended.stderr
    assert f"wrote {tmp_path}/a.json." in ended.stderr
    document = json.loads((tmp_path / "a.json").read_text())
    assert len(document["images"]) == len(document["annotations"]) == 8
    assert [path.name for path in tmp_path.iterdir()] == ["a.json"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "images"),
    [(f"track FILM {BOX}", FRAMES), ("watch FILM", 8)],  # then an object is lost, in plain sight
)
def test_a_disk_that_is_full_at_the_end_keeps_the_rows(go: Go, command: str, images: int) -> None:
    Path("a.json").symlink_to("/dev/full")
    code, _, error = go(f"{command} -o a.json")
    assert code == 5
    line = error.splitlines()[-1]
    assert "; wrote a.json.rows.jsonl, but not a.json." in error
    assert "No space left" in line
    assert line.endswith("Make room, then: motes convert a.json.rows.jsonl -o a.json")
    assert go("convert a.json.rows.jsonl -o a.json")[0] == 5
    assert go("convert a.json.rows.jsonl -o b.json")[0] == 0
    assert len(json.loads(Path("b.json").read_text())["images"]) == images


class Full:
    """A file on a disk that has room for so many more bytes."""

    def __init__(self, file: Any, room: int) -> None:
        self.file, self.room = file, room

    def write(self, data: bytes) -> int:
        """Write what there is room for."""
        if not self.room:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        written: int = self.file.write(data[: self.room])
        self.room -= written
        return written

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)


def test_a_disk_that_gets_full_keeps_whole_rows(go: Go, monkeypatch: pytest.MonkeyPatch) -> None:
    add = JournalWriter.add

    def fill(self: JournalWriter, picture: FrameRow) -> None:
        if picture.frame == 5:
            self._file = Full(self._file, 20)  # type: ignore[assignment]
        add(self, picture)

    monkeypatch.setattr(JournalWriter, "add", fill)
    code, _, error = go(f"track FILM {BOX} -o a.json")
    assert code == 5
    assert "its rows are kept in a.json.rows.jsonl. Make room, then: motes convert" in error
    assert "wrote a.json.rows.jsonl, but not a.json." in error
    assert here() == {"a.json.rows.jsonl"}
    assert Path("a.json.rows.jsonl").read_bytes().endswith(b"}\n")
    kept = recording_of_journal(Path("a.json.rows.jsonl"))
    assert [each.frame for each in kept] == [0, 1, 2, 3, 4]


def test_what_is_there_already_stays(go: Go) -> None:
    Path("mine").write_text("mine")
    for name in ("a", "b"):
        Path(f"{name}.json.rows.jsonl").symlink_to("mine" if name == "a" else "nowhere")
        assert go(f"track FILM {BOX} -o {name}.json")[0] == 5
    with pytest.raises(FormatError, match="another run writes it"):
        JournalWriter(Path("a.json.rows.jsonl"), Header("film", 1, 1, "object"))
    code, _, error = go("watch FILM -o c.json --events c.json.rows.jsonl")
    assert (code, "Two outputs are the same file" in error) == (2, True)
    assert Path("mine").read_text() == "mine"
    assert here() == {"mine", "a.json.rows.jsonl", "b.json.rows.jsonl"}


def test_a_line_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "a.json.rows.jsonl"
    writer = JournalWriter(path, Header("film", 8, 8, "object"))
    for index in range(3):
        writer.add(FrameRow(index, index / 4, ()))
    writer.close()
    data = path.read_bytes()
    path.write_bytes(data[:-5])
    assert [each.frame for each in recording_of_journal(path)] == [0, 1]
    assert len(json.loads(b"".join(coco(recording_of_journal(path))))["images"]) == 2
    begin = data.index(b'{"frame":1')
    path.write_bytes(data[:begin] + b"{" + data[begin:])
    with pytest.raises(SourceError, match="damaged in line 3"):
        list(recording_of_journal(path))
