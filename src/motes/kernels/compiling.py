"""How loops are compiled, and the folder that keeps them for the next run.

A kernel holds the code of those that it calls, from other files too: so each state of this
package's files has a folder of its own.
"""

from __future__ import annotations

import functools
import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import event

from motes.kernels.keeping import UNKEPT, Kept

F = TypeVar("F", bound=Callable[..., object])


def _folder() -> Path | None:
    """Return a folder for what is compiled from these files; None where none can be made.

    It lies in NUMBA_CACHE_DIR or, where that is not set, in the user's folder of caches. One that
    is there is good for reading even on a read-only system.
    """
    sources = hashlib.sha256()
    for file in sorted(Path(__file__).parent.glob("*.py")):
        sources.update(file.read_bytes())
    try:
        base = os.environ.get("NUMBA_CACHE_DIR") or _home() / "motes" / "numba"
        folder = Path(base, sources.hexdigest()[:16])
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return folder


def _home() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


FOLDER = _folder()
"""Where compiled kernels are kept for the next run; None where there is no such folder."""


def _compiled(function: F, **options: Any) -> F:
    """Return a loop that is compiled on first use, and kept on disk where possible."""
    compiled: Any = numba.njit(error_model="numpy", **options)(function)
    if FOLDER is not None:
        compiled._cache = Kept(function, FOLDER)
    return cast(F, compiled)


def kernel(function: F) -> F:
    """Compile a loop that does without the GIL."""
    return _compiled(function, nogil=True)


def brief(function: F) -> F:
    """Compile a loop of microseconds, for which handing over the GIL would take longer."""
    return _compiled(function)


def unordered(function: F) -> F:
    """Compile a loop without the GIL whose sums may add up in any order, as vector code does."""
    return _compiled(function, nogil=True, fastmath={"reassoc", "contract"})


def when_compiling(tell: Callable[[], None]) -> None:
    """Call a function before the next kernel is compiled that no folder keeps, and never again."""
    _once("numba:compile", lambda _: tell())


def when_unkept(tell: Callable[[OSError], None]) -> None:
    """Call a function with the error of the next kernel that cannot be written, and never again."""
    _once(UNKEPT, tell)


def _once(kind: str, tell: Callable[[Any], None]) -> None:
    """Call a function with the data of the next event of a kind."""

    class Once(event.Listener):
        def on_start(self, happened: event.Event) -> None:
            stop()
            tell(happened.data)

        def on_end(self, _: event.Event) -> None:
            """Told at the start."""

    once = Once()
    stop = functools.partial(event.unregister, kind, once)
    event.register(kind, once)  # type: ignore[no-untyped-call]
