"""What the studio refuses: other hosts, paths, playlists, sizes, messages; and films that kill."""

import contextlib
import errno
import logging
import multiprocessing
import os
import signal
import socket
import threading
import time
from collections.abc import AsyncIterator, Callable, Iterator
from functools import partial
from pathlib import Path

import httpx
import pytest
from PIL import Image
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

import loops
from clips import clip
from coded import video
from disks import fill
from motes import FormatError, SourceError
from motes.core import Failed, Worker, WorkerLine
from motes.video import Film
from motes_studio import messages, protocol, serve
from motes_studio.containers import check_container
from motes_studio.film_worker import FilmWorker, WorkerError
from motes_studio.films import Films
from motes_studio.pictures import picture
from motes_studio.safety import COOKIE, Guard, Limits, inside
from motes_studio.studio import Studio
from motes_studio.workplace import limit_process
from studios import SLOW, begin, film, looking, running
from waiting import PATIENCE, wait_until

pytestmark = pytest.mark.slow

PIXELS = 200 * 200


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("films")
    film(path / "film.mkv", frames=12)
    (path / "deep").mkdir()
    film(path / "deep" / "film.mkv", frames=3)
    outside = tmp_path_factory.mktemp("outside")
    film(outside / "secret.mkv", frames=3)
    (path / "link.mkv").symlink_to(outside / "secret.mkv")
    (path / "list.mp4").write_text("#EXTM3U\nhttp://example.org/a.ts\n")
    (path / "concat.mkv").write_text("ffconcat version 1.0\nfile film.mkv\n")
    lines = "v=0", "o=- 0 0 IN IP4 127.0.0.1", "s=x", "c=IN IP4 127.0.0.1", "m=video 9 RTP/AVP 96"
    (path / "sdp.mp4").write_text("\n".join(lines))
    (path / "text.mp4").write_text("no film\n" * 100)
    (path / "notes.txt").write_text("x")
    clip(path / "wide.mp4", frames=2, width=320, height=240)
    clip(path / "long.mp4", frames=60)
    os.mkfifo(path / "pipe.mp4")
    return path


@pytest.fixture(scope="module")
def client(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    limits = Limits(upload=50_000, imported=10_000, pixels=PIXELS, frames=40, sessions=2, jobs=1)
    with running(folder, tmp_path_factory.mktemp("data"), limits=limits) as client:
        yield client


def error(answer: httpx.Response) -> str:
    assert answer.status_code == 400, answer.text
    return str(answer.json()["error"])


@pytest.mark.parametrize("name", ["a.flv", "a.gif", "a.y4m", "a.nut", "a.M2TS"])
def test_films_of_the_command_line_are_listed_and_opened(tmp_path: Path, name: str) -> None:
    codecs = {".flv": "flv", ".y4m": "wrapped_avframe", ".nut": "mpeg4"}
    folder = tmp_path / "films"
    folder.mkdir()
    path = folder / name
    if name == "a.gif":
        pictures = [Image.new("RGB", (32, 24), (50 * i, 0, 0)) for i in range(5)]
        pictures[0].save(path, save_all=True, append_images=pictures[1:])
    else:
        video(path, codecs.get(path.suffix, "mpeg2video"), {}, frames=5)
    films = Films(folder, tmp_path / "uploads", Limits())
    assert [each.name for each in films.listed()] == [name]
    check_container(str(path), Limits())
    assert len(Film(films.path(name, uploaded=False), quick=True).times) == 5


def test_an_animation_alone_is_a_film_and_one_picture_is_none(tmp_path: Path) -> None:
    pictures = [Image.new("RGB", (32, 24), color) for color in ("red", "blue")]
    for folder, count in (("moves", 2), ("rests", 1)):
        (tmp_path / folder).mkdir()
        path = tmp_path / folder / "a.webp"
        pictures[0].save(path, save_all=True, append_images=pictures[1:count])
    films = Films(tmp_path, tmp_path / "uploads", Limits())
    assert [each.name for each in films.listed() if not each.uploaded] == ["moves/a.webp"]


def test_uploads_that_are_damaged_or_many_do_not_end_the_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    films = Films(None, tmp_path, Limits())
    (tmp_path / "a.png").write_bytes(b"")

    def broken(_: Path) -> None:
        raise SyntaxError("broken PNG file")  # as Pillow raises

    monkeypatch.setattr(Image, "open", broken)
    assert films.listed() == []
    monkeypatch.setattr("motes_studio.films.MOST", 1)
    with pytest.raises(FormatError, match="sent already"):
        loops.run(films.upload("b.mp4", 1, _nothing()), PATIENCE)


async def _nothing() -> AsyncIterator[bytes]:
    yield b""


@pytest.mark.parametrize(
    ("name", "word"),
    [
        ("../outside/secret.mkv", "no film"),
        ("/etc/passwd", "no film"),
        ("link.mkv", "no film"),
        ("a\0b", "no film"),
        ("", "no film"),
        ("http://example.org/a.mp4", "no film"),
        ("pipe.mp4", "no plain file"),
        ("notes.txt", "does not end like a film"),
        ("list.mp4", "playlist"),
        ("sdp.mp4", "not a video"),
        ("wide.mp4", "pixels"),
        ("long.mp4", "frames"),
    ],
)
def test_films_are_refused(client: httpx.Client, name: str, word: str) -> None:
    assert word in error(client.post("/api/sessions", json={"film": name}))
    assert name not in {each["film"] for each in client.get("/api/sessions").json()}


def test_devices_and_links_are_refused(tmp_path: Path) -> None:
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "a.png").symlink_to("/dev/zero")
    (tmp_path / "zero.mp4").symlink_to("/dev/zero")
    for name in ("images", "zero.mp4"):
        with pytest.raises(SourceError):
            inside(tmp_path, name)


def test_uploads(client: httpx.Client, tmp_path: Path) -> None:
    data = film(tmp_path / "mine.mkv", frames=5).read_bytes()
    one = client.post("/api/uploads?name=..%2F..%2Fmine.mkv", content=data)
    assert one.json() == {"name": "mine.mkv", "bytes": len(data), "uploaded": True}
    again = client.post("/api/uploads?name=mine.mkv", content=data).json()
    assert again["name"] != "mine.mkv"
    opened = client.post("/api/sessions", json={"film": "mine.mkv", "uploaded": True}).json()
    assert opened["film"]["frames"] == 5
    client.delete(f"/api/sessions/{opened['id']}")
    assert "larger" in error(client.post("/api/uploads?name=x.mp4", content=b"0" * 60_000))
    parts = (b"0" * 10_000 for _ in range(6))
    assert "larger" in error(client.post("/api/uploads?name=x.mp4", content=parts))
    assert "playlist" in error(client.post("/api/uploads?name=x.mp4", content=b"#EXTM3U\n"))
    assert "does not end like a film" in error(
        client.post("/api/uploads?name=x.m3u8", content=b"0")
    )
    assert "name" in error(client.post("/api/uploads", content=b"0"))
    said = error(client.post("/api/sessions", content=b"{"))
    assert said.startswith("The request cannot be read: ")
    names = {each["name"] for each in client.get("/api/films").json() if each["uploaded"]}
    assert names == {"mine.mkv", again["name"]}


def test_other_pages_are_refused(client: httpx.Client) -> None:
    host = client.base_url.netloc.decode()
    for headers in (
        {"Host": "evil.example"},
        {"Origin": "http://evil.example"},
        {"Origin": "null"},
    ):
        assert client.get("/api/films", headers=headers).status_code == 403
        assert client.post("/api/sessions", headers=headers).status_code == 403
    assert client.get("/api/films", headers={"Origin": f"http://{host}"}).status_code == 200
    upgrade = {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"}
    upgrade["Sec-WebSocket-Key"] = "dGhlIHNhbXBsZSBub25jZQ=="
    for foreign in ({"Origin": "http://evil.example"}, {"Host": "evil.example"}):
        answer = client.get("/api/sessions/x/ws", headers=upgrade | foreign)
        assert answer.status_code == 403


def test_all_answers_have_their_headers(client: httpx.Client) -> None:
    for path in ("/", "/api/films", "/nothing", "/static/../../server.py"):
        headers = client.get(path).headers
        policy = headers["content-security-policy"]
        assert "script-src 'self'" in policy
        assert "unsafe" not in policy
        assert headers["x-content-type-options"] == "nosniff"
    assert client.get("/static/..%2fserver.py").status_code == 404


DEEP = "[" * 100_000


@pytest.mark.parametrize(
    "ask",
    [
        lambda client, _: client.get("/api/films", headers={"Origin": "http://["}),
        lambda client, _: client.get("/api/films", headers={"Host": "[::1"}),
        lambda client, _: client.post("/api/sessions", content=f'{{"film":{DEEP}'.encode()),
        lambda client, _: client.post("/api/uploads?name=" + "é" * 190 + ".mp4", content=b"x"),
        lambda client, at: client.post(f"{at}/import?name=..", content=b"x"),
        lambda client, at: client.post(f"{at}/import?name=a%00b", content=b"x"),
        lambda client, at: client.post(f"{at}/import?name=" + "x" * 300, content=b"x"),
        lambda client, at: client.post(f"{at}/import?name=x.json", content=DEEP.encode()),
        lambda client, at: client.get(f"{at}/frames/{'9' * 20}.jpg"),
        lambda client, at: client.get(f"{at}/overlays/{'9' * 20}?object=1"),
        lambda client, at: client.get(f"{at}/doubts?object={'9' * 15}"),
        lambda client, at: client.get(f"{at}/strip?count={'9' * 20}&height={'9' * 20}"),
    ],
    ids=[
        "origin", "host", "nested", "upload", "folder", "nul", "long", "nested file", "digits",
        "overlays", "doubts", "strip",
    ],
)  # fmt: skip
def test_no_request_fails_inside(
    client: httpx.Client, ask: Callable[[httpx.Client, str], httpx.Response]
) -> None:
    session = begin(client)
    assert ask(client, f"/api/sessions/{session}").status_code < 500
    client.delete(f"/api/sessions/{session}")


def test_who_hangs_up_leaves_no_trace(
    folder: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    errors = logging.getLogger("uvicorn.error")
    with running(folder, tmp_path) as client:
        errors.addHandler(caplog.handler)
        place = client.base_url.host, client.base_url.port or 0
        with socket.create_connection(place, PATIENCE) as connected:
            head = b"POST /api/uploads?name=a.mp4 HTTP/1.1\r\nHost: localhost\r\n"
            connected.sendall(head + b"Content-Length: 99\r\n\r\nhalf")
            wait_until(lambda: [*(tmp_path / "uploads").iterdir()])
        wait_until(lambda: not [*(tmp_path / "uploads").iterdir()])
        client.get("/api/films")
    errors.removeHandler(caplog.handler)
    assert not caplog.records


def test_a_studio_without_file_descriptors_says_so(
    client: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def begin(*_: object, **__: object) -> None:
        raise OSError(errno.EMFILE, "Too many open files")

    monkeypatch.setattr(Studio, "begin", begin)
    answer = client.post("/api/sessions", json={"film": "film.mkv"})
    assert answer.status_code == 503
    assert "Too many open files" in answer.json()["error"]


WHOLE = b"GET /nothing HTTP/1.1\r\nHost: localhost\r\n\r\n"


def test_a_head_that_does_not_come_is_closed(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also the second one of a connection, and of somebody who has no token."""
    monkeypatch.setattr(serve, "HEAD", 0.3)
    with running(folder, tmp_path, token="right") as client:
        place = client.base_url.host, client.base_url.port or 0
        for start, drip in ((b"", b""), (b"GET / HTTP/1.1\r\n", b"a"), (WHOLE + b"GET", b"a")):
            with socket.create_connection(place, PATIENCE) as connected:
                connected.sendall(start)
                dripping = threading.Thread(target=drip_into, args=(connected, drip))
                dripping.start()
                with contextlib.suppress(ConnectionError):
                    while connected.recv(4096):
                        pass
                dripping.join()


def drip_into(connected: socket.socket, drip: bytes) -> None:
    with contextlib.suppress(OSError):
        while drip:
            connected.sendall(drip)
            time.sleep(0.1)


def test_connections_are_limited(client: httpx.Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(serve, "CONNECTIONS", 4)
    place = client.base_url.host, client.base_url.port or 0
    with contextlib.ExitStack() as held:
        for _ in range(4):
            held.enter_context(socket.create_connection(place, PATIENCE))
        more = held.enter_context(socket.create_connection(place, PATIENCE))
        with contextlib.suppress(ConnectionError):
            assert more.recv(1) == b""

    def answered() -> bool:
        try:
            return client.get("/api/films").status_code == 200
        except httpx.TransportError:
            return False

    wait_until(answered)


def test_a_token_is_needed(folder: Path, tmp_path: Path) -> None:
    with running(folder, tmp_path, token="right") as client:
        assert client.get("/").status_code == 403
        assert client.get("/api/films").status_code == 403
        assert client.get("/?token=wrong").status_code == 403
        address = str(client.base_url).replace("http", "ws").rstrip("/")
        with pytest.raises(InvalidStatus), connect(f"{address}/api/sessions/x/ws"):
            pass
        answer = client.get("/?token=right")
        assert (answer.status_code, answer.headers["location"]) == (303, "/")
        cookie = answer.headers["set-cookie"].lower()
        assert "samesite=strict" in cookie
        assert "httponly" in cookie
        assert client.cookies[COOKIE] == "right"
        assert client.get("/api/films").status_code == 200


def test_a_sample_film_that_meets_a_full_disk_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    films = Films(None, tmp_path, Limits())
    fill(monkeypatch, "sample-street.mp4", 30_000)
    with pytest.raises(FormatError) as failed:
        films.sample("street")
    text = "sample-street.mp4 cannot be written: No space left on device; make room there."
    assert str(failed.value) == text
    assert [*tmp_path.iterdir()] == []


def test_hosts_are_checked_on_this_computer_alone() -> None:
    assert Guard("127.0.0.1", None).refusal({"host": "evil:80"})
    assert Guard("127.0.0.1", None).refusal({"host": "localhost:80"}) is None
    assert Guard("0.0.0.0", "token").refusal({"host": "lab:80"}) is None
    assert not Guard("0.0.0.0", "token").knows("")
    assert not Guard("0.0.0.0", "token").knows("tökén")


def test_hostile_messages_get_one_line(client: httpx.Client) -> None:
    session = begin(client)
    with looking(client, session) as page:
        for text in (
            "", "nonsense", "[]", "1e999", '{"type":"undo"}', '{"type":"no","id":1}',
            '{"type":"undo","id":-1}', '{"type":"undo","id":1,"more":2}', "[" * 10_000,
            '{"type":"undo","id":1,"more":"' + "x" * protocol.LARGEST_MESSAGE + '"}',
            '{"type":"add_object","id":1,"name":"a","color":"#000000","frame":0,"region":[1,2]}',
            '{"type":"add_object","id":1,"name":"a","color":"url(x)","frame":0,"region":[1,2,3,4]}',
            '{"type":"add_object","id":1,"name":"a","color":"#000000\\n","frame":0,"region":[9,9,9,9]}',
            '{"type":"add_object","id":1,"name":"a","color":"#000000","frame":0,"region":[NaN,2,3,4]}',
            '"' + "x" * protocol.LARGEST_MESSAGE + '"', '{"a":' + DEEP,
        ):  # fmt: skip
            before = len(page.of(messages.Reply))
            page.raw(text)
            page.until(lambda n=before: len(page.of(messages.Reply)) > n)  # type: ignore[misc]
            reply = page.of(messages.Reply)[-1]
            readable = '"id":1' in text and "NaN" not in text  # which is not JSON
            assert reply.id == (1 if readable else protocol.NOBODY), text[:60]
            assert reply.error
            assert "\n" not in reply.error
            assert len(reply.error) < 400
        huge = {"frame": 0, "region": (1e300, 0, 1e300, 5), "name": "x", "color": "#000000"}
        assert page.ask("add_object", **huge).error
        for points in ([1e300, 0, 9, 0, 9, 9], [float(i % 7) for i in range(400)]):
            said = page.ask("set_places", places={"zones": [{"points": points}]}).error
            assert "zones[0].points" in str(said)
    big = client.post(f"/api/sessions/{session}/import?name=x.csv", content=b"0" * 20_000)
    assert "larger" in error(big)
    assert "request" in error(client.post("/api/sessions", content=b"{"))
    client.delete(f"/api/sessions/{session}")


def test_numbers_of_sessions_and_jobs_are_limited(client: httpx.Client) -> None:
    one = begin(client)
    with looking(client, one) as page, looking(client, begin(client)):
        anew = {"film": "film.mkv", "anew": True}
        assert "2 sessions" in error(client.post("/api/sessions", json=anew))
        first = page.drawn(preset="nummiaro", config=SLOW)
        second = page.drawn()
        job = page.do("track", objects=[first]).job
        assert "1 jobs" in str(page.ask("track", objects=[second]).error)
        page.do("stop", job=job)
    for each in client.get("/api/sessions").json():
        client.delete(f"/api/sessions/{each['id']}")


def test_a_film_that_kills_its_workers_says_so(client: httpx.Client) -> None:
    good = begin(client)
    before = set(multiprocessing.active_children())
    bad = begin(client, "deep/film.mkv")
    with looking(client, good) as page, looking(client, bad) as other:
        number = other.drawn(region=(30.0, 25.0, 30.0, 40.0))
        for worker in set(multiprocessing.active_children()) - before:
            os.kill(worker.pid or 0, signal.SIGSEGV)
        refused = client.get(f"/api/sessions/{bad}/frames/1.jpg")
        assert "ended its worker (SIGSEGV" in error(refused)
        job = other.do("track", objects=[number]).job
        assert job is not None
        other.until(lambda: other.jobs[job].status == "failed")
        assert "SIGSEGV" in str(other.jobs[job].error)
        assert client.get(f"/api/sessions/{bad}/frames/1.jpg").status_code == 200  # a new worker
        other.tracked(number)
        assert not page.of(messages.Failure)
        assert client.get(f"/api/sessions/{good}/frames/1.jpg").status_code == 200
    for each in (good, bad):
        client.delete(f"/api/sessions/{each}")


@pytest.mark.skipif(os.name == "nt", reason="this system has no limit of memory")
def test_the_memory_of_a_worker_is_limited() -> None:
    worker = Worker()
    worker.give(partial(_too_much, size=2 << 30))
    answers = [worker.receive() for _ in range(2)]
    worker.end()
    assert isinstance(answers[1], Failed)
    assert "more memory than a worker may have" in answers[1].error


def _too_much(_: WorkerLine, size: int) -> bytes:
    limit_process(size // 2)
    return bytes(size)


def test_a_silent_worker_is_ended(folder: Path) -> None:
    async def wait() -> str:
        worker = FilmWorker(folder / "film.mkv", Limits(), background=False)
        await worker.ready()
        os.kill(worker._worker.pid, signal.SIGSTOP)
        worker._limits = Limits(silence=0.1)
        with pytest.raises(WorkerError) as failed:
            await worker.run(partial(picture, index=0, width=100))
        worker.close()
        return str(failed.value)

    assert "0.1 s without a result" in loops.run(wait(), 600)
