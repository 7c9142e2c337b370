"""motes draw, from the outside: pictures of rows of every kind."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from clips import write_pictures
from commands import Tell
from motes import EventCounter, Regions, Zone, open_source, read_track
from motes.cli import main
from motes.cli.draw import object_moments, rows_in
from motes.video.decoder import Decoder

FRAMES = 30
TRACK = "track film.mkv --init 20,20,20,20 --preset mean_shift"


def picture(left: int) -> np.ndarray:
    """Return a red box so far right on gray."""
    pixels = np.full((60, 120, 3), 90, np.uint8)
    pixels[20:40, left : left + 20] = (230, 40, 40)
    return pixels


def make_film() -> None:
    """Make a film of a red box that walks two pixels a frame, in the current folder."""
    write_pictures("film.mkv", (picture(20 + 2 * index) for index in range(FRAMES)))


@pytest.fixture
def go(here: Path, capfd: pytest.CaptureFixture[str]) -> Tell:
    """Run motes in a folder with a film."""
    make_film()
    return Tell(capfd)


@pytest.fixture
def notes(monkeypatch: pytest.MonkeyPatch) -> list[Mapping[int, str]]:
    """Return what is written beside the objects of each frame that is drawn."""
    said = list[Mapping[int, str]]()

    def heard(pixels: np.ndarray, *others: Any) -> np.ndarray:
        said.append(others[-1])
        return pixels

    monkeypatch.setattr("motes.cli.annotated_video.draw_scene", heard)
    return said


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the labels that are drawn."""
    labels = list[str]()
    paint = "motes.output.overlay._draw_label"
    monkeypatch.setattr(paint, lambda image, text, *_: labels.append(text))
    return labels


def pictures(path: str | Path) -> list[np.ndarray]:
    with open_source(path) as film:
        return [frame.pixels.astype(int) for frame in film]


def changed(path: str | Path) -> list[bool]:
    """Return which pictures of an overlay differ from those of the film, beside its codec."""
    pairs = zip(pictures(path), pictures("film.mkv"), strict=True)
    return [bool((abs(drawn - plain) > 60).sum() > 30) for drawn, plain in pairs]


@pytest.mark.slow
def test_every_kind_of_rows_is_drawn(go: Tell) -> None:
    assert go(f"{TRACK} -o rows.csv")[0] == 0
    assert go("smooth rows.csv -o smooth.csv")[0] == 0
    assert go("refine film.mkv rows.csv -o refined.csv --at 25=70,20,20,20")[0] == 0
    names = ["rows.csv", "smooth.csv", "refined.csv"]
    for ending in ("jsonl", "xml", "keyframes.csv"):
        assert go(f"convert rows.csv other.{ending} --video film.mkv")[0] == 0
        names.append(f"other.{ending}")
    for name in names:
        go.says(f"draw film.mkv {name} -o drawn.mkv --overwrite", 0, "30 frames; wrote drawn.mkv")
        assert all(changed("drawn.mkv")) or "keyframes" in name, name


@pytest.mark.slow
def test_rows_of_one_object_are_those_of_a_target(go: Tell) -> None:
    """Also boxes, as between keyframes; but what a watched scene shows are objects."""
    target = ["path.pdf", "size.pdf", "speed.pdf"]
    assert go("track film.mkv --at 0=20,20,20,20 --preset mean_shift -o boxes.csv")[0] == 0
    assert go("convert boxes.csv one.txt")[0] == 0
    assert go("watch film.mkv -o seen.csv --line 50,0,50,59")[0] in (0, 4)
    Path("seen.csv").write_text(Path("boxes.csv").read_text())
    for name, figures in (
        ("boxes.csv", target), ("one.txt", target),
        ("seen.csv", ["heatmap.png", "paths.png", "slit.png"]),
    ):  # fmt: skip
        assert go(f"draw film.mkv {name} --figures {name}.d")[0] == 0
        found = sorted(path.name.partition(".")[2] for path in Path(f"{name}.d").iterdir())
        assert found == figures, name
    assert go("draw film.mkv boxes.csv --masks masks")[0] == 0


def test_of_several_objects_one_is_drawn(go: Tell) -> None:
    """Also of a scene that was watched, whose rows remember it."""
    assert go("watch film.mkv -o seen.csv")[0] in (0, 4)
    first, row, *more = Path("seen.csv").read_text().splitlines()
    Path("seen.csv").write_text("\n".join([first, row.replace(",1,,", ",2,,"), *more, ""]))
    go.says("draw film.mkv seen.csv --figures f --identity 3", 2, "no object 3; it has 1, 2.")
    assert go("draw film.mkv seen.csv --figures f --masks m --identity 2 --scale 9")[0] == 0
    assert {path.name for path in Path("f").iterdir()} == {
        f"seen.{name}.pdf" for name in ("path", "size", "speed")
    }


@pytest.mark.slow
def test_speeds_are_of_the_file_or_of_the_units(go: Tell, said: list[str]) -> None:
    """A box that walks 50 pixels a second, 10 pixels a metre, has 5 m/s beside its status."""
    assert go(f"{TRACK} -o metres.csv --scale 10")[0] == 0
    assert go(f"{TRACK} -o plain.csv")[0] == 0
    for line, true in (
        ("metres.csv", 5),
        ("plain.csv --scale 10", 5),
        ("plain.csv --scale 1e6", 5e-5),  # a microscope's
    ):
        said.clear()
        assert go(f"draw film.mkv {line} -o drawn.mkv --overwrite")[0] == 0
        speeds = [float(text.split()[-2]) for text in said if text.endswith("m/s")]
        assert len(speeds) > 20
        assert np.median(speeds) == pytest.approx(true, rel=0.1)
    said.clear()
    assert go("draw film.mkv plain.csv -o drawn.mkv --overwrite")[0] == 0
    assert not any(text.endswith("m/s") for text in said)


@pytest.mark.slow
def test_a_live_speed_is_drawn_when_it_was(go: Tell, said: list[str]) -> None:
    """Rows of a live run have that of a quarter of a second ago; the box gets ever faster."""
    write_pictures("fall.mkv", (picture(20 + round(0.08 * i**2)) for i in range(FRAMES)))
    fall = TRACK.replace("film.mkv", "fall.mkv")
    assert go(f"{fall} -o rows.csv --scale 2")[0] == 0
    Path("rows.csv.run.json").unlink()  # the metres are those of the rows
    assert go("draw fall.mkv rows.csv -o drawn.mkv")[0] == 0
    speeds = [float(text.split()[-2]) for text in said]
    true = 0.16 / 2 * 25 * np.arange(FRAMES)
    np.testing.assert_allclose(speeds[8:-8], true[8:-8], rtol=0.1)


@pytest.mark.slow
def test_rows_of_every_third_frame_have_speeds(go: Tell, said: list[str]) -> None:
    """Between them no target is unseen."""
    assert go(f"{TRACK} --stride 3 -o rows.csv")[0] == 0
    assert go("convert rows.csv metres.csv --scale 50")[0] == 0
    np.testing.assert_allclose(read_track("metres.csv")["speed"], 1, rtol=0.2)
    assert go("draw film.mkv rows.csv -o drawn.mkv --scale 50")[0] == 0
    assert [text.split()[-1] for text in said] == ["m/s"] * 10


@pytest.mark.slow
def test_metres_are_added_to_rows_later_or_corrected(go: Tell) -> None:
    """They are those that the run would have had, and are remembered for what is corrected."""
    marks = "track film.mkv --at 0=20,20,20,20 --preset mean_shift"
    assert go(f"{marks} -o expected.csv --scale 50")[0] == 0
    assert go(f"{marks} -o rows.csv")[0] == 0
    assert go("convert rows.csv wrong.csv --scale 5")[0] == 0
    assert go("convert wrong.csv metres.csv --scale 50")[0] == 0
    assert Path("metres.csv").read_text() == Path("expected.csv").read_text()
    assert go("refine film.mkv metres.csv --at 25=70,20,20,20")[0] == 0
    assert go("refine film.mkv expected.csv --at 25=70,20,20,20")[0] == 0
    assert Path("metres.csv").read_text() == Path("expected.csv").read_text()
    title, start, *others = Path("metres.csv").read_text().splitlines()
    fields = dict(zip(title.split(","), start.split(","), strict=True))
    start = ",".join("" if name.endswith("_m_std") else fields[name] for name in fields)
    Path("sure.csv").write_text("\n".join([title, start, *others, ""]))
    assert go("convert sure.csv again.csv")[0] == 0
    assert Path("again.csv").read_text() == Path("sure.csv").read_text()
    go.says("convert rows.csv rows.txt --scale 5", 2, "mot holds no metres", lines=1)


@pytest.mark.slow
def test_an_object_of_a_scene_is_checked_and_corrected(go: Tell) -> None:
    """The tracker of its run follows no single target."""
    assert go("watch film.mkv -o seen.csv")[0] in (0, 4)
    assert go(f"{TRACK} -o rows.csv")[0] == 0
    Path("seen.csv").write_text(Path("rows.csv").read_text())
    for line in ("check film.mkv seen.csv", "refine film.mkv seen.csv --at 25=70,20,20,20"):
        assert go(line)[0] == 0


def objects(count: int = FRAMES) -> str:
    """Return rows of two objects with names, of which one walks over the line."""
    lines = ["frame,time,id,label,left,top,width,height,confidence,status,occluded_by"]
    for index in range(count):
        time = f"{index / 25:.6f}"
        lines.append(f"{index},{time},1,car,{20 + 2 * index},20,20,20,0.9,tracking,")
        lines.append(f"{index},{time},2,,90,2,9,12,0.9,tracking,")
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("rest", [0, 3])
def test_who_is_sought_when_the_film_ends_is_not_gone(go: Tell, rest: int) -> None:
    """Rows that end earlier are of who is gone, as in the run that made them."""
    text = objects(FRAMES - rest).splitlines()
    text[-2:] = [line.replace("tracking", "lost") for line in text[-2:]]
    Path("rows.csv").write_text("\n".join(text) + "\n")
    zone = Zone((5, 5, 85, 5, 85, 50, 5, 50), "hall")
    with open_source("film.mkv") as film:
        given = rows_in(Path("rows.csv"), None, film, "film.mkv", None, None)
        counter = EventCounter(Regions(zone=(zone,)), (film.width, film.height))
        *_, last = object_moments(film, given, counter, None, iter(film))
    assert (last.totals["hall enters"], last.totals["hall leaves"]) == (1, rest > 0)


@pytest.mark.slow
def test_objects_are_drawn_with_their_names_lines_and_speeds(
    go: Tell, monkeypatch: pytest.MonkeyPatch
) -> None:
    said = list[str]()

    def heard(pixels: np.ndarray, tracks: object, *others: object) -> np.ndarray:
        said.extend(str(each) for each in others)
        return pixels

    assert go("watch film.mkv -o objects.csv --line 50,0,50,59 --scale 10")[0] in (0, 4)
    Path("objects.csv").write_text(objects())
    go.says("draw film.mkv objects.csv -o drawn.mkv --figures figures", 0, "objects.slit.png")
    assert all(changed("drawn.mkv"))
    assert {path.name for path in Path("figures").iterdir()} == {
        "objects.heatmap.png", "objects.paths.png", "objects.slit.png",
    }  # fmt: skip
    monkeypatch.setattr("motes.cli.annotated_video.draw_scene", heard)
    assert go("draw film.mkv objects.csv -o again.mkv")[0] == 0
    assert any("line 1" in text for text in said)
    assert any("'5.00 m/s'" in text.replace("{1: ", "") for text in said)
    assert not any("-1" in text for text in said)


def test_speeds_of_rows_without_times_are_by_those_of_the_film(go: Tell, said: list[str]) -> None:
    """A film's frames come half as often from its middle on, as of a phone in the dark."""
    times = np.cumsum([0.0] + [0.04] * 14 + [0.08] * 15)
    write_pictures("dark.mkv", [np.full((60, 120, 3), 90, np.uint8)] * 30, times=times.tolist())
    boxes = (f"{n + 1},1,{20 + 50 * time:.2f},20,9,9,1\n" for n, time in enumerate(times))
    Path("rows.txt").write_text("".join(boxes))
    assert go("draw dark.mkv rows.txt -o drawn.mkv --scale 10")[0] == 0
    np.testing.assert_allclose([float(text.split()[-2]) for text in said], 5, rtol=0.01)


def test_what_has_no_identity_has_no_speed(go: Tell, notes: list[Mapping[int, str]]) -> None:
    boxes = (f"{n + 1},-1,{x + 2 * n},20,9,9,1\n" for n in range(9) for x in (10, 60))
    Path("det.txt").write_text("".join(boxes))
    assert go("draw film.mkv det.txt -o drawn.mkv --scale 10")[0] == 0
    assert notes == [{}] * FRAMES


def test_a_box_smaller_than_a_pixel_is_drawn(go: Tell) -> None:
    Path("rows.csv").write_text(
        "frame,id,left,top,width,height\n0,1,7.6,8.6,0.3,0.3\n0,2,20,20,9,9\n"
    )
    go.says("draw film.mkv rows.csv -o drawn.mkv", 0, f"{FRAMES} frames; wrote drawn.mkv")


def test_the_speed_of_one_of_several_is_drawn_when_it_was(
    go: Tell, notes: list[Mapping[int, str]]
) -> None:
    """A box gets ever faster; where the edge cuts it, it has the speed of before."""
    lines = ["frame,time,id,left,top,width,height,confidence,status"]
    for index in range(FRAMES):
        left, time = 50 + 0.08 * index**2, f"{index / 25:.6f}"
        lines.append(f"{index},{time},1,{left:.3f},20,{min(20, 119 - left):.3f},20,0.9,tracking")
        lines.append(f"{index},{time},2,90,2,9,12,0.9,tracking")
    Path("plain.csv").write_text("\n".join(lines) + "\n")
    assert go("convert plain.csv metres.csv --scale 1")[0] == 0
    true, cut = 0.16 * 25 * np.arange(FRAMES), 24  # from there on less than a pixel is beside it
    for line in ("plain.csv --scale 1", "metres.csv"):
        notes.clear()
        assert go(f"draw film.mkv {line} -o drawn.mkv --overwrite")[0] == 0
        other, speeds = ([float(each[name].split()[0]) for each in notes] for name in (2, 1))
        np.testing.assert_allclose(other, 0, atol=1e-9)
        np.testing.assert_allclose(speeds[8 : cut - 8], true[8 : cut - 8], rtol=0.02)
        assert len({*speeds[cut:]}) == 1
        assert speeds[-1] == pytest.approx(true[cut], rel=0.2)
    code, said_too = go("draw film.mkv metres.csv -o drawn.mkv --overwrite --scale 9")
    message = "--scale is for rows without metres, and metres.csv has them; omit it."
    assert (code, message in said_too) == (2, True), said_too


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with rows of a film, faulty ones, and films that are not theirs."""
    folder = tmp_path_factory.mktemp("bad")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        make_film()
        write_pictures("small.mkv", [np.zeros((40, 40, 3), np.uint8)] * FRAMES)
        write_pictures("short.mkv", [picture(20)] * 9)
        write_pictures("slow.mkv", [picture(20)] * FRAMES, 10)
        assert main(f"{TRACK} -o rows.csv".split()) == 0
        text = Path("rows.csv").read_text()
        Path("alone.csv").write_text(text)
        Path("nan.csv").write_text(text.replace("tracking", "flying"))
        Path("damaged.csv").write_text(text)
        Path("damaged.csv.run.json").write_text(json.dumps({"form": 2}))
        Path("empty.csv").write_text("")
        Path("objects.csv").write_text(objects())
        assert main(["convert", "rows.csv", "boxes.json"]) == 0
    return folder


@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        ("draw film.mkv rows.csv", 2, "Nothing is to be made"),
        ("draw 0 rows.csv -o a.mkv", 2, "read once"),
        ("draw rows.csv film.mkv -o a.mkv", 2, "rows.csv and film.mkv seem to be exchanged"),
        ("check rows.csv film.mkv", 2, "rows.csv and film.mkv seem to be exchanged"),
        ("refine rows.csv film.mkv --at 3=1,2,9,9", 2, "film.mkv seem to be exchanged"),
        ("draw film.mkv rows.csv -o film.mkv", 2, "is the source"),
        ("draw small.mkv rows.csv -o a.mkv", 3, "but the rows are of film.mkv, with 120x60"),
        ("draw small.mkv boxes.json -o a.mkv", 3, "boxes.json is of a film of 120x60 pixels, not"),
        ("draw short.mkv alone.csv -o a.mkv", 3, "rows up to frame 29, but short.mkv ends with"),
        ("draw slow.mkv alone.csv -o a.mkv", 3, "has frame 1 at 0.04 s, but slow.mkv at 0.1 s"),
        ("draw slow.mkv alone.csv --figures a --scale 9", 3, "at 0.04 s, but slow.mkv at 0.1 s"),
        ("draw slow.mkv alone.csv --masks a", 3, "has frame 1 at 0.04 s, but slow.mkv at 0.1 s"),
        ("draw film.mkv nan.csv -o a.mkv", 3, "nan.csv"),
        ("draw film.mkv damaged.csv -o a.mkv", 3, "damaged.csv.run.json"),
        ("draw film.mkv empty.csv -o a.mkv", 3, "empty.csv is empty"),
        ("draw film.mkv objects.csv --masks a", 2, "one target; choose one with --identity N."),
        ("draw film.mkv objects.csv --scale 9 --figures a", 2, "--scale is for rows of one target"),
    ],
)
def test_bad_input_is_one_line(
    go: Tell, bad: Path, monkeypatch: pytest.MonkeyPatch, line: str, code: int, message: str
) -> None:
    monkeypatch.chdir(bad)
    before = {*bad.iterdir()}
    assert len(go.says(line, code, message).splitlines()) == 1
    assert {*bad.iterdir()} == before


def test_times_of_a_damaged_film_are_those_of_its_decoded_frames(
    go: Tell, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where its packets have others, as of frames that cannot be decoded."""
    assert go(f"{TRACK} -o rows.csv")[0] == 0
    index = Decoder.index

    def longer(self: Decoder) -> list[tuple[float, bool]] | None:
        stamps = index(self)
        return stamps and [(stamp * 2, key) for stamp, key in stamps]

    monkeypatch.setattr(Decoder, "index", longer)
    assert go("draw film.mkv rows.csv -o a.mkv")[0] == 0
