"""motes watch and motes track as they run for long: sent, killed."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from brokers import Broker, Listener, free_port
from motes.cli import main
from motes_fleet.delivery import delivery
from motes_fleet.delivery.delivery import Delivery
from motes_fleet.delivery.event_queue import MessageQueue
from motes_fleet.delivery.mqtt import Mqtt
from red_box import walk
from waiting import wait_until

FRAMES = 70
PROGRAM = "import sys; from motes.cli import main; sys.exit(main())"


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> str:
    """Return a film of a red box that walks over noise from frame 15 on, to the right, and out."""
    path = tmp_path_factory.mktemp("film") / "film.mkv"
    walk(path, FRAMES, enters=15)
    return str(path)


def watch(film: str, *more: str) -> list[str]:
    return ["watch", film, "--line", "80,0,80,96", *more]


def test_events_reach_a_broker_with_counts(
    film: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with Broker(tmp_path) as broker:
        address = f"mqtt://127.0.0.1:{broker.port}/yard"
        ears = Listener(broker.port, "#")
        more = ["--events", address, "--events", "e.jsonl"]
        assert main(watch(film, *more)) == 0
        written = [json.loads(line) for line in Path("e.jsonl").read_text().splitlines()]
        wait_until(lambda: ears.texts("yard/status")[-1:] == ["offline"])
        ears.close()
        sent = [json.loads(text) for text in ears.texts("yard")]
    heads = [{key: event.pop(key) for key in ("message", "date", "source")} for event in sent]
    assert sent == written
    assert [event["event"] for event in sent] == ["appears", "crosses", "disappears"]
    assert len({head["message"] for head in heads}) == 3
    assert {head["source"] for head in heads} == {film}
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}\+00:00", heads[0]["date"])
    state = json.loads(ears.texts("yard/state")[-1])
    assert state["line_1_right"] + state["line_1_left"] == 1
    assert f"e.jsonl, 3 events for {address}" in capsys.readouterr().err


@pytest.mark.slow
def test_a_kill_loses_no_event(film: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """There is no broker at first; motes is killed; the next run delivers what waits."""
    monkeypatch.setattr(delivery, "IDLE", 0.05)
    broker, queue, events = Broker(tmp_path), tmp_path / "q", tmp_path / "e.jsonl"
    address = f"mqtt://127.0.0.1:{broker.port}/yard"
    more = ["--events", str(events), "--events", address, "--queue", str(queue)]
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *watch(film, *more)], stderr=subprocess.PIPE, text=True
    ) as process:
        wait_until(lambda: events.exists() and events.read_bytes().count(b"\n") == 3)
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
    assert process.returncode == -signal.SIGKILL
    first, second = [json.loads(line) for line in events.read_text().splitlines()[:2]]
    with broker, MessageQueue(queue) as left:
        assert left.waiting()[address] >= 2  # all but those of the frame of the kill
        ears = Listener(broker.port, "yard")
        sending = Delivery(left, Mqtt(address), lambda line: None)
        wait_until(lambda: not left.waiting())
        wait_until(lambda: len(ears.heard) >= 2)
        sending.close()
        ears.close()
    heard = [json.loads(text) for text in ears.texts("yard")]
    for event in (first, second):
        assert any(event.items() <= each.items() for each in heard)


@pytest.mark.slow
def test_what_waits_is_reported(
    film: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(delivery, "LAST_CHANCE", 0.0)
    queue = tmp_path / "q"
    hook = f"http://127.0.0.1:{free_port()}/in"
    assert main(watch(film, "--events", hook, "--queue", str(queue))) == 0
    error = capsys.readouterr().err
    assert f"3 events for {hook} in {queue}; the next run" in error
    assert error.count(f"for {hook}") == 1  # the summary does not have them as written
    other = f"http://127.0.0.1:{free_port()}/in"
    assert main(watch(film, "--events", other, "--queue", str(queue), "--end", "10")) == 4
    error = capsys.readouterr().err
    assert f"3 events of earlier runs for {hook} in {queue}; this run does not send them" in error


@pytest.mark.parametrize(
    ("line", "what"),
    [
        ("--queue q", "--queue is for events that are sent"),
        ("--events https://h/a --events https://h/a", "are the same"),
        ("--events mqtt:h/t", "--events mqtt:h/t: such addresses are not known"),
        ("--events mqtt://h", "lacks a host or a topic"),
        ("--events mqtt://h/a/%23", "is a pattern"),
        ("--events http:///a", "has no host"),
        ("--events http://a:99999/c", "is no address: Port out of range"),
        ("--events http://me:secret@[::1/c", "error: [::1/c is no address"),
        ("--events http://a/ä", "has characters that addresses write as %XX"),
        ("--events - -o -", "would mix on standard output"),
    ],
)
def test_options_that_make_no_sense(
    line: str, what: str, film: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert main(["watch", film, *line.split()]) == 2
    error = capsys.readouterr().err
    assert what in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
