"""Workers: they do tasks, receive no signal that asks to end, and leave nothing when they end."""

import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from motes.core.errors import FormatError
from motes.core.worker import Alive, Answer, Done, Failed, Part, Worker, WorkerLine
from waiting import runs, wait_until

pytestmark = pytest.mark.slow


# The functions below run in a worker.


def parts(line: WorkerLine, count: int) -> bytes:
    """Send parts, and then the number of them."""
    for number in range(count):
        line.send(Part(bytes([number])))
    return str(count).encode()


def until_stopped(line: WorkerLine) -> bytes:
    """Work until the program wants no more."""
    line.send(Part(b"begun"))
    while True:
        line.check()


def fail(_: WorkerLine, error: Exception) -> bytes:
    raise error


class Deaf(WorkerLine):
    """A line that has not read yet that there is no program any more."""

    def _take(self) -> None:
        time.sleep(600)


def send_on(line: WorkerLine, note: str) -> None:
    """Start a program as `begin_program` does, and send while there is somebody who receives."""
    threading.Thread(target=begin_program, args=(line, note), daemon=True).start()
    while True:
        line.send(Alive())
        time.sleep(0.01)


def begin_program(_: WorkerLine, note: str) -> bytes:
    """Start a program that would outlive this process; note both, and wait."""
    program = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    Path(f"{note}.part").write_text(f"{os.getpid()} {program.pid} {tempfile.gettempdir()}")
    Path(f"{note}.part").rename(note)
    time.sleep(600)
    return b""


def spoil(line: WorkerLine) -> bytes:
    """Send what is no answer: a pickle, as of a worker that was taken over."""
    pipe: Connection = line._pipe
    pipe.send(fail)
    time.sleep(600)
    return b""


# The tests.


@pytest.fixture
def worker() -> Iterator[Worker]:
    """Return a worker that does tasks."""
    made = Worker()
    yield made
    made.end()


def answers(worker: Worker) -> list[Answer]:
    """Return the answers to a task but the signs of life."""
    found: list[Answer] = []
    while not found or isinstance(found[-1], Part):
        answer = worker.receive()
        assert answer is not None
        if not isinstance(answer, Alive):
            found.append(answer)
    return found


def test_a_worker_does_one_task_after_another(worker: Worker) -> None:
    worker.give(partial(parts, count=2))
    assert answers(worker) == [Part(b"\0"), Part(b"\1"), Done(b"2")]
    worker.give(partial(fail, error=FormatError("It is too small.")))
    assert answers(worker) == [Failed("It is too small.", "FormatError")]
    worker.give(partial(fail, error=MemoryError()))
    assert "more memory than a worker may have" in str(answers(worker)[0])
    worker.give(partial(parts, count=0))
    assert answers(worker) == [Done(b"0")]


def test_a_task_is_stopped_and_a_stop_that_comes_late_stops_none(worker: Worker) -> None:
    worker.give(until_stopped)
    assert worker.receive() == Alive()
    assert worker.receive() == Part(b"begun")
    worker.stop()
    assert answers(worker) == [Done()]
    worker.stop()
    worker.give(partial(parts, count=1))
    assert answers(worker) == [Part(b"\0"), Done(b"1")]


def test_signals_that_ask_to_end_are_not_received(worker: Worker) -> None:
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        os.kill(worker.pid, number)
    worker.give(partial(parts, count=0))
    assert answers(worker) == [Done(b"0")]


@pytest.mark.parametrize(
    ("number", "words"),
    [(signal.SIGSEGV, "SIGSEGV"), (signal.SIGKILL, "SIGKILL (was there too little memory?)")],
)
def test_how_a_worker_has_ended_is_known(worker: Worker, number: int, words: str) -> None:
    worker.give(until_stopped)
    os.kill(worker.pid, number)
    while worker.receive() is not None:
        pass
    assert worker.cause() == words
    worker.give(until_stopped)  # nobody is there, and nothing is raised


def test_two_threads_may_end_a_worker(worker: Worker, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the listener of the studio and the end of the program do."""
    begun: list[bool] = []

    def end() -> None:
        begun.append(True)
        worker.end()

    def slowly(pipe: Connection) -> None:
        wait_until(lambda: len(begun) == 2)
        os.close(pipe.fileno())

    monkeypatch.setattr(Connection, "_close", slowly)
    with ThreadPoolExecutor(2) as threads:
        ends = [threads.submit(end) for _ in range(2)]
    assert [end.result() for end in ends] == [None, None]


def test_what_a_worker_sends_is_never_unpickled(worker: Worker) -> None:
    worker.give(spoil)
    assert worker.receive() == Alive()
    assert worker.receive() is None


def test_a_worker_ends_with_all_that_it_has_started(tmp_path: Path) -> None:
    worker, note = Worker(), tmp_path / "note"
    worker.give(partial(begin_program, note=str(note)))
    wait_until(note.exists)
    mine, program, folder = note.read_text().split()
    assert int(mine) == worker.pid
    assert Path(folder).exists()
    worker.end()
    wait_until(lambda: not runs(int(program)))
    assert not Path(folder).exists()
    assert worker.cause().startswith("SIGKILL")


PROGRAM = """
import multiprocessing
import sys
from functools import partial
from motes.core.worker import Worker
from test_worker import begin_program
if __name__ == "__main__":
    worker = Worker(context=multiprocessing.get_context(sys.argv[1]))
    worker.give(partial(begin_program, note="note"))
    while True:
        worker.pipe.recv_bytes()
"""


@pytest.mark.parametrize(
    ("number", "method"), [(signal.SIGKILL, "forkserver"), (signal.SIGINT, "spawn")]
)
def test_no_worker_outlives_its_program(
    tmp_path: Path, number: int, method: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor do the process that it is a copy of, what it has started, and its folder.

    Only the program has Ctrl-C.
    """
    (tmp_path / "program.py").write_text(PROGRAM)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    program = subprocess.Popen(
        [sys.executable, "program.py", method], cwd=tmp_path, stderr=subprocess.DEVNULL
    )
    wait_until((tmp_path / "note").exists)
    worker, started, scratch = (tmp_path / "note").read_text().split()
    copied = int(Path(f"/proc/{worker}/stat").read_text().rpartition(")")[2].split()[1])
    assert (copied == program.pid) is (method == "spawn")
    state = Path(f"/proc/{worker}/status").read_text()
    (blocked,) = re.findall(r"SigBlk:\s*(\w+)", state)
    assert int(blocked, 16) & 1 << signal.SIGINT - 1
    program.send_signal(number)
    program.wait()
    for each in (copied, int(worker), int(started)):
        wait_until(lambda each=each: not runs(each))  # type: ignore[misc]
    wait_until(lambda: not Path(scratch).exists())


def test_a_worker_that_sends_to_nobody_ends_with_all_that_it_has_started(tmp_path: Path) -> None:
    note = tmp_path / "note"
    worker = Worker(send_on, str(note), line=Deaf)
    wait_until(note.exists)
    mine, program, folder = note.read_text().split()
    worker.pipe.close()
    wait_until(lambda: not runs(int(mine)) and not runs(int(program)))
    assert not Path(folder).exists()
