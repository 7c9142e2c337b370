"""How loops are compiled, and the folder that keeps them for the next run.

numba compiles a kept kernel anew when the kernel's own file has changed, but does not see a change
in another file that it calls: so each state of this package's files has a folder of its own.
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

F = TypeVar("F", bound=Callable[..., object])


def _folder() -> Path | None:
    """Return a writable folder for what is compiled from these files; None on a read-only system.

    It lies in NUMBA_CACHE_DIR or, where that is not set, in the user's folder of caches.
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
    return folder if os.access(folder, os.W_OK) else None


def _home() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


FOLDER = _folder()
"""Where compiled kernels are kept for the next run; None where nothing can be written."""


def _compiled(function: F, **options: Any) -> F:
    """Return a loop that is compiled on first use, and kept on disk where possible."""
    config: Any = numba.config
    before, config.CACHE_DIR = config.CACHE_DIR, str(FOLDER)  # asked for here, and not again
    try:
        compiled = numba.njit(cache=FOLDER is not None, error_model="numpy", **options)(function)
        return cast(F, compiled)
    finally:
        config.CACHE_DIR = before


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

    class Once(event.Listener):
        def on_start(self, _: event.Event) -> None:
            stop()
            tell()

        def on_end(self, _: event.Event) -> None:
            """Told at the start."""

    once = Once()
    stop = functools.partial(event.unregister, "numba:compile", once)
    event.register("numba:compile", once)  # type: ignore[no-untyped-call]
