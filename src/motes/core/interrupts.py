"""Signals that ask a program to end: each raises an `Interrupt`, as Ctrl-C does in every program.

The exception must not be raised in places where it would be lost. Python drops exceptions from a
destructor. Some libraries turn an exception from an import into another error. In these places the
signal is sent again a moment later. If a library has caught the exception nevertheless, loops raise
it again with `check`.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

SIGNALS = tuple(
    getattr(signal, name)
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
    if hasattr(signal, name)  # Windows has no SIGHUP, and all others no SIGBREAK
)
"""All signals that ask a program to end."""
PIPE = 13
"""The number of SIGPIPE, which Windows does not name."""
AGAIN = 0.01
"""Seconds after which a signal that came at a wrong moment is sent again."""
FRAGILE = "importlib._bootstrap"
"""Beginning of the names of modules in which no interrupt must be raised."""


class Interrupt(KeyboardInterrupt):
    """A signal asks the program to end."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


def code(interrupt: KeyboardInterrupt) -> int:
    """Return the exit code after an interrupt: 128 plus the signal's number."""
    return 128 + int(getattr(interrupt, "number", signal.SIGINT))


def word(interrupt: KeyboardInterrupt | None) -> str:
    """Return the first words of the summary of an interrupted run; empty for None."""
    if interrupt is None:
        return ""
    words = {signal.SIGINT: "interrupted", PIPE: "standard output was closed"}
    return f"{words.get(code(interrupt) - 128, 'terminated')} after "


class _State:
    """The state of the signal handler. Python calls the handler in the main thread only."""

    def __init__(self, base: FrameType | None = None) -> None:
        self.base = base
        """The frame in which signals began to raise interrupts."""
        self.hook = sys.unraisablehook
        """The hook for all other exceptions that Python drops."""
        self.held = 0
        """Depth of `deferred`."""
        self.waiting: int | None = None
        """A signal that came while interrupts were deferred."""
        self.sent: Interrupt | None = None
        """The interrupt that was raised last."""
        self.timer: threading.Timer | None = None

    def handle(self, number: int, frame: FrameType | None) -> None:
        """Raise an interrupt, now or later."""
        # A closed terminal or a service manager may send its signal twice. After an interrupt,
        # only a second Ctrl-C interrupts the work at the end of the run.
        if self.sent is not None and number != signal.SIGINT:
            return
        if self.held:
            self.waiting = number
        elif self._fragile(frame):
            self.send_again(number)
        else:
            self.sent = Interrupt(number)
            raise self.sent

    def _fragile(self, frame: FrameType | None) -> bool:
        while frame is not None and frame is not self.base:
            if frame.f_globals.get("__name__", "").startswith(FRAGILE):
                return True
            # A repeated signal may come before the start of its timer has returned.
            if frame.f_code is _State.send_again.__code__:
                return True
            frame = frame.f_back
        return False

    def send_again(self, number: int) -> None:
        """Send a signal to the main thread, a moment later."""
        self.timer = threading.Timer(AGAIN, _send, (number,))
        self.timer.daemon = True
        self.timer.start()

    def unraisable(self, dropped: UnraisableHookArgs) -> None:
        """Send the signal of a dropped interrupt again; pass other exceptions to the old hook."""
        if isinstance(dropped.exc_value, Interrupt):
            self.sent = None
            self.send_again(dropped.exc_value.number)
        else:
            self.hook(dropped)


_state = _State()


def _send(number: int) -> None:
    if sys.platform != "win32":  # it also wakes a thread that waits
        signal.pthread_kill(threading.main_thread().ident, number)  # type: ignore[arg-type]
    else:
        signal.raise_signal(number)


@contextlib.contextmanager
def raised() -> Iterator[None]:
    """Raise an `Interrupt` in the main thread for each of `SIGNALS` that comes.

    Signals that are ignored stay ignored, as under nohup.
    """
    global _state
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may set handlers
        return
    handlers: dict[int, Any] = {number: signal.getsignal(number) for number in SIGNALS}
    for number in [key for key, handler in handlers.items() if handler in (signal.SIG_IGN, None)]:
        del handlers[number]  # it is ignored, or not Python's
    before, _state = _state, _State(sys._getframe(2))
    sys.unraisablehook = _state.unraisable
    try:
        for number in handlers:
            signal.signal(number, _state.handle)
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        if _state.timer is not None:
            _state.timer.cancel()
        sys.unraisablehook = _state.hook
        _state = before


def came() -> bool:
    """Return whether a signal has asked the program to end."""
    return _state.sent is not None


def check() -> None:
    """Raise the last interrupt again if a library has caught it; else do nothing."""
    if _state.sent is not None:
        raise _state.sent


@contextlib.contextmanager
def deferred() -> Iterator[None]:
    """Let interrupts wait until the end of the block."""
    state = _state
    state.held += 1
    try:
        yield
    finally:
        state.held -= 1
    if state.waiting is not None and not state.held:
        number, state.waiting = state.waiting, None
        state.handle(number, None)
