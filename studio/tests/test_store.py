"""What a person did is on disk when it is answered, and comes back after a kill."""

import os
import signal
import sqlite3
import sys
from pathlib import Path
from typing import Any

import pytest

from motes import FormatError
from motes_studio.document import Document
from motes_studio.store import Store, data_folder
from studios import BOX, Program, begin, film, looking, running
from waiting import PATIENCE

pytestmark = pytest.mark.slow


def test_a_killed_server_loses_nothing(tmp_path: Path) -> None:
    (tmp_path / "films").mkdir()
    film(tmp_path / "films" / "film.mkv")
    data = tmp_path / "data"
    with Program(tmp_path / "films", data) as program, program.client() as client:
        session = begin(client)
        with looking(client, session) as page:
            number = page.drawn(preset="nummiaro")
            page.tracked(number)
            page.do("set_keyframe", object=number, frame=30, region=BOX)
            page.settle()
            rows = dict(page.rows[number])
            page.do("change_object", object=number, name="renamed")
            page.do("undo")
            program.kill()
    with running(tmp_path / "films", data) as client:
        (card,) = client.get("/api/sessions").json()
        assert (card["id"], card["film"], card["objects"]) == (session, "film.mkv", 1)
        with looking(client, session) as page:
            page.settle()
            assert page.rows[number] == rows
            assert page.item(number).name == "disk"
            page.do("redo")
            assert page.item(number).name == "renamed"
            for _ in range(3):
                page.do("undo")
            assert page.session.objects == []
            assert page.ask("undo").error
        client.delete(f"/api/sessions/{session}")
        assert client.get("/api/sessions").json() == []


def test_a_job_goes_on_after_a_restart(tmp_path: Path) -> None:
    (tmp_path / "films").mkdir()
    film(tmp_path / "films" / "film.mkv")
    with running(tmp_path / "films", tmp_path / "data") as client:
        session = begin(client)
        with looking(client, session) as page:
            number = page.drawn(preset="nummiaro:printed")
            page.do("track")
    with running(tmp_path / "films", tmp_path / "data") as client, looking(client, session) as page:
        page.settle()
        assert page.final(number)


def test_a_command_ends_the_server_cleanly(tmp_path: Path) -> None:
    (tmp_path / "films").mkdir()
    with Program(tmp_path / "films", tmp_path / "data") as program:
        with program.client() as client:
            assert client.get("/api/films").json() == []
        program.process.send_signal(signal.SIGTERM)
        _, said = program.process.communicate(timeout=PATIENCE)
        assert program.process.returncode == 143
        assert "Traceback" not in said


def test_changes_behind_an_undo_are_forgotten(tmp_path: Path) -> None:
    store = Store(tmp_path / "studio.sqlite")
    name = store.begin("film", uploaded=False)
    for place in (1, 2, 3):
        store.change(name, place, Document(following=place + 1))
    store.go(name, 1)
    assert (store.session(name)[2], store.last_place(name)) == (1, 3)
    store.change(name, 2, Document(following=9))
    assert store.last_place(name) == 2
    assert store.document(name, 2).following == 9
    store.add_part(name, "key", b"ab")
    store.add_part(name, "key", b"cd")
    assert store.parts(name, "key") == b"abcd"
    assert store.parts_from(name, "key", 1, 5) == [b"cd"]
    store.replace_parts(name, "key", b"ef")
    assert (store.parts(name, "key"), store.parts_from(name, "key")) == (b"ef", [b"ef"])
    store.remove(name)
    assert store.parts(name, "key") == b""
    with pytest.raises(FormatError, match="no such session"):
        store.session(name)
    store.close()


def test_a_full_disk_ends_a_job_with_a_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "films").mkdir()
    film(tmp_path / "films" / "film.mkv")

    def full(*_: object) -> None:
        raise FormatError("there is no room")

    with (
        running(tmp_path / "films", tmp_path / "data") as client,
        looking(client, begin(client)) as page,
    ):
        number = page.drawn()
        with monkeypatch.context() as patched:
            patched.setattr(Store, "replace_parts", full)
            job = page.do("track").job
            assert job is not None
            page.until(lambda: page.jobs[job].status == "failed")
        assert page.jobs[job].error == "there is no room"
        page.until(lambda: not page.item(number).tracked)  # so it is not offered for export
        page.tracked(number)


@pytest.mark.skipif(sys.platform != "linux", reason="only there the variable is read")
def test_data_have_a_folder_without_a_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pwd.getpwuid", {}.__getitem__)
    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.setenv("XDG_DATA_HOME", "/data")
    assert data_folder() == Path("/data/motes")


def test_a_store_that_cannot_be_used_is_one_line_and_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[sqlite3.Connection] = []
    connect = sqlite3.connect

    def noted(*given: Any, **more: Any) -> sqlite3.Connection:
        opened.append(connect(*given, **more))
        return opened[-1]

    (tmp_path / "studio.sqlite").write_bytes(b"this is no base of data" * 100)
    with sqlite3.connect(tmp_path / "new.sqlite") as base:
        base.execute("PRAGMA user_version=99")
    base.close()
    monkeypatch.setattr(sqlite3, "connect", noted)
    with pytest.raises(FormatError, match="cannot be used"):
        Store(tmp_path / "studio.sqlite")
    with pytest.raises(FormatError, match="another version"):
        Store(tmp_path / "new.sqlite")
    assert len(opened) == 2
    for each in opened:
        with pytest.raises(sqlite3.ProgrammingError, match="closed"):
            each.cursor()
    if os.geteuid():
        (tmp_path / "closed").mkdir(mode=0o500)
        with pytest.raises(FormatError):
            Store(tmp_path / "closed" / "deep" / "studio.sqlite")
