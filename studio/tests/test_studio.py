"""The studio from end to end, without a browser."""

import io
import json
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx
import msgspec
import numpy as np
import pyarrow.parquet
import pytest
from PIL import Image

from clips import clip, write_pictures
from motes import Ellipse, SourceError, Status, Track
from motes.cli import main
from motes.formats import registry
from motes.rows import FrameRow, Header
from motes.video import Film, Seeker
from motes_studio import exports, messages, pictures
from motes_studio.command import networks_of
from motes_studio.safety import Limits
from motes_studio.scenes import ScenePart
from onnx_trackers import save_pair
from recordings import crowd
from studios import BOX, FRAMES, SLOW, Page, begin, film, looking, running

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("films")
    film(path / "film.mkv")
    return path


@pytest.fixture(scope="module")
def client(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    with running(folder, tmp_path_factory.mktemp("data")) as client:
        yield client


@pytest.fixture(scope="module")
def session(client: httpx.Client) -> str:
    return begin(client)


@pytest.fixture
def page(client: httpx.Client, session: str) -> Iterator[Page]:
    with looking(client, session) as page:
        for each in page.session.objects:
            page.do("remove_object", object=each.object)
        yield page


def moved(dx: float) -> tuple[float, ...]:
    return (BOX[0] + dx, *BOX[1:])


LABELS = b"0 0.5 0.5 0.1 0.1\n0 0.2 0.2 0.1 0.1\n"
"""Two boxes of a frame, as YOLO has them."""


def zipped(files: dict[str, bytes]) -> bytes:
    """Return files as ZIP."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return out.getvalue()


def table(count: int) -> bytes:
    """Return rows as Parquet, which needs hardly a byte for each."""
    out, zeros = io.BytesIO(), np.zeros(count, np.int64)
    pyarrow.parquet.write_table(pyarrow.table({"frame": zeros, "x": zeros}), out)
    return out.getvalue()


def crowded(count: int) -> bytes:
    """Return rows of as many objects in one frame."""
    lines = (f"0,0,{identity},5,5,9,9" for identity in range(count))
    return "\n".join(["frame,time,id,left,top,width,height", *lines, ""]).encode()


class Both:
    """A session, and the command line beside it: in the folder of the films.

    Attributes
    ----------
    at
        Where files go.
    """

    def __init__(self, client: httpx.Client, session: str, page: Page, at: Path) -> None:
        self.page, self.at = page, at
        self._client, self._address = client, f"/api/sessions/{session}"

    def get(self, what: str, **options: str | int) -> httpx.Response:
        """Ask for something of the session."""
        answer = self._client.get(f"{self._address}/{what}", params=dict(options))
        assert answer.status_code == 200, answer.text
        return answer

    def exported(self, number: int, form: str = "csv") -> bytes:
        """Return the rows of an object."""
        return self.get("export", format=form, object=number).content

    def taken(self, number: int) -> Path:
        """Write the rows of an object and their history."""
        rows = self.at / "rows.csv"
        rows.write_bytes(self.exported(number))
        history = self.exported(number, "corrections")
        rows.with_name("rows.csv.run.json").write_bytes(history)
        return rows

    def repeated(self, number: int, output: str, *label: str) -> bytes:
        """Run the command line that the studio shows, with a label, and return its rows."""
        found = self.get("command", object=number).json()
        for name, text in found["files"].items():
            (self.at / name).write_text(text)
        words = found["command"].split()
        assert words[:3] == ["motes", "track", "film.mkv"]
        words = [str(self.at / word) if word in found["files"] else word for word in words]
        assert main([*words[1:-1], str(self.at / output), *label]) == 0
        return (self.at / output).read_bytes()


@pytest.fixture
def both(
    client: httpx.Client,
    session: str,
    page: Page,
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Both:
    monkeypatch.chdir(folder)
    return Both(client, session, page, tmp_path)


FORMS = {"csv": "rows.csv", "jsonl": "rows.jsonl", "coco": "rows.json", "mot": "rows.txt",
         "cvat": "rows.xml", "vot": "rows.vot.txt"}  # fmt: skip


def test_rows_are_those_of_the_command_line(both: Both) -> None:
    page = both.page
    number = page.drawn(frame=10, preset="nummiaro", seed=3)
    page.tracked(number)
    page.settle()
    for form, name in FORMS.items():
        label = ["--label", "disk"] * (form in ("coco", "cvat"))  # the name of the object
        assert both.exported(number, form) == both.repeated(number, name, *label), form
    page.do("set_keyframe", object=number, frame=25, region=moved(2))
    page.do("set_absent", object=number, first=30, last=33)
    assert "make again" in str(page.ask("redo").error)
    page.settle()
    assert both.exported(number) == both.repeated(number, "corrected.csv")
    history = json.loads(both.exported(number, "corrections"))
    command = json.loads((both.at / "corrected.csv.run.json").read_bytes())
    assert command.pop("lines") == FRAMES + 1  # which the studio exports without the rows
    assert history.pop("lines") is None
    assert history == command


def test_refined_rows_are_those_of_the_command_line(both: Both) -> None:
    page = both.page
    number = page.drawn()
    page.tracked(number)
    rows = both.taken(number)
    assert main(["refine", "film.mkv", str(rows), "--at", f"20={','.join(map(str, BOX))}"]) == 0
    page.do("set_keyframe", object=number, frame=20, region=BOX)
    page.settle()
    assert rows.read_bytes() == both.exported(number)


def test_the_particles_of_a_frame_are_shown_again(
    client: httpx.Client, session: str, both: Both
) -> None:
    page = both.page
    number = page.drawn(preset="maggio")
    page.tracked(number)
    answer = both.get("overlays/5", object=number)
    found = msgspec.json.decode(answer.content, type=messages.Overlay)
    assert (found.object, found.frame) == (number, 5)
    assert len(found.particles) == len(found.weights) == 150
    assert max(found.weights) == 1
    later = page.do("split", object=number, frame=20).object
    page.settle()
    asked = client.get(f"/api/sessions/{session}/overlays/5?object={later}")
    assert asked.json()["error"] == "Frame 5 is not of the object, which has 20 to 39."


def test_doubts_are_those_of_motes_check(both: Both) -> None:
    page = both.page
    number = page.drawn(preset="nummiaro")
    page.tracked(number)
    table = both.at / "doubts.csv"
    assert main(["check", "film.mkv", str(both.taken(number)), "-o", str(table)]) == 0
    theirs = [int(line.split(",")[1]) for line in table.read_text().splitlines()[1:]]
    assert [each["frame"] for each in both.get("doubts", object=number).json()] == theirs


def test_watched_objects_are_those_of_the_command_line(both: Both) -> None:
    page, at = both.page, both.at
    ground = [[0, 0, 0, 0], [95, 0, 4, 0], [95, 79, 4, 3], [0, 79, 0, 3]]
    door = {"points": [48, 0, 48, 80], "name": "door"}
    page.do("set_places", places={"lines": [door], "zones": [], "ground": ground})
    page.do("watch", seed=2)
    page.settle()
    page.until(lambda: sum(len(each.frames) for each in page.of(messages.FoundScene)) == FRAMES)
    found = both.get("command").json()
    for name, text in found["files"].items():
        (at / name).write_text(text)
    words = [
        str(at / word) if word.endswith((".toml", ".csv", ".jsonl")) else word
        for word in found["command"].split()
    ]
    assert main(words[1:]) in (0, 4)
    assert both.get("export", scene=1, format="csv").content == (at / "rows.csv").read_bytes()
    events = both.get("export", scene=1, format="events").content
    lines = (at / "events.jsonl").read_bytes().splitlines()
    assert [*map(msgspec.json.decode, events.splitlines())] == [*map(msgspec.json.decode, lines)]
    steep = [[20, 70, 0, 0], [75, 70, 4, 0], [60, 60, 4, 30], [40, 60, 0, 30]]
    page.do("set_places", places={"lines": [], "zones": [], "ground": steep})
    job = page.do("watch").job
    page.settle()
    assert "such rows have no metres" in str(page.jobs[job or 0].note)


def cells(data: bytes) -> list[list[str]]:
    """Return the fields of rows."""
    return [line.split(",") for line in data.decode().splitlines()]


def test_rows_come_back_from_a_file(client: httpx.Client, session: str, both: Both) -> None:
    page = both.page
    number = page.drawn(preset="nummiaro")
    page.tracked(number)
    data = both.exported(number)
    answer = client.post(f"/api/sessions/{session}/import?name=mine.csv", content=data)
    assert answer.status_code == 201, answer.text
    (new,), left_out = answer.json()["objects"], answer.json()["left_out"]
    assert left_out == []
    page.until(lambda: any(each.object == new for each in page.session.objects))
    page.settle()
    # The sides of a box are those of the ellipse in the rows.
    assert [row[:4] + row[8:] for row in cells(both.exported(new))] == [
        row[:4] + row[8:] for row in cells(data)
    ]
    page.do("set_keyframe", object=new, frame=20, region=BOX)
    page.settle()
    head = msgspec.json.encode(Header("film.mkv", 0, 0, "car"))
    lines = [msgspec.json.encode(row.to_dict()) for row in [*crowd()][:3]]
    kept = b"\n".join([head, *lines, b'{"frame"'])
    answer = client.post(f"/api/sessions/{session}/import?name=killed.rows.jsonl", content=kept)
    assert answer.status_code == 201, answer.text
    cut, outside = answer.json()["left_out"]
    assert cut == "the last line, which is cut off"
    assert "of 96x80 has nothing of 3 of its 6 boxes" in outside  # its film is larger
    bad = client.post(f"/api/sessions/{session}/import?name=x.csv", content=b"\x00nothing")
    assert bad.status_code == 400
    assert "no text" in bad.json()["error"]


def test_every_format_that_is_written_is_read_back(
    client: httpx.Client, session: str, both: Both
) -> None:
    page = both.page
    number = page.drawn(preset="mean_shift")
    page.do("set_keyframe", object=number, frame=20, region=BOX)
    page.do("set_absent", object=number, first=30, last=33)
    page.tracked(number)
    names = set[str]()
    for form in client.get("/api/formats").json()["write"]:
        answer = both.get("export", format=form, object=number)
        name = answer.headers["content-disposition"].partition("''")[2]
        assert name not in names
        names.add(name)
        address = f"/api/sessions/{session}/import"
        back = client.post(address, params={"name": name}, content=answer.content)
        if registry.FORMATS.usable()[form].read is None:
            why = "it has no labels" if form == "masks" else "is only written"
            assert why in back.json()["error"]
            continue
        assert back.status_code == 201, (form, back.text)
        (new,) = back.json()["objects"]
        page.until(lambda new=new: page.has(new))  # type: ignore[misc]
        item = page.item(new)
        assert item.tracked is (form != "keyframes")
        note = both.get("command", object=new).json()["note"]
        assert note.startswith("Rows of this object are from a file") is item.tracked
        if form == "keyframes":
            assert len(item.keyframes) > 1
            assert (item.first, item.last, item.absent) == (0, FRAMES - 1, ((30, 33),))
        if form not in ("csv", "jsonl", "parquet"):  # whose corrections are from ellipses
            assert {len(each.region) for each in item.keyframes} == {len(BOX)}, form
        page.do("remove_object", object=new)


def test_upright_ellipses_of_a_file_stay_ellipses(
    client: httpx.Client, session: str, both: Both
) -> None:
    file = '<annotations><track id="0" label="a"><ellipse frame="0" cx="40" cy="40" rx="9" ry="5"/>'
    file += '</track><track id="1" label="b"><box frame="0" xtl="30" ytl="30" xbr="50" ybr="40"/>'
    keyframes = "frame,x,y,a,b,theta\n0,40,40,9,5,0\n"
    for name, text in (("a.xml", f"{file}</track></annotations>"), ("k.csv", keyframes)):
        answer = client.post(f"/api/sessions/{session}/import?name={name}", content=text)
        assert answer.status_code == 201, answer.text
        numbers = answer.json()["objects"]
        both.page.until(lambda numbers=numbers: all(map(both.page.has, numbers)))  # type: ignore[misc]
        found = [len(both.page.item(each).keyframes[0].region) for each in numbers]
        assert found == [5, 4][: len(numbers)]


def test_objects_of_a_file_keep_their_classes_and_get_no_other(
    client: httpx.Client, session: str, both: Both
) -> None:
    def back(*rows: str) -> tuple[list[str], set[str]]:
        """Return the names of the objects of a file, and the classes of an export."""
        lines = ["frame,id,left,top,width,height,label", *rows, ""]
        address = f"/api/sessions/{session}/import?name=street.csv"
        answer = client.post(address, content="\n".join(lines))
        assert answer.status_code == 201, answer.text
        names, new = [], answer.json()["objects"]
        for each in new:
            both.page.until(lambda each=each: both.page.has(each))  # type: ignore[misc]
            names.append(both.page.item(each).name)
        one = {"object": new[0]} if len(new) == 1 else {}
        document = both.get("export", format="coco", **one)
        for each in new:
            both.page.do("remove_object", object=each)
        return names, {each["name"] for each in document.json()["categories"]}

    (name,), classes = back("0,4,5,5,9,9,", "1,4,6,5,9,9,")
    assert (exports.DEFAULT_NAME.fullmatch(name) is not None, classes) == (True, {"object"})
    assert back("0,4,5,5,9,9,car") == (["car"], {"car"})
    several = back("0,4,5,5,9,9,car", "0,7,25,5,9,9,")
    assert several == (["car (4)", "object (7)"], {"car", "object"})
    assert back("0,-1,5,5,9,9,car", "0,7,25,5,9,9,") == (["car", "object (7)"], {"car", "object"})


def test_a_frame_that_a_file_does_not_have_is_no_example_without_objects(
    client: httpx.Client, session: str, both: Both
) -> None:
    """Of frame 1 the file tells that the first object is not there; of frame 2, nothing."""
    lines = ["frame,id,left,top,width,height"]
    lines += [f"{frame},{who},5,5,9,9" for frame, who in ((0, 4), (0, 7), (1, 7), (3, 4), (3, 7))]
    address = f"/api/sessions/{session}/import?name=gap.csv"
    first, _ = client.post(address, content="\n".join([*lines, ""])).json()["objects"]
    with zipfile.ZipFile(io.BytesIO(both.get("export", format="yolo").content)) as archive:
        labels = [name for name in archive.namelist() if name.startswith("labels/")]
    assert labels == [f"labels/frame_{frame:06}.txt" for frame in (0, 1, 3)]
    both.page.until(lambda: 3 in both.page.rows.get(first, {}))
    states = [both.page.rows[first][frame].status for frame in range(4)]
    assert states == ["tracking", "absent", "lost", "tracking"]


def test_rows_that_are_known_are_of_a_tracked_object(both: Both) -> None:
    """An export took an object whose rows were shown, and the page had said that it left it out."""
    page = both.page
    page.tracked(page.drawn(preset="nummiaro", seed=77))
    again = page.drawn(preset="nummiaro", seed=77)
    assert page.item(again).tracked
    for preset, tracked in (("mean_shift", False), ("nummiaro", True)):
        page.do("change_object", object=again, preset=preset)
        assert page.item(again).tracked is tracked
        assert both.get("export", format="csv").text.count("\n") == 1 + FRAMES * (1 + tracked)


def test_objects_that_begin_alike_have_rows_of_their_own(
    client: httpx.Client, session: str, both: Both
) -> None:
    """As a truth and the results of a tracker, which begin with the same box."""
    page = both.page
    numbers = [page.drawn(preset="default")]
    page.tracked(*numbers)
    files = [both.get("export", format="mot", object=numbers[0]).text]
    address = f"/api/sessions/{session}/import?name=a.txt&format=mot"
    for right in (20, 5):
        lefts = [31, *[31 + right] * (FRAMES - 1)]  # pixels are counted from 1
        lines = [
            f"{n},1,{left}.00,26.00,30.00,40.00,1.0000,1,1,-1\n" for n, left in enumerate(lefts, 1)
        ]
        files.append("".join(lines))
        numbers += client.post(address, content=files[-1]).json()["objects"]
    assert [both.get("export", format="mot", object=each).text for each in numbers] == files
    page.until(lambda: all(FRAMES - 1 in page.rows.get(each, {}) for each in numbers))
    assert [page.rows[each][1].x for each in numbers[1:]] == [64.5, 49.5]


def test_rows_of_a_file_stay_unless_a_keyframe_asks_for_others(
    client: httpx.Client, session: str, both: Both
) -> None:
    """A split, a join or the mark of one absence tracked all of them again."""
    page = both.page
    address = f"/api/sessions/{session}/import?name=a.txt&format=mot"

    def brought(frames: range) -> int:
        lines = [f"{t + 1},1,{20 + t}.00,26.00,30.00,40.00,1.0000,1,1,-1\n" for t in frames]
        (number,) = client.post(address, content="".join(lines)).json()["objects"]
        return int(number)

    def places(number: int) -> dict[int, float | None]:
        page.settle()
        return {frame: row.x for frame, row in page.rows[number].items()}

    def lying(frames: range) -> dict[int, float | None]:
        return {t: 33.5 + t for t in frames}

    one = brought(range(FRAMES))
    page.until(lambda: page.has(one))
    assert page.item(one).imported
    page.do("set_absent", object=one, first=7, last=8)
    two = page.do("split", object=one, frame=20).object or 0
    assert places(one) == {**lying(range(20)), 7: None, 8: None}
    assert places(two) == lying(range(20, FRAMES))
    page.do("remove_keyframe", object=one, frame=7)
    page.do("join", object=one, other=two)
    assert places(one) == {**lying(range(FRAMES)), 8: None}
    late = brought(range(25, FRAMES))
    early = brought(range(22))
    page.do("join", object=early, other=late)
    between = dict.fromkeys(range(22, 25))
    assert places(early) == {**lying(range(FRAMES)), **between}
    assert {page.rows[early][t].status for t in between} == {"lost"}
    number = page.drawn(frame=30, seed=81)
    refused = page.ask("join", object=early, other=number).error
    assert refused is not None
    assert "is not tracked to its end; track it first" in refused
    page.do("set_keyframe", object=one, frame=20, region=BOX)
    page.settle()
    assert page.rows[one][19].x != 33.5 + 19
    page.do("undo")
    assert places(one) == {**lying(range(FRAMES)), 8: None}


BAD_FILES = (
    ("a.zip", zipped({"1.txt": LABELS, "2.txt": LABELS}), "several boxes"),
    ("a.zip", zipped({"1.txt": bytes(1 << 21)}), "more than"),
    ("a.zip", zipped({})[:-4] + b"....", "a.zip: it is no text"),
    ("a.zip", zipped({"1.txt": b"1"})[:-30], "make the ZIP anew"),
    ("a.zip", zipped({"a/" * 99 + "1.txt": LABELS}), "folders in folders, too many"),
    ("a.dat", b"what is it", "format of a.dat is not clear"),
    ("a.csv", b"5,500,2,3,4\n", "Keyframe 5 of film.mkv"),
    ("a-csv", b"frame,time,left,top,width,height\n", "a-csv ends neither in .csv nor in"),
    ("b.csv.run.json", b'{"form": 2}', "b.csv.run.json is the history beside rows;"),
    ("a.parquet", table(10**6), "a.parquet holds 15 MB of rows, more than 1 MB"),
    ("a.csv", crowded(51), "has 51 objects, and a session has 50 at most"),
)
"""Files that sessions refuse; those that no reader takes are tested with the readers."""


def test_what_cannot_be_imported_is_one_line(folder: Path, tmp_path: Path) -> None:
    with running(folder, tmp_path, limits=Limits(imported=1 << 20)) as client:
        address = f"/api/sessions/{begin(client)}/import"
        for name, content, words in BAD_FILES:
            answer = client.post(address, params={"name": name}, content=content)
            assert answer.status_code == 400
            error = answer.json()["error"]
            assert words in error
            assert error.count(name) <= 1
            assert error.count(";") <= 1
            assert tempfile.gettempdir() not in error


def test_films_of_one_and_of_several_objects_are_made(both: Both) -> None:
    page = both.page
    number = page.drawn(preset="nummiaro")
    page.tracked(number)
    assert both.get("film", object=number).content[4:8] == b"ftyp"
    page.drawn(name="other")
    page.tracked()
    assert both.get("film").content[4:8] == b"ftyp"
    rows = both.get("export", format="csv").content.decode().splitlines()
    assert len(rows) == 1 + 2 * FRAMES
    assert both.get("export", format="yolo").content.startswith(b"PK")


def test_pictures(client: httpx.Client, session: str) -> None:
    for index in (0, FRAMES - 1, 3, 4):
        answer = client.get(f"/api/sessions/{session}/frames/{index}.jpg?width=48")
        assert answer.headers["content-type"] == "image/jpeg"
    again = client.get(
        f"/api/sessions/{session}/frames/4.jpg?width=48",
        headers={"If-None-Match": answer.headers["etag"]},
    )
    assert again.status_code == 304
    beyond = client.get(f"/api/sessions/{session}/frames/{FRAMES}.jpg")
    assert beyond.status_code == 400
    assert str(FRAMES - 1) in beyond.json()["error"]
    assert client.get(f"/api/sessions/{session}/strip?count=5").status_code == 200


def test_a_short_film_has_thumbnails_of_its_own_frames(tmp_path: Path) -> None:
    """It may have one key picture, which stood in the whole strip."""
    film = Film.quickly(clip(tmp_path / "film.mp4", 30))
    place: Any = SimpleNamespace(film=film, seeker=Seeker(film))
    strip = Image.open(io.BytesIO(pictures.strip(place, 3, 48)))
    first, _, last = np.array_split(np.asarray(strip, np.float64), 3, axis=1)
    assert np.abs(first - last).mean() > 20


def test_what_is_not_tracked_to_its_end_is_said_or_left_out(
    client: httpx.Client, session: str, both: Both
) -> None:
    page, address = both.page, f"/api/sessions/{session}/export"
    number = page.drawn(preset="nummiaro", config=SLOW)
    assert "track one first" in client.get(address).json()["error"]
    page.do("set_absent", object=number, first=1, last=2)
    job = page.do("track").job
    page.until(lambda: 3 in page.rows.get(number, {}))
    for options in ({}, {"object": number}):
        assert "is being tracked; wait" in client.get(address, params=options).json()["error"]
    page.do("stop", job=job)
    page.until(lambda: page.of(messages.Progress)[-1].status == "stopped")
    rows = [line.split(",") for line in both.exported(number).decode().splitlines()]
    states = [row[rows[0].index("status")] for row in rows[1:]]
    assert states[:3] == ["tracking", "absent", "absent"]
    whole = page.drawn(name="whole")
    page.tracked(whole)
    assert both.get("export").content == both.exported(whole)


def test_a_configuration_names_the_networks_of_the_owner_alone(
    folder: Path, tmp_path: Path
) -> None:
    """Files that are there, empty or missing are not told apart, and none of them is read."""
    files, others = save_pair(tmp_path), ("/etc/passwd", "/dev/null", "/nowhere", "head.onnx")
    with running(folder, tmp_path / "data", limits=Limits(networks=files)) as client:
        session = begin(client)
        with looking(client, session) as page:
            alone = page.drawn(preset="default")
            given = {"preset": "default", "name": "x", "color": "#000000", "frame": 0}
            asked = [
                page.ask(kind, config=f"network.files = {json.dumps([*files[:1], other])}", **more)
                for other in others
                for kind, more in (("add_object", {**given, "region": BOX}),
                                   ("change_object", {"object": alone}))
            ]  # fmt: skip
            (said,) = {each.error for each in asked}
            assert "motes studio --network" in str(said)
            number = page.drawn(preset="default", config=f"network.files = {json.dumps(files)}")
            page.tracked(number, alone)
            assert page.rows[alone] != page.rows[number]


def test_networks_of_a_folder(tmp_path: Path) -> None:
    with pytest.raises(SourceError, match="no files"):
        networks_of(str(tmp_path))
    files = save_pair(tmp_path)
    assert networks_of(str(tmp_path)) == tuple(sorted(files))
    assert networks_of(",".join(files)) == files


def test_presets_and_formats(client: httpx.Client) -> None:
    presets = client.get("/api/presets").json()
    assert {"default", "nummiaro"} <= {each["name"] for each in presets["track"]}
    assert "default" not in {each["name"] for each in presets["watch"]}
    formats = client.get("/api/formats").json()
    assert {*formats["write"]} - {*formats["read"]} == {"masks", "deeplabcut"}
    assert {*formats["read"]} - {*formats["write"]} == {"journal", "lasot", "got10k"}


def test_a_folder_of_images_goes_out_and_comes_back(tmp_path: Path) -> None:
    """Labels and documents have the names of the images, from which others know them."""
    names = [f"img_{10 * frame:04d}" for frame in range(1, 4)]
    (tmp_path / "films/img").mkdir(parents=True)
    for name in names:
        Image.effect_noise((96, 80), 60).convert("RGB").save(tmp_path / f"films/img/{name}.png")
    with running(tmp_path / "films", tmp_path / "data") as client:
        session = begin(client, "img")
        with looking(client, session) as page:
            page.tracked(page.drawn())
        files = {form: client.get(f"/api/sessions/{session}/export", params={"format": form})
                 for form in ("yolo", "coco")}  # fmt: skip
        with zipfile.ZipFile(io.BytesIO(files["yolo"].content)) as archive:
            assert {f"labels/{name}.txt" for name in names} <= {*archive.namelist()}
        images = files["coco"].json()["images"]
        assert [each["file_name"] for each in images] == [f"{name}.png" for name in names]
        address, data = f"/api/sessions/{session}/import", files["yolo"].content
        answer = client.post(address, params={"name": "a.zip"}, content=data)
        assert answer.status_code == 201, answer.text
        with looking(client, session) as page:
            drawn, back = (page.item(each) for each in (1, *answer.json()["objects"]))
            assert (back.first, back.last) == (drawn.first, drawn.last) == (0, 2)


@pytest.mark.parametrize(
    ("wanted", "hidden", "begin"),
    [(False, [False, True, False], b"1 guess marked "), (True, [False, False, False], b"")],
)
def test_a_guess_is_exported_as_seen_for_who_wants_it(
    tmp_path: Path, wanted: bool, hidden: list[bool], begin: bytes
) -> None:
    states = [Status.TRACKING, Status.INTERPOLATED, Status.TRACKING]
    said = exported(tmp_path / "n.json", states, guesses=wanted)
    annotations = json.loads((tmp_path / "n.json").read_bytes())["annotations"]
    found = [each["attributes"]["occluded"] for each in annotations]
    assert (found, said[:15]) == (hidden, begin)


def test_frames_that_a_format_leaves_out_are_told(tmp_path: Path) -> None:
    states = [Status.TRACKING, Status.INTERPOLATED, Status.LOST, Status.LOST]
    said = exported(tmp_path / "n.json", states)
    assert len(json.loads((tmp_path / "n.json").read_bytes())["images"]) == 2
    assert said.startswith(b"without 2 frames in which a target is lost or searched for; 1 guess ")


def test_label_studio_is_told_the_rate_of_the_film(tmp_path: Path) -> None:
    said = exported(tmp_path / "n.ls.json", [Status.TRACKING], "label-studio")
    assert said.startswith(b'Label Studio has a rate of its own; give its tag Video framerate="$fp')


def exported(
    path: Path, states: list[Status], form: str = "coco", *, guesses: bool = False
) -> bytes:
    """Write an object with these states in a format, and return what is said."""
    there = Ellipse(50, 40, 9, 9, 0)
    rows = [
        FrameRow(i, i / 25, (Track(i, i / 25, there, confidence=0.9, status=state),)).to_dict()
        for i, state in enumerate(states)
    ]
    part = msgspec.json.encode(ScenePart(rows, [], 1, {}))
    film = messages.OpenFilm("n.mp4", 320, 240, 3, 25.0)
    place: Any = SimpleNamespace(film=SimpleNamespace(files=()), check=lambda: None)
    return exports.write_scene(place, str(path), form, film, [part], guesses=guesses)


def test_a_region_with_nothing_in_it_is_noted(folder: Path, client: httpx.Client) -> None:
    write_pictures(folder / "wall.mkv", [np.full((80, 96, 3), 90, np.uint8)] * 3)
    for name, noted in (("film.mkv", False), ("wall.mkv", True)):
        with looking(client, begin(client, name)) as page:
            page.tracked(page.drawn())
            (job,) = page.jobs.values()
            assert (job.note is not None) == noted
