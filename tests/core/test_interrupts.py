"""Signals that ask to end: each ends a run as Ctrl-C does, and none shows a traceback."""

import contextlib
import itertools
import os
import pty
import signal
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Callable, Iterator
from fcntl import ioctl
from pathlib import Path
from typing import Any

import pytest

from clips import write_pictures
from motes import open_source
from motes.cli.streams import _lenient
from motes.core import interrupts
from motes.core.interrupts import SIGNALS, Interrupt, check, deferred, raised
from motes.video.prefetch import prefetch
from red_box import moving
from scripts import uncounted
from waiting import wait_until

FRAMES = 800


@pytest.mark.slow
def test_a_closed_terminal(tmp_path: Path) -> None:
    """Nobody reads what is said then, and to say it fails."""
    film, rows, overlay = (tmp_path / name for name in ("film.mkv", "r.csv", "o.mp4"))
    pictures = [moving(index) for index in range(20)]
    write_pictures(film, itertools.islice(itertools.cycle(pictures), FRAMES))
    ours, theirs = pty.openpty()
    line = [sys.executable, "-m", "motes", "track", film, "--init", "60,30,16,30", "-o"]
    with subprocess.Popen(
        [*map(str, (*line, rows, "--overlay", overlay))],
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
        preexec_fn=lambda: ioctl(0, termios.TIOCSCTTY, 0),
    ) as process:
        os.close(theirs)
        wait_until(lambda: rows.exists() and rows.read_bytes().count(b"\n") > 5)
        os.close(ours)
        process.communicate()
    assert process.returncode == 129
    with open_source(overlay) as drawn:
        assert len(list(drawn)) == rows.read_bytes().count(b"\n") - 1 < FRAMES


def send(number: int = signal.SIGINT) -> None:
    os.kill(os.getpid(), number)
    time.sleep(0)  # the handler runs at the latest here


def call_and_wait(call: Callable[[], object]) -> None:
    """Call a function, and wait until an interrupt is raised; return if none is."""
    with raised():
        call()
        end = time.monotonic() + 300
        while time.monotonic() < end:
            time.sleep(0.001)


def test_a_line_that_an_interrupt_meets_is_not_printed_twice() -> None:
    """On a terminal, an interrupt comes nearly always while a line is written."""
    for _ in range(10):
        terminal, theirs = pty.openpty()
        shown = bytearray()

        def read(terminal: int = terminal, shown: bytearray = shown) -> None:
            sent = False
            with contextlib.suppress(OSError):  # the other side is closed
                while True:
                    shown.extend(os.read(terminal, 1 << 16))
                    if not sent:
                        sent = True
                        send()

        reader = threading.Thread(target=read)
        with open(theirs, "w") as file:
            stream = _lenient(file)
            with contextlib.suppress(Interrupt), raised():
                reader.start()
                for number in itertools.count():
                    stream.write(f"{number}\n")
            stream.flush()
        reader.join()
        os.close(terminal)
        lines = bytes(shown).split()
        assert len(lines) == len(set(lines))


@pytest.mark.parametrize("number", SIGNALS)
def test_each_signal_says_which_it_was(number: int) -> None:
    before = [signal.getsignal(each) for each in SIGNALS]
    with pytest.raises(Interrupt) as caught, raised():
        send(number)
    assert interrupts.code(caught.value) == 128 + number
    by_hand = number == signal.SIGINT
    assert interrupts.word(caught.value) == f"{'interrupted' if by_hand else 'terminated'} after "
    assert [signal.getsignal(each) for each in SIGNALS] == before


def test_interrupts_wait_for_what_must_be_whole() -> None:
    done = []

    def work() -> None:
        with raised(), deferred():
            with deferred():
                send()
                done.append("inner")
            done.append("outer")

    with pytest.raises(Interrupt):
        work()
    assert done == ["inner", "outer"]


def test_only_ctrl_c_cuts_the_end_short() -> None:
    with raised():
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGINT):
            with pytest.raises(Interrupt):
                send(number)
        send(signal.SIGTERM)
        send(signal.SIGHUP)


class Fragile:
    """What is raised in a destructor, Python only prints."""

    def __del__(self) -> None:
        send(signal.SIGTERM)


class Late(threading.Timer):
    """A timer whose first signal comes while it begins."""

    begun = False

    def start(self) -> None:
        """Start, and wait for the first one."""
        super().start()
        if not Late.begun:
            Late.begun = True
            self.join()


@pytest.mark.parametrize("timer", [threading.Timer, Late])
def test_an_interrupt_that_python_drops_comes_again(
    timer: type[threading.Timer], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(threading, "Timer", timer)
    with pytest.raises(Interrupt) as caught:
        call_and_wait(Fragile)
    assert caught.value.number == signal.SIGTERM


def test_other_exceptions_that_python_drops_go_where_they_went(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Fails:
        def __del__(self) -> None:
            raise ValueError

    dropped: list[Any] = []
    monkeypatch.setattr("sys.unraisablehook", lambda each: dropped.append(each.exc_type))
    with raised():
        Fails()
    assert dropped == [ValueError]


def test_an_interrupt_that_a_library_catches_is_raised_again() -> None:
    with raised():
        check()
        with contextlib.suppress(BaseException):
            send(signal.SIGTERM)
        with pytest.raises(Interrupt, match="15"):
            check()


def test_nothing_is_raised_in_imports() -> None:
    """Some libraries make another exception of an import's."""
    done: list[str] = []
    scope: dict[str, Any] = {"__name__": "importlib._bootstrap", "send": send, "done": done}
    exec("def call():\n    send()\n    done.append('whole')", scope)
    with pytest.raises(Interrupt):
        call_and_wait(scope["call"])
    assert done == ["whole"]


def test_a_program_that_is_imported_hears_signals() -> None:
    """Only imports that have begun since count."""
    scope: dict[str, Any] = {"__name__": "importlib._bootstrap", "raised": raised, "send": send}
    exec("def call():\n    with raised():\n        send()\n        return 'unheard'", scope)
    with pytest.raises(Interrupt):
        scope["call"]()


def test_ignored_signals_stay_ignored() -> None:
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with raised():
            assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
            send()
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


def test_an_interrupt_while_a_thread_begins_leaves_none_behind(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Interrupted(threading.Thread):
        def start(self) -> None:
            super().start()
            os.kill(os.getpid(), signal.SIGINT)

    def endless() -> Iterator[int]:
        while True:
            time.sleep(0.001)
            yield 0

    items, before = endless(), threading.active_count()
    monkeypatch.setattr(threading, "Thread", Interrupted)
    with pytest.raises(Interrupt), raised(), prefetch(items):
        pass
    assert threading.active_count() == before
    items.close()  # type: ignore[attr-defined]  # which a thread in it would not allow


@pytest.mark.slow
@pytest.mark.parametrize("program", ["motes", "motes_lab"])
def test_an_interrupt_of_the_imports_shows_no_traceback(program: str) -> None:
    """Ctrl-C right after a command: it comes while modules are imported, whichever is the first."""
    code = f"""if True:
        import sys
        class Interrupted:
            def find_spec(self, name, *rest):
                if name not in ("motes", "motes_lab", "motes.start", "{program}.start"):
                    raise KeyboardInterrupt
        sys.meta_path.insert(0, Interrupted())
        from {program}.start import main
        sys.exit(main())"""
    words = [sys.executable, "-c", code]
    done = subprocess.run(words, env=uncounted(), capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (130, "")
