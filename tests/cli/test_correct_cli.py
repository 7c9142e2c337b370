"""`motes track` with keyframes, `refine`, `smooth` and `check`."""

import csv
import itertools
import json
import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pytest
from msgspec.structs import replace
from PIL import Image

import motes
from clips import write_film
from commands import Tell, read_csv
from lens_files import lens_file
from motes import TrackWriter, read_track
from motes.cli import main
from motes.core.track import COLUMNS, GROUND
from motes.correction import History, run_pass
from motes.correction.rows import KnownRows
from motes.rows.schema import HINDSIGHT
from motes.synthetic.clips import still

FRAMES = 24
CLIP = still((96, 80), target=(30, 40), frames=FRAMES)
BOX = "30,25,30,40"
OPTIONS = "--preset mean_shift"
TWO = "--init BOX --init 20,20,30,40"


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("film") / "film.mkv"
    write_film(path, CLIP)
    return path


@pytest.fixture
def go(film: Path, here: Path, capfd: pytest.CaptureFixture[str]) -> Tell:
    """Run motes in an empty folder; FILM and BOX stand for the film and its target."""
    return Tell(capfd, FILM=film, BOX=BOX)


@pytest.fixture(scope="module")
def bad(film: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of rows with one fault each, and of films that are not theirs."""
    folder = tmp_path_factory.mktemp("bad")
    for name, fps, frames in (("other.mkv", 25, FRAMES - 1), ("slow.mkv", 10, FRAMES)):
        write_film(folder / name, itertools.islice(CLIP, frames), fps)
    good = "0,0,1,,22,32,16,16,30,40,8,8,0,1,,tracking,,,\n"
    for name, text in {
        "head": "",
        "negative": good.replace(",8,8,", ",-8,8,"),
        "huge": good.replace(",8,8,", ",1e300,8,"),
        "below": f"-1{good[1:]}",
        "untimed": good.replace("0,0", "0,nan", 1),
        "status": good.replace("tracking", "flying"),
        "degrees": good.replace(",0,1,,", ",30,1,,"),
        "percent": good.replace(",0,1,,", ",0,97,,"),
        "minus": good.replace(",0,1,,", ",0,-1,,"),
    }.items():
        (folder / f"{name}.csv").write_text(",".join(COLUMNS) + "\n" + text)
    (folder / "objects.csv").write_text("frame,time,id,x,y\n0,0,1,2,3\n")
    unsure = [name for name in COLUMNS if name != "confidence"]
    (folder / "unsure.csv").write_text(",".join(unsure) + "\n" + ",".join("1" * len(unsure)) + "\n")
    for name, mark in (("rows", f"--at 0={BOX}"), ("plain", f"--init {BOX}"),
                       ("metres", f"--init {BOX} --scale 8")):  # fmt: skip
        assert main(f"track {film} {mark} {OPTIONS} -o {folder}/{name}.csv".split()) == 0
    (folder / "metres.csv").rename(folder / "alone.csv")
    return folder


@contextmanager
def interrupted_at(number: int) -> Iterator[None]:
    """Let Ctrl-C come before a pass of a correction, counted from 1."""
    calls = itertools.count(1)

    def one(*arguments: object, **options: object) -> object:
        if next(calls) == number:
            raise KeyboardInterrupt
        return run_pass(*arguments, **options)  # type: ignore[arg-type]

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("motes.correction.correct.run_pass", one)
        yield


@contextmanager
def ended_in_frame_12(written: int) -> Iterator[None]:
    """Let a run end while it writes the row of a frame, of which so many bytes are there."""

    def write(_: TrackWriter, file: BinaryIO, data: bytes) -> None:
        if data.startswith(b"12,"):
            file.write(data[:written])
            raise RuntimeError
        file.write(data)

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(TrackWriter, "_write", write)
        yield


def test_six_numbers_without_titles_are_said_to_be_ellipses(go: Tell) -> None:
    """They may be a box with its score."""
    line = f"track FILM --keyframes keys.csv -o rows.csv {OPTIONS} --end 4 --overwrite"
    said = "keys.csv: its rows are read as frame,x,y,a,b,theta of ellipses; if the numbers are"
    titled = ("frame,x,y,a,b,theta\n", '"frame","x","y","a","b","theta"\n')
    for before, told in (("", True), ("film.mkv,", True), *((each, False) for each in titled)):
        Path("keys.csv").write_text(f"{before}0,44,44,15,20,0.9\n")
        go.says(line, 0, said, told=told)


def test_rows_between_keyframes(go: Tell) -> None:
    Path("keys.csv").write_text("20,BOX\n10:11,absent\n".replace("BOX", BOX))
    line = f"track FILM --keyframes keys.csv --at 4=BOX -o rows.csv {OPTIONS}"
    go.says(line, 0, f"{FRAMES} frames, 4 keyframes, tracking in 22, absent in 2; wrote rows.csv.")
    found = read_csv("rows.csv")
    assert tuple(found[0]) == (*COLUMNS, *HINDSIGHT)
    assert [int(row["frame"]) for row in found] == [*range(FRAMES)]
    assert [row["status"] for row in found if row["frame"] in ("10", "11")] == ["absent"] * 2
    assert found[10]["x"] == found[10]["x_std"] == ""
    assert (found[4]["x"], found[4]["a"], found[4]["x_std"]) == ("44.500", "15.000", "0.00000")
    assert go(line)[0] == 5
    assert go(f"{line} --overwrite --format jsonl")[0] == 0
    assert json.loads(Path("rows.csv").read_text().splitlines()[10])["x"] is None


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="others have only names of text")
def test_a_film_whose_name_is_no_text(go: Tell, film: Path) -> None:
    name = "l\udcfcbeck.mkv"  # Latin-1, as of an old disk
    shutil.copy(film, name)
    assert go(f"track {name} --init BOX -o rows.csv {OPTIONS}")[0] == 0
    assert History.load(Path("rows.csv.run.json")).film == "l\\udcfcbeck.mkv"
    go.says(f"refine {name} rows.csv --at 9=BOX", 0, "is taken for it", told=False)
    assert go(f"watch {name} -o many.jsonl --end 5")[0] in (0, 4)
    assert go(f"convert rows.csv a.json --to coco --video {name}")[0] == 0
    go.says("batch *.mkv --do watch -o results", 2, "beck.mkv has bytes that are no text; rename")


def test_of_several_objects_one_is_taken(go: Tell) -> None:
    assert go(f"track FILM {TWO} -o many.csv {OPTIONS} --end 3")[0] == 0
    for line in ("refine FILM many.csv --at 2=BOX", "check FILM many.csv", "smooth many.csv -o s"):
        code, said = go(line)
        message = "many.csv has 2 objects; choose one, as with --identity 1."
        assert (code, message in said, len(said.splitlines())) == (3, True, 1), said
        go.says(f"{line} --identity 7", 3, "many.csv has no object 7; it has 1, 2.")
    assert go("convert many.csv one.csv --identity 2")[0] == 0
    for rows, chosen in (("many.csv", "--identity 2"), ("one.csv", "")):
        assert go(f"check FILM {rows} {chosen} -o {rows}.list.csv")[0] == 0
        name, only = f"{rows}.smooth.csv", " of object 2 alone" * bool(chosen)
        go.says(f"smooth {rows} -o {name} {chosen}", 0, f"wrote {name}{only}.")
    for ending in ("list", "smooth"):
        several, alone = (Path(f"{name}.csv.{ending}.csv") for name in ("many", "one"))
        assert several.read_text() == alone.read_text()
    for number, message in (
        (-1, "odd.csv has no object -1; it has 2."),
        (-5, "odd.csv has the id -5; identities count from 0, and -1 is none: correct"),
    ):
        Path("odd.csv").write_text(Path("many.csv").read_text().replace(",1,,", f",{number},,"))
        for line in ("refine FILM odd.csv --at 2=BOX", "check FILM odd.csv", "smooth odd.csv -o s"):
            assert len(go.says(f"{line} --identity {number}", 3, message).splitlines()) == 1
    Path("many.csv.run.json").unlink()
    assert go("refine FILM many.csv --identity 2 --at 2=BOX")[0] == 0
    known = History.load(Path("many.csv.run.json"))
    assert (known.corrections, len(known.objects[2].corrections)) == ([], 2)


def test_a_stretch_without_the_target_is_one_correction(go: Tell) -> None:
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS} --end 9")[0] == 0
    go.says("refine FILM rows.csv --absent 2:4 --absent 5", 0, "1 correction, ")
    go.says("refine FILM rows.csv --at 1=BOX --absent 7:8", 0, "2 corrections, ")


def test_what_is_left_of_one_of_several_objects_is_finished(go: Tell) -> None:
    """Also without --identity: it is known whose stretch is not finished."""
    assert go(f"track FILM {TWO} -o many.csv {OPTIONS} --end 6")[0] == 0
    assert go("refine FILM many.csv --identity 2 --at 4=BOX")[0] == 0
    rows, path = Path("many.csv"), Path("many.csv.run.json")
    whole, known = rows.read_bytes(), History.load(path)
    killed = replace(known.objects[2], unfinished=[(0, 4)])
    replace(known, objects={2: killed}).save(rows, whole=True)
    go.says("refine FILM many.csv", 0, "0 corrections, 5 rows of 6 made anew; wrote many.csv.")
    assert (rows.read_bytes(), History.load(path)) == (whole, known)


@pytest.mark.slow
@pytest.mark.parametrize("ending", ["csv", "jsonl"])
def test_one_of_several_objects_is_corrected_in_its_place(go: Tell, ending: str) -> None:
    """It gets the rows that it would get alone, and the others keep theirs."""
    rows, alone = f"many.{ending}", f"one.{ending}"
    assert go(f"track FILM {TWO} -o {rows} {OPTIONS}")[0] == 0
    assert go(f"convert {rows} {alone} --identity 2")[0] == 0
    before, listed = read_track(rows), Path("list.csv")
    assert go(f"check FILM {rows} --identity 1 -o {listed}")[0] == 0
    doubts = listed.read_text()
    for line in ("--at 9=24,20,30,40", "--absent 15"):
        assert go(f"refine FILM {rows} --identity 2 {line}")[0] == 0
        assert go(f"refine FILM {alone} {line}")[0] == 0
    after, expected = read_track(rows), read_track(alone)
    assert after["id"].tolist() == before["id"].tolist() == [1, 2] * FRAMES
    for name in (*COLUMNS, *HINDSIGHT):
        np.testing.assert_array_equal(after[name][1::2], expected[name], err_msg=name)
    for name in COLUMNS:
        np.testing.assert_array_equal(after[name][::2], before[name][::2], err_msg=name)
    others = KnownRows(Path(rows), identity=1).tracks
    assert all(np.isnan(np.diag(each.covariance)).all() for each in others)
    assert not any(each.outlier for each in others)
    assert go(f"check FILM {rows} --identity 1 -o {listed} --overwrite")[0] == 0
    assert listed.read_text() == doubts
    assert go(f"smooth {rows} --identity 1 -o smooth.csv")[0] == 0
    assert not History.load(Path("smooth.csv.run.json")).objects
    assert go(f"convert {rows} again.{ending} --identity 2")[0] == 0
    for line in (f"refine FILM {rows} --identity 1", f"refine FILM again.{ending}"):
        assert go(f"{line} --at 20=BOX")[0] == 0
    known = History.load(Path(f"{rows}.run.json"))
    assert [(i, len(each.corrections)) for i, each in known.objects.items()] == [(2, 3), (1, 2)]
    assert not known.corrections
    assert len(History.load(Path(f"again.{ending}.run.json")).corrections) == 4
    assert go(f"draw FILM {rows} -o drawn.mkv")[0] == 0


def test_an_interrupted_correction_of_one_object_is_finished(go: Tell) -> None:
    assert go(f"track FILM {TWO} -o many.csv {OPTIONS}")[0] == 0
    line = "refine FILM many.csv --identity 2 --at 9=BOX --at 15=BOX"
    assert go(f"{line} -o expected.csv")[0] == 0
    with interrupted_at(3):
        assert go(line)[0] == 130
    go.says("check FILM many.csv --identity 1", 0, "motes refine film.mkv many.csv --identity 2")
    said = go.says("smooth many.csv --identity 1 -o smooth.csv", 0, "was killed", told=False)
    assert "finish it with: motes refine film.mkv many.csv --identity 2" in said
    assert go("refine FILM many.csv --identity 2")[0] == 0
    assert Path("many.csv").read_text() == Path("expected.csv").read_text()
    assert "was not finished" not in go("check FILM many.csv --identity 1")[1]


def test_two_objects_corrected_at_once_lose_no_correction(go: Tell) -> None:
    """The first to end writes its rows; the other one says that it could not, and is repeated."""
    assert go(f"track FILM {TWO} -o many.csv {OPTIONS}")[0] == 0
    one, other = (f"refine FILM many.csv --identity {number} --at 9=BOX" for number in (1, 2))
    for line in (f"{one} -o half.csv", f"{other.replace('many', 'half')} -o expected.csv"):
        assert go(line)[0] == 0
    with pytest.MonkeyPatch.context() as patched:

        def meanwhile(*arguments: object, **options: object) -> object:
            patched.undo()
            assert go(other)[0] == 0
            return run_pass(*arguments, **options)  # type: ignore[arg-type]

        patched.setattr("motes.correction.correct.run_pass", meanwhile)
        go.says(one, 5, "many.csv has changed meanwhile, and stays so")
    assert go(one)[0] == 0
    assert Path("many.csv").read_text() == Path("expected.csv").read_text()
    known = History.load(Path("many.csv.run.json"))
    assert sorted(known.objects) == [1, 2]
    assert not any(each.unfinished for each in known.objects.values())


def test_others_are_drawn_in_frames_without_the_corrected_object(go: Tell) -> None:
    """As in rows that another tool has written, without the history of a run."""
    assert go(f"track FILM {TWO} -o run.csv {OPTIONS}")[0] == 0
    lines = Path("run.csv").read_text().splitlines(keepends=True)
    late = [line for line in lines if line.split(",")[2] != "2" or 5 <= int(line.split(",")[0]) < 9]
    Path("many.csv").write_text("".join(late))
    assert go("refine FILM many.csv --identity 2 --at 7=BOX")[0] == 0
    go.says("draw FILM many.csv -o drawn.mkv", 0, f"{FRAMES} frames")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_nothing_is_remembered_beside_a_pipe(go: Tell, monkeypatch: pytest.MonkeyPatch) -> None:
    """As beside /dev/stdout, whose lines would be counted by waiting for what one wrote oneself."""
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS} --end 3")[0] == 0
    os.mkfifo("pipe.csv")
    monkeypatch.setattr("motes.correction.history.line_count", lambda _: 4)
    with open(os.open("pipe.csv", os.O_RDWR), "rb", buffering=0) as reader:
        for line in ("convert rows.csv pipe.csv", "smooth rows.csv -o pipe.csv"):
            assert go(line)[0] == 0
            assert reader.read(1 << 16).startswith(b"frame,time,id,")
    assert not Path("pipe.csv.run.json").exists()


def test_spaces_behind_commas_stay_out_of_values_that_are_written_anew(go: Tell) -> None:
    assert go(f"track FILM {TWO} -o many.csv {OPTIONS} --end 4")[0] == 0
    path = Path("many.csv")
    path.write_text(path.read_text().replace(",2,,", ',2,"red,car",').replace(",", ", "))
    assert go("refine FILM many.csv --identity 1 --at 2=BOX")[0] == 0
    assert [row["label"] for row in read_csv(path) if row["id"] == "2"] == ["red, car"] * 4


def test_lines_end_as_those_of_the_file(go: Tell) -> None:
    """As of one that a program on Windows has written."""
    assert go(f"track FILM {TWO} -o many.csv {OPTIONS} --end 4")[0] == 0
    path = Path("many.csv")
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    for line in ("--at 2=BOX", "--absent 3"):
        assert go(f"refine FILM many.csv --identity 2 {line}")[0] == 0
        assert path.read_bytes().count(b"\n") == path.read_bytes().count(b"\r\n") == 1 + 2 * 4
    assert go(f"track FILM --at 0=BOX --at 12=BOX -o one.csv {OPTIONS}")[0] == 0
    before = Path("one.csv").read_bytes().replace(b"\n", b"\r\n")
    Path("one.csv").write_bytes(before)
    assert go("refine FILM one.csv --at 18=31,25,30,40")[0] == 0
    assert Path("one.csv").read_bytes().startswith(b"".join(before.splitlines(True)[:13]))


def test_other_objects_keep_their_names_and_their_metres(go: Tell) -> None:
    """Their fields stay as they are, and only new columns come between."""
    assert go(f"track FILM {TWO} -o many.csv {OPTIONS} --scale 10")[0] == 0
    path = Path("many.csv")
    path.write_text(path.read_text().replace(",1,,", ',1,"a ""long"", grey one",'))
    before = read_csv("many.csv")
    assert go("refine FILM many.csv --identity 2 --at 9=BOX")[0] == 0
    after = read_csv("many.csv")
    assert tuple(after[0]) == (*COLUMNS, *HINDSIGHT, *GROUND)
    for old, new in zip(before, after, strict=True):
        if old["id"] == "1":
            assert new == old | dict.fromkeys(HINDSIGHT, "")
    Path("many.csv.run.json").unlink()
    Path("many.csv").write_text("".join(path.read_text().splitlines(keepends=True)[i] for i in
                                        (0, 1, 1, 2)))  # fmt: skip
    go.says("check FILM many.csv --identity 2", 3, "many.csv has an object twice in a frame;")


def test_a_target_that_has_turned_on_and_on_is_checked_and_followed_again(go: Tell) -> None:
    """Its angle is beyond a turn where a pass begins; what is typed begins within one."""
    assert go(f"track FILM --init 44,44,15,20,0.5 -o rows.csv {OPTIONS}")[0] == 0
    first, *parts = Path("rows.csv").read_text().split(",0.50000,")
    assert len(parts) == FRAMES
    turned = [f",{0.5 + i:.5f},{part}" for i, part in enumerate(parts)]
    Path("turned.csv").write_text("".join([first, *turned]))
    code, said = go("check FILM turned.csv")
    assert code == 0, said
    assert go("convert turned.csv keys.csv --to keyframes")[0] == 0
    assert go(f"track FILM --keyframes keys.csv -o again.csv {OPTIONS}")[0] == 0
    before = {name: Path(name).read_bytes() for name in ("rows.csv", "rows.csv.run.json")}
    mark = "--at 3=44,44,15,20,30"
    for line in (f"track FILM {mark} -o new.csv", f"refine FILM rows.csv {mark}"):
        go.says(line, 2, f"{mark}: theta begins with 30")
    assert {name: Path(name).read_bytes() for name in before} == before


def test_other_outputs(go: Tell) -> None:
    line = f"track FILM --at 0=BOX --absent 5 -o d.xml --overlay d.mp4 {OPTIONS}"
    go.says(line, 0, "wrote d.mp4, d.xml")
    assert Path("d.xml").read_text().count("<box ") >= 2
    assert not Path("d.xml.run.json").exists()


def test_rows_that_are_smooth_already_are_refused(go: Tell) -> None:
    """What a user has marked would move."""
    assert go(f"track FILM --at 4=BOX --at 20=BOX -o keys.csv {OPTIONS}")[0] == 0
    assert go(f"track FILM --init BOX -o plain.csv {OPTIONS}")[0] == 0
    assert go("smooth plain.csv -o smooth.csv")[0] == 0
    for name in ("keys.csv", "smooth.csv"):
        code, said = go(f"smooth {name} -o again.csv")
        message = f"{name} is smoothed or corrected already; give rows of a plain motes track."
        assert (code, message in said, len(said.splitlines())) == (3, True, 1), said
    assert not Path("again.csv").exists()


def test_rows_with_frames_between_that_are_missing_are_refused(go: Tell) -> None:
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS} --stride 3")[0] == 0
    before = {name: Path(name).read_bytes() for name in ("rows.csv", "rows.csv.run.json")}
    for line in ("smooth rows.csv -o smooth.csv", "refine FILM rows.csv --at 9=BOX"):
        code, said = go(line)
        whole = "rows.csv has 8 rows of the frames 0 to 21; make rows of every frame: motes" in said
        assert (code, whole) == (3, True), said
    assert {name: Path(name).read_bytes() for name in before} == before


def test_of_a_killed_run_it_is_said_that_rows_are_missing(go: Tell) -> None:
    with ended_in_frame_12(0):
        assert go(f"track FILM --init BOX -o rows.csv {OPTIONS}")[0] != 0
    for reader in ("convert rows.csv a.xml", "smooth rows.csv -o s.csv"):
        go.says(reader, 0, "the run of rows.csv was killed, or still goes on: what")
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS} --resume")[0] == 0
    assert "killed" not in go("convert rows.csv b.xml")[1]


def test_rows_up_to_a_frame_that_cannot_be_read_are_those_of_a_run_that_ended(go: Tell) -> None:
    Path("film").mkdir()
    for n, size in enumerate([(64, 48)] * 4 + [(60, 48)]):
        Image.effect_noise(size, 50).convert("RGB").save(f"film/{n}.png")
    code, _ = go("track film --init 20,15,20,16 -o rows.csv")
    known = History.load(Path("rows.csv.run.json"))
    assert (code, known.last, known.lines) == (3, 3, 5)
    assert "killed" not in go("convert rows.csv a.xml")[1]
    Path("film/4.png").unlink()
    assert go("track film --init 20,15,20,16 -o rows.csv --resume")[0] == 0


def test_a_killed_run_is_finished(go: Tell, monkeypatch: pytest.MonkeyPatch) -> None:
    """The kill is in the middle of a row."""
    line = f"track FILM --at 0=BOX --at 8=BOX --at 16=BOX {OPTIONS}"
    assert go(f"{line} -o expected.csv")[0] == 0
    with ended_in_frame_12(9):
        assert go(f"{line} -o rows.csv")[0] != 0
    assert History.load(Path("rows.csv.run.json")).unfinished == [(8, 16), (16, 23)]
    calls = list[int]()

    def counted(*arguments: object, **options: object) -> object:
        calls.append(1)
        return run_pass(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr("motes.correction.correct.run_pass", counted)
    go.says("refine FILM rows.csv", 0, "16 rows of 24 made anew")
    assert len(calls) == 3
    assert Path("rows.csv").read_text() == Path("expected.csv").read_text()


@pytest.mark.parametrize("mark", ["--init BOX", "--at 0=BOX"])
def test_an_interrupt_before_the_first_row_leaves_what_was_there(
    go: Tell, monkeypatch: pytest.MonkeyPatch, mark: str
) -> None:
    def interrupted(*_: object) -> object:
        raise KeyboardInterrupt

    monkeypatch.setattr("motes.sot.tracker.Tracker.init", interrupted)
    line = f"track FILM {mark} -o rows.csv --overlay o.mp4 {OPTIONS}"
    code, said = go(line)
    assert (code, said) == (130, "motes: interrupted after 0 frames; nothing is written.\n")
    assert not [*Path().iterdir()]
    Path("rows.csv").write_text("old")
    assert go(f"{line} --overwrite")[0] == 130
    assert Path("rows.csv").read_text() == "old"


@pytest.mark.slow
def test_an_interrupt_on_the_way_back_leaves_the_stretch_to_be_finished(go: Tell) -> None:
    """The forward pass is complete then, and its rows are written, but they are not the last."""
    line = f"track FILM --at 0=BOX --at 12=31,25,30,40 --at 20=BOX --scale 20 {OPTIONS}"
    assert go(f"{line} -o expected.csv")[0] == 0
    with interrupted_at(4):  # the second pass of the second stretch
        assert go(f"{line} -o rows.csv")[0] == 130
    assert len(read_csv("rows.csv")) == 21
    history = History.load(Path("rows.csv.run.json"))
    assert history.unfinished == [(12, 20), (20, 23)]
    readers = "check FILM rows.csv", "convert rows.csv c.csv", "draw FILM rows.csv -o o.mp4"
    for reader in readers:
        said = go.says(reader, 0, "the run of rows.csv was not finished between frames 12 and 23")
        assert "No frame is in doubt" not in said
    assert go("refine FILM rows.csv")[0] == 0
    assert Path("rows.csv").read_text() == Path("expected.csv").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("mark", ["--at 0=BOX", "--init BOX"])
def test_a_correction_killed_between_its_files_is_finished(
    go: Tell, monkeypatch: pytest.MonkeyPatch, mark: str
) -> None:
    """The history is written before the rows and after them."""
    assert go(f"track FILM {mark} -o rows.csv {OPTIONS}")[0] == 0
    assert go("refine FILM rows.csv --at 12=31,25,30,40 -o expected.csv")[0] == 0
    expected, old = Path("expected.csv").read_text(), Path("rows.csv").read_text()
    save = History.save
    for killed in ("before the rows", "after the rows"):
        Path("rows.csv").write_text(old)
        calls = list[int]()

        def once(
            history: History, rows: Path, *, whole: bool = False, calls: list[int] = calls
        ) -> None:
            calls.append(1)
            if len(calls) > 1:
                raise KeyboardInterrupt
            save(history, rows, whole=whole)

        with monkeypatch.context() as patched:
            patched.setattr(History, "save", once)
            if killed == "before the rows":
                patched.setattr(KnownRows, "write", lambda *_: None)
            assert go("refine FILM rows.csv --at 12=31,25,30,40")[0] == 130
        assert (Path("rows.csv").read_text() == old) == (killed == "before the rows")
        assert History.load(Path("rows.csv.run.json")).unfinished == [(0, 12), (12, 23)]
        assert go("refine FILM rows.csv")[0] == 0
        assert Path("rows.csv").read_text() == expected
        assert not History.load(Path("rows.csv.run.json")).unfinished
        Path("rows.csv.run.json").unlink()
        assert go(f"track FILM {mark} -o rows.csv --overwrite {OPTIONS}")[0] == 0


def test_other_rows_stay_to_the_byte(go: Tell) -> None:
    assert go(f"track FILM --at 0=BOX --at 12=BOX -o rows.csv {OPTIONS}")[0] == 0
    before = Path("rows.csv").read_text().splitlines()
    go.says("refine FILM rows.csv --at 18=31,25,30,40 --absent 20:21", 0, "12 rows of 24 made anew")
    after = Path("rows.csv").read_text().splitlines()
    changed = [i - 1 for i, (a, b) in enumerate(zip(before, after, strict=True)) if a != b]
    assert min(changed) > 12
    assert after[19].split(",")[8] == "45.500"
    history = History.load(Path("rows.csv.run.json"))
    assert [len(marks) for marks in history.corrections] == [2, 3]
    # The history repeats the run.
    keys = "".join(f"{frame},{_text(mark)}\n" for frame, mark in history.keys.items())
    Path("keys.csv").write_text(keys)
    assert go(f"track FILM --keyframes keys.csv -o again.csv {OPTIONS}")[0] == 0
    assert Path("again.csv").read_text().splitlines() == after


def test_a_target_that_leaves_has_its_center_outside(go: Tell) -> None:
    """Rows of the film; those of a target that is all outside are of a larger one."""
    head, row = ",".join(COLUMNS) + "\n", "{},1,,{},32,16,16,{},40,8,8,0,1,,tracking,,,\n"
    first = head + row.format("0,0", 22, 30)
    Path("leaves.csv").write_text(first + row.format("1,0.04", 90, 98))
    code, said = go("check FILM leaves.csv")
    assert code == 0, said
    Path("left.csv").write_text(first + row.format("1,0.04", 100, 108))
    go.says("check FILM left.csv", 3, "left.csv has the target at 100.5,32.5 in frame 1, outside")


def _text(mark: Sequence[float] | None) -> str:
    return "absent" if mark is None else ",".join(f"{value:g}" for value in mark)


@pytest.mark.slow
@pytest.mark.parametrize("metres", ["", "--scale 20"])
def test_corrected_rows_are_those_of_a_run_between_the_same_keyframes(
    go: Tell, metres: str
) -> None:
    """Also those of a plain run, which lack what `motes check` reads."""
    options = f"{OPTIONS} {metres}"
    assert go(f"track FILM --at 0=BOX --at 12=31,25,30,40 -o expected.jsonl {options}")[0] == 0
    assert go(f"track FILM --init BOX -o rows.jsonl {options}")[0] == 0
    go.says("refine FILM rows.jsonl --at 12=31,25,30,40", 0, "24 rows of 24 made anew")
    assert Path("rows.jsonl").read_text() == Path("expected.jsonl").read_text()
    assert go("refine FILM rows.jsonl --at 3=BOX --seed 1")[1].count(
        "--seed is already in rows.jsonl.run.json"
    )


def test_an_interrupted_correction_is_finished_later(go: Tell) -> None:
    assert go(f"track FILM --at 0=BOX -o rows.csv {OPTIONS}")[0] == 0
    whole = Path("rows.csv").read_text()
    assert go("refine FILM rows.csv --at 12=31,25,30,40 -o expected.csv")[0] == 0
    with interrupted_at(3):  # the passes of the first stretch are done
        go.says("refine FILM rows.csv --at 12=31,25,30,40", 130, "interrupted after 1 correction")
    kept = Path("rows.csv").read_text().splitlines()
    expected = Path("expected.csv").read_text().splitlines()
    assert kept[:14] == expected[:14]
    assert kept[15:] == whole.splitlines()[15:]
    stopped = {name: Path(name).read_bytes() for name in ("rows.csv", "rows.csv.run.json")}
    for repeated in ("", " --at 12=31,25,30,40"):  # finished, or the same command once more
        for name, data in stopped.items():
            Path(name).write_bytes(data)
        assert go(f"refine FILM rows.csv{repeated}")[0] == 0
        assert Path("rows.csv").read_text().splitlines() == expected
        remembered = Path("rows.csv.run.json").read_bytes()
        assert remembered == Path("expected.csv.run.json").read_bytes()


def test_what_is_lost_has_no_metres_when_it_is_bridged(go: Tell) -> None:
    """Its confidence stays, so it is less likely there than not."""
    assert go(f"track FILM --init BOX --scale 20 -o rows.csv {OPTIONS}")[0] == 0
    found = read_csv("rows.csv")
    for row in found[10:13]:
        row |= {"status": "searching", "confidence": "0.08"} | dict.fromkeys(GROUND, "")
    with open("rows.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, [*found[0]])
        writer.writeheader()
        writer.writerows(found)
    assert go("smooth rows.csv -o smooth.csv")[0] == 0
    smooth = read_csv("smooth.csv")
    assert [row["frame"] for row in smooth if row["status"] == "interpolated"] == ["10", "11", "12"]
    assert [row["frame"] for row in smooth if not row["x_m"]] == ["10", "11", "12"]
    assert [row["frame"] for row in smooth if not row["speed"]] == ["10", "11", "12"]
    assert all(float(row["confidence"]) <= 0.08 for row in smooth[10:13])
    assert float(smooth[11]["x_std"]) > float(smooth[9]["x_std"])
    python = motes.smooth(KnownRows(Path("rows.csv")).tracks)
    assert [f"{each.ellipse.x:.3f}" for each in python] == [row["x"] for row in smooth]


def test_doubtful_frames(go: Tell) -> None:
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS}")[0] == 0
    assert go(f"check FILM rows.csv --count 3 -o list.csv --sheet sheet.png {OPTIONS}")[0] == 0
    found = read_csv("list.csv")
    assert [row["rank"] for row in found] == ["1", "2", "3"]
    gains = [float(row["gain"]) for row in found]
    assert gains == sorted(gains, reverse=True)
    with Image.open("sheet.png") as sheet:
        assert sheet.size == (684, 270)
    assert go(f"track FILM --at 0=BOX --at 23=BOX -o keys.csv {OPTIONS}")[0] == 0
    assert go("check FILM keys.csv --count 1")[0] == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        ("track FILM --at places.toml", 2, "--at takes FRAME=x,y,width,height; got"),
        ("track FILM --at 99=BOX", 2, "keyframe 99 is outside of"),
        ("track FILM --at 3=BOX --at 3=1,2,30,40", 2, "frame 3 contradict each other"),
        ("track FILM --absent 3", 2, "The target is missing"),
        ("track FILM --at 3=BOX --stride 2 --resume --figures f", 2, "--stride, --resume and --f"),
        ("refine FILM rows.csv --at 3=BOX --seed 1", 2, "--seed is already in rows.csv.run.json"),
        ("refine FILM alone.csv --at 3=BOX", 2, "alone.csv has metres, but nothing beside"),
        ("refine FILM plain.csv --at 3=BOX --fps 9", 2, "--fps is already in plain.csv"),
        ("check FILM rows.csv -o rows.csv --overwrite", 2, "rows.csv is the source and cannot"),
        ("track FILM --at 3=BOX --detect face", 2, "Keyframes go with --init"),
        ("track 0 --at 3=BOX", 3, "record it first"),
        ("refine FILM rows.csv", 2, "nothing to correct"),
        ("refine FILM plain.csv --absent 9:9999", 2, "keyframe 9999 is outside of"),  # at once
        ("refine OTHER rows.csv --at 3=BOX", 3, "has 23 frames of 96x80, but the rows are of"),
        ("check OTHER plain.csv", 3, "has only 23 frames; give the film of these rows"),
        ("check SLOW plain.csv", 3, "has frame 1 at 0.04 s, but"),
        ("check FILM rows.csv --sheet a.jpg", 5, "does not end in .png"),
        ("smooth film.txt -o a.csv", 2, "motes convert makes such rows of other formats."),
        ("smooth objects.csv -o a.csv", 3, "objects.csv lacks label, a, b, theta,"),
        ("refine FILM unsure.csv --at 3=BOX", 3, "unsure.csv lacks confidence among its columns"),
        ("smooth plain.csv -o plain.csv", 2, "plain.csv is the source and cannot be an output"),
        ("refine FILM head.csv --at 3=BOX", 3, "head.csv has no rows"),
        ("smooth negative.csv -o a.csv", 3, "tracks the target in frame 0, but has no place"),
        ("smooth huge.csv -o a.csv", 3, "huge.csv has 1e+300 as a in frame 0; correct that row"),
        ("smooth below.csv -o a.csv", 3, "below.csv has a frame twice, out of order, or below 0"),
        ("check FILM untimed.csv", 3, "untimed.csv has frame 0 at nan s, but"),
        ("track FILM --at 3=BOX --start 5 --end 3", 2, "No frame is from 5 to 3"),
        ("track FILM --at 3=BOX --absent 0:9999999", 2, "are more than 1000000"),
        ("smooth status.csv -o a.csv", 3, "status.csv has the status 'flying' in frame 0"),
        ("check FILM degrees.csv", 3, "degrees.csv: theta begins with 30; it is in radians, and"),
        ("smooth percent.csv -o a.csv", 3, "percent.csv has the confidence 97 in frame 0, which"),
        ("smooth minus.csv -o a.csv", 3, "has the confidence -1 in frame 0, which is a prob"),
    ],
)
def test_bad_input_is_one_line(
    go: Tell, bad: Path, monkeypatch: pytest.MonkeyPatch, line: str, code: int, message: str
) -> None:
    monkeypatch.chdir(bad)
    before = {path: path.read_bytes() for path in bad.iterdir()}
    found, said = go(line.replace("OTHER", "other.mkv").replace("SLOW", "slow.mkv"))
    assert (found, len(said.splitlines())) == (code, 1), said
    assert message in said
    assert {path: path.read_bytes() for path in bad.iterdir()} == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("end", 99, "the frames 0 to 98 are none"),
        ("start", -5, "the frames -5 to 23 are none"),
        ("seed", -1, "A seed is a whole number"),
        ("units", {"x": 1}, "contains unknown field `x`"),
        ("config", {}, "it needs the key type; known are particle_filter"),
        ("config", {"type": "mean_shift", "turn_sigma": 0.1}, "delete the key to go on with"),
        ("corrections", [[[0, [1, 2]]]], "A region has 4 numbers"),
        ("form", 2, "of another version of motes"),  # in which boxes were ellipses
    ],
)
def test_a_history_that_was_changed(
    go: Tell, bad: Path, key: str, value: object, message: str
) -> None:
    for name in ("rows.csv", "rows.csv.run.json"):
        shutil.copy(bad / name, name)
    path = Path("rows.csv.run.json")
    known = json.loads(path.read_text())
    changed = {**known, key: value}
    for history in (changed, {**known, "objects": {"1": changed}}):
        path.write_text(json.dumps(history))
        for line in ("refine FILM rows.csv --at 3=BOX", "check FILM rows.csv"):
            code, said = go(f"{line} --identity 1")
            assert (code, len(said.splitlines()), message in said) == (3, 1, True), said


def test_rows_of_a_copy_that_was_cut(go: Tell) -> None:
    write_film("cut.mkv", itertools.islice(CLIP, 5))
    assert go(f"track cut.mkv --init BOX -o rows.csv {OPTIONS}")[0] == 0
    assert "rows.csv ends at frame 4, and film.mkv at frame 23" in go("check FILM rows.csv")[1]
    assert "ends at frame" not in go("check cut.mkv rows.csv")[1]


@pytest.mark.parametrize("more", ["", "--end 4"])
def test_another_film_of_the_same_size_and_times_is_said(go: Tell, film: Path, more: str) -> None:
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS} {more}")[0] == 0
    shutil.copy(film, "other.mkv")
    said = "rows.csv is of film.mkv, and other.mkv is taken for it, by its size and its times; give"
    go.says("refine other.mkv rows.csv --at 3=BOX -o new.csv", 0, said)
    go.says("check FILM rows.csv", 0, "is taken for it", told=False)


@pytest.mark.parametrize("mark", ["--init 20,10,20,20", "--at 0=20,10,20,20"])
def test_a_film_of_another_size_is_not_said_to_have_as_many_frames_as_the_rows(
    go: Tell, mark: str
) -> None:
    write_film("small.mkv", still((64, 48), target=(30, 20), frames=5))
    assert go(f"track small.mkv {mark} --end 4 -o rows.csv {OPTIONS}")[0] == 0
    said = "film.mkv has 96x80, but the rows are of small.mkv, with 64x48; give that film"
    go.says("check FILM rows.csv", 3, said)


def test_a_tracker_that_is_gone(go: Tell) -> None:
    """Its rows are converted, and corrected by another one."""
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS}")[0] == 0
    path = Path("rows.csv.run.json")
    made = json.loads(path.read_text())
    path.write_text(json.dumps(made | {"config": {"type": "gone"}}))
    assert go("check FILM rows.csv")[0] == 3
    assert go("convert rows.csv -o labels.json --to coco")[0] == 0
    path.write_text(json.dumps(made | {"preset": "gone"}))
    assert go("check FILM rows.csv")[0] == 0
    _, said = go("refine FILM rows.csv --at 3=BOX -o other.csv --seed 1")
    assert "rows.csv.run.json: No preset 'gone'" in said


@pytest.mark.slow
def test_what_is_remembered_is_not_asked_for_again(go: Tell) -> None:
    Path("l.yml").write_text(lens_file(size=(96, 80)))
    made = go(f"track FILM --init BOX --scale 20 --lens l.yml --fps 5 --seed 3 -o a.csv {OPTIONS}")
    assert made[0] == 0
    Path("l.yml").unlink()
    assert go("smooth a.csv -o s.csv")[0] == 0
    for name in ("a", "s"):
        known = History.load(Path(f"{name}.csv.run.json"))
        assert (known.fps, known.preset, known.seed) == (5, "mean_shift", 3)
        assert known.units is not None
        assert go(f"refine FILM {name}.csv --at 22=31,25,30,40")[0] == 0
        after = read_csv(f"{name}.csv")
        assert (after[22]["time"], after[22]["x_m"] != "") == ("4.400000", True)
        assert History.load(Path(f"{name}.csv.run.json")).fps == 5
    assert go("convert a.csv b.jsonl")[0] == 0
    assert go("refine FILM b.jsonl --at 9=BOX")[0] == 0


def test_rows_of_watched_objects_remember_their_lines(go: Tell) -> None:
    assert go("watch FILM --line 9,0,9,60 --scale 4 --fps 5 -o rows.csv")[0] in (0, 4)
    known = History.load(Path("rows.csv.run.json"))
    assert known.places is not None
    assert [*known.places.line[0].points] == [9, 0, 9, 60]
    assert known.fps == 5
    assert known.units is not None
    assert known.units.ground.scale == 4


@pytest.mark.slow
def test_rows_that_are_cut_between_two_lines_are_refused(go: Tell) -> None:
    """Also after a correction, and when they are smoothed."""
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS}")[0] == 0
    assert go("smooth rows.csv -o smooth.csv")[0] == 0
    assert go("refine FILM rows.csv --at 12=31,25,30,40 -o refined.csv")[0] == 0
    assert go(f"track FILM --at 0=BOX --at 12=31,25,30,40 -o marked.csv {OPTIONS}")[0] == 0
    for name in ("rows.csv", "smooth.csv", "refined.csv", "marked.csv"):
        assert go(f"refine FILM {name} --at 15=32,25,30,40 -o again.csv --overwrite")[0] == 0
        lines = Path(name).read_text().splitlines(keepends=True)
        Path(name).write_text("".join(lines[:-2]))
        go.says(f"smooth {name} -o other.csv", 3, f" has {len(lines) - 2} lines of {len(lines)}")
        assert not Path("other.csv").exists()


def test_rows_need_no_whole_box(go: Tell) -> None:
    """What is corrected is the ellipse; the columns of the box are made anew."""
    assert go(f"track FILM --init BOX -o plain.csv {OPTIONS}")[0] == 0
    table = [line.split(",") for line in Path("plain.csv").read_text().splitlines()]
    top = table[0].index("top")
    for row in table:
        del row[top]
    Path("part.csv").write_text("".join(",".join(row) + "\n" for row in table))
    assert go("check FILM part.csv")[0] == 0
    assert go("smooth part.csv -o smooth.csv")[0] == 0
    assert float(read_csv("smooth.csv")[0]["top"]) == pytest.approx(25, abs=0.5)


def test_rows_that_end_before_their_film_are_corrected_twice(go: Tell) -> None:
    """Without a run beside them, as of one object of a scene that has left."""
    assert go(f"track FILM --init BOX -o plain.csv {OPTIONS}")[0] == 0
    lines = Path("plain.csv").read_text().splitlines(keepends=True)
    Path("rows.csv").write_text("".join(lines[: FRAMES // 2]))
    for frame in (3, 5):
        assert go(f"refine FILM rows.csv --at {frame}=absent")[0] == 0
    assert [read_csv("rows.csv")[frame]["status"] for frame in (3, 5)] == ["absent", "absent"]


def test_boxes_over_rows_with_angles_are_not_taken_in_silence(go: Tell) -> None:
    """The first row is a box's, for all that is known; the others have turned."""
    assert go(f"track FILM --init BOX -o rows.csv {OPTIONS}")[0] == 0
    rows = Path("rows.csv").read_text().splitlines()
    names = rows[0].split(",")
    turned = rows[10].split(",")
    turned[names.index("theta")] = "0.50000"
    rows[10] = ",".join(turned)
    Path("rows.csv").write_text("\n".join(rows) + "\n")
    go.says("refine FILM rows.csv -o ellipse.csv --at 18=45,44,15,20,0.2", 0, "24 rows of 24")
    go.says("refine FILM ellipse.csv --at 20=31,25,30,40", 2, "by a box, which tells no angle")
    go.says("refine FILM rows.csv -o away.csv --absent 20", 0, "have angles", told=False)
    kept = Path("away.csv").read_bytes(), Path("away.csv.run.json").read_bytes()
    go.says("refine FILM away.csv --at 18=31,25,30,40", 0, "1 correction, 24 rows of 24 made anew")
    go.says("refine FILM away.csv --at 16=45,44,15,20,0.2", 2, "by a box, which tells no angle")
    Path("away.csv").write_bytes(kept[0])
    Path("away.csv.run.json").write_bytes(kept[1])
    go.says("refine FILM away.csv --at 18=45,44,15,20,0.2", 0, "have angles", told=False)
    go.says("refine FILM away.csv --at 16=31,25,30,40", 2, "by a box, which tells no angle")
    go.says("refine FILM rows.csv --at 18=31,25,30,40", 0, "These rows have angles, and a box")


def test_boxes_of_other_tools_are_not_replaced_in_silence(go: Tell) -> None:
    assert go(f"track FILM --init BOX {OPTIONS} -o rows.csv")[0] == 0
    assert go("convert rows.csv task.xml")[0] == 0
    assert go("convert task.xml drawn.csv --video FILM")[0] == 0
    said = "is not of a tracker of motes, and only its first box is kept. To keep more, make keyf"
    drawn = Path("drawn.csv").read_bytes()
    go.says("refine FILM drawn.csv --at 18=31,25,30,40", 2, f"drawn.csv {said}", lines=1)
    assert Path("drawn.csv").read_bytes() == drawn
    go.says("refine FILM drawn.csv --at 18=31,25,30,40 -o own.csv", 0, f"drawn.csv {said}")
    go.says("refine FILM own.csv --at 12=31,25,30,40", 0, said, told=False)  # they are now
    go.says("refine FILM rows.csv --at 18=31,25,30,40", 0, said, told=False)
