"""Events reach webhooks and brokers at least once, whoever dies on the way."""

import contextlib
import json
import socket
import sqlite3
import threading
from collections.abc import Iterator, Sequence
from functools import partial
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from brokers import Broker, Listener, SlowBroker
from motes import FormatError
from motes.video import pauses
from motes_fleet.delivery import delivery, mqtt, webhook
from motes_fleet.delivery.delivery import Delivery, DeliveryError
from motes_fleet.delivery.event_queue import MessageQueue
from motes_fleet.delivery.mqtt import Mqtt
from motes_fleet.delivery.webhook import Webhook
from waiting import wait_until


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delivery, "pauses", partial(pauses, 0.02))
    monkeypatch.setattr(delivery, "IDLE", 0.05)


class Server:
    """An HTTP server that notes what is posted, and answers as it is told."""

    def __init__(self, port: int = 0) -> None:
        self.posted: list[Any] = []
        self.status = 200
        self.authorization: list[str | None] = []
        owner = self

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                body = self.rfile.read(int(self.headers["Content-Length"]))
                if owner.status == 200:
                    owner.posted.append(json.loads(body))
                    owner.authorization.append(self.headers["Authorization"])
                self.send_response(owner.status)
                if owner.status == 302:
                    self.send_header("Location", "/elsewhere")
                self.send_header("Content-Length", "0")
                self.end_headers()

            def do_GET(self) -> None:
                self.send_response(200)
                self.end_headers()

            def log_message(self, *_: Any) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", port), Handler)
        self.port: int = self._server.server_address[1]
        threading.Thread(target=self._server.serve_forever, args=(0.01,), daemon=True).start()

    def close(self) -> None:
        """Stop answering."""
        self._server.shutdown()
        self._server.server_close()


@contextlib.contextmanager
def serving(port: int = 0) -> Iterator[Server]:
    server = Server(port)
    try:
        yield server
    finally:
        server.close()


def test_messages_stay_in_order_until_they_are_removed(tmp_path: Path) -> None:
    path = tmp_path / "q"
    with MessageQueue(path) as queue:
        queue.put(["a", "b"], ["1", "2", "3"])
        first = queue.oldest("a", 2, 0)
        assert [body for _, body in first] == ["1", "2"]
        queue.remove(first)
    with MessageQueue(path) as queue:
        assert queue.waiting() == {"a": 1, "b": 3}
        queue.put(["a"], ["4"])
        assert [body for _, body in queue.oldest("a", 9, 0)] == ["3", "4"]


def test_a_queue_that_cannot_be_used_is_one_clear_line(tmp_path: Path) -> None:
    path = tmp_path / "q"
    with MessageQueue(path), pytest.raises(FormatError, match="is used by another run"):
        MessageQueue(path)
    other = tmp_path / "other"
    other.write_text("no database" * 100)
    with pytest.raises(FormatError, match="is no queue of events"):
        MessageQueue(other)
    data = tmp_path / "data"
    with contextlib.closing(sqlite3.connect(data)) as database:
        database.execute("CREATE TABLE message (text)")
        database.commit()
    with pytest.raises(FormatError, match="is no queue of events"):
        MessageQueue(data)
    with pytest.raises(FormatError, match="cannot be used"):
        MessageQueue(tmp_path / "none" / "q")


def test_a_webhook_gets_all_though_the_server_fails_and_dies(tmp_path: Path) -> None:
    said: list[str] = []
    with MessageQueue(tmp_path / "q") as queue:
        with serving() as server:
            port = server.port
            hook = Webhook(f"http://us%20er:secret@127.0.0.1:{port}/in?x=1")
            server.status = 302  # the redirection would end well, without the message
            sending = Delivery(queue, hook, said.append)
            queue.put([hook.name], ['{"n": 1}', '{"n": 2}'])
            wait_until(lambda: said)
            assert server.posted == []
            server.status = 200
            wait_until(lambda: not queue.waiting())
            assert server.posted == [{"n": 1}, {"n": 2}]
            assert server.authorization[0] == "Basic dXMgZXI6c2VjcmV0"
        queue.put([hook.name], ['{"n": 3}'])
        wait_until(lambda: len(said) == 3)
        with serving(port) as server:
            wait_until(lambda: not queue.waiting())
            assert server.posted == [{"n": 3}]
        sending.close()
    assert sending.delivered == 3
    assert said[0].startswith(f"{hook.name} answers with status 302. Events wait")
    assert said[1].startswith(f"{hook.name} is back after")
    assert "Connection refused" in said[2]
    assert "secret" not in "".join(said)


HEAD = b"HTTP/1.1 200 OK\r\n"


@pytest.mark.parametrize(
    ("begin", "piece", "pause", "what"),
    [
        (b"", b"", 0.05, "has not finished its answer in 0.3 s"),
        (HEAD + b"\r\n", b"x", 0.05, "has not finished its answer in 0.3 s"),
        (HEAD + b"\r\n", b"x" * 9999, 0, "answers with more than 64 kB"),
        (HEAD + b"Transfer-Encoding: chunked\r\n\r\n", b"1\r\nx\r\n" * 999, 0, "more than 64 kB"),
        (HEAD, b"a: " + b"b" * 9999 + b"\r\n", 0, "more than 64 kB"),
        (b"", b"HTTP/1.1 100 Continue\r\n\r\n" * 99, 0, "more than 64 kB"),
    ],
    ids=["silent", "dripping", "endless", "chunks", "heads", "continue"],
)
def test_an_answer_without_end_is_a_failure_that_waits(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    begin: bytes,
    piece: bytes,
    pause: float,
    what: str,
) -> None:
    """The first post gets the answer without end, the second one a good one."""
    monkeypatch.setattr(webhook, "ANSWER", 30.0 if "kB" in what else 0.3)
    said: list[str] = []
    ended = threading.Event()

    def drip(connected: socket.socket) -> None:
        connected.recv(1 << 16)
        with contextlib.suppress(OSError):
            connected.sendall(begin)
            while not ended.wait(pause):
                connected.sendall(piece)

    with socket.create_server(("127.0.0.1", 0)) as server, MessageQueue(tmp_path / "q") as queue:
        hook = Webhook(f"http://127.0.0.1:{server.getsockname()[1]}/")
        sending = Delivery(queue, hook, said.append)
        queue.put([hook.name], ["1"])
        with server.accept()[0] as connected:
            dripping = threading.Thread(target=drip, args=(connected,))
            dripping.start()
            wait_until(lambda: said)
            assert queue.waiting() == {hook.name: 1}
            monkeypatch.setattr(webhook, "ANSWER", 600.0)
            ended.set()
            dripping.join()
        server.settimeout(0.05)
        while queue.waiting():
            with contextlib.suppress(OSError), server.accept()[0] as connected:
                connected.recv(1 << 16)
                connected.sendall(b"HTTP/1.1 204 No Content\r\n\r\n")
        sending.close()
    assert what in said[0]
    assert "are sent again" in said[0]


class Stubborn:
    """A receiver that never confirms."""

    name, batch = "stubborn", 1

    def send(self, bodies: Sequence[str]) -> None:
        """Fail."""
        raise DeliveryError("no")

    def close(self) -> None:
        """Do nothing."""


def test_the_end_of_a_run_waits_for_a_limited_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(delivery, "LAST_CHANCE", 0.1)
    with MessageQueue(tmp_path / "q") as queue:
        sending = Delivery(queue, Stubborn(), lambda line: None)
        queue.put(["stubborn"], ["1"])
        sending.close()
        assert sending.error is None
        assert queue.waiting() == {"stubborn": 1}


class Broken(Stubborn):
    """A receiver with an error of its own."""

    def send(self, bodies: Sequence[str]) -> None:
        """Fail in a way that nobody expects."""
        raise ZeroDivisionError("oh")


def test_a_receiver_that_breaks_ends_the_run(tmp_path: Path) -> None:
    with MessageQueue(tmp_path / "q") as queue:
        sending = Delivery(queue, Broken(), lambda line: None)
        wait_until(lambda: sending.error)
        assert str(sending.error) == "stubborn failed: ZeroDivisionError('oh')."
        sending.close()


def test_a_broker_gets_all_though_it_dies(tmp_path: Path) -> None:
    said: list[str] = []
    with Broker(tmp_path) as broker, MessageQueue(tmp_path / "q") as queue:
        listener = Listener(broker.port, "yard/#")
        receiver = Mqtt(f"mqtt://127.0.0.1:{broker.port}/yard")
        sending = Delivery(queue, receiver, said.append)
        queue.put([receiver.name], ["1", "2"])
        receiver.set_state("busy")
        wait_until(lambda: listener.texts("yard/state") == ["busy"])
        wait_until(lambda: not queue.waiting())
        assert listener.texts("yard") == ["1", "2"]
        assert listener.texts("yard/status") == ["online"]
        listener.close()
        broker.kill()
        queue.put([receiver.name], ["3", "4"])
        wait_until(lambda: said)
        broker.start()
        wait_until(lambda: not queue.waiting())
        sending.close()
        listener = Listener(broker.port, "yard/#")
        wait_until(lambda: {"3", "4"} <= set(listener.texts("yard")))
        wait_until(lambda: listener.texts("yard/status")[-1:] == ["offline"])
        listener.close()
    assert "Events wait" in said[0]
    assert any("is back after" in line for line in said)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("silent", "drips", "what"),
    [
        ("connect", False, "does not answer"),
        ("publish", False, "does not confirm events"),
        ("none", True, None),
    ],
)
def test_a_slow_broker_gets_all_in_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, silent: str, drips: bool, what: str | None
) -> None:
    broker = SlowBroker()
    broker.silent, broker.drips = {silent}, drips
    said: list[str] = []
    if what is not None:
        monkeypatch.setattr(mqtt, "ANSWER", 0.2)
    with MessageQueue(tmp_path / "q") as queue:
        receiver = Mqtt(f"mqtt://127.0.0.1:{broker.port}/yard")
        sending = Delivery(queue, receiver, said.append)
        queue.put([receiver.name], [str(number) for number in range(5)])
        if what is not None:
            wait_until(lambda: said)
            assert what in said[0]
            assert queue.waiting() == {receiver.name: 5}
            broker.silent.clear()  # first: an attempt in between would wait for its whole time
            monkeypatch.setattr(mqtt, "ANSWER", 600.0)
        wait_until(lambda: not queue.waiting())
        sending.close()
        assert sending.error is None
    texts = [text for topic, text in broker.texts if topic == "yard"]
    assert texts[-5:] == ["0", "1", "2", "3", "4"]
    assert len([line for line in said if "Events wait" in line]) == (what is not None)
    broker.close()


@pytest.mark.slow
def test_a_silent_broker_does_not_hold_up_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mqtt, "ANSWER", 0.1)
    monkeypatch.setattr(delivery, "LAST_CHANCE", 0.3)
    broker = SlowBroker()
    broker.silent = {"publish"}
    threads = threading.active_count()
    with MessageQueue(tmp_path / "q") as queue:
        receiver = Mqtt(f"mqtt://127.0.0.1:{broker.port}/yard")
        sending = Delivery(queue, receiver, lambda line: None)
        queue.put([receiver.name], ["1"])
        sending.close()
        assert queue.waiting() == {receiver.name: 1}
    broker.close()
    wait_until(lambda: threading.active_count() <= threads)
