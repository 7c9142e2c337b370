"""Compiled kernels in files: each is whole, or compiled again.

numba can keep them too. But it fails on a damaged file or runs it, fails where the disk is full,
and two programs that start at once may mix up which file is for which arguments.
"""

from __future__ import annotations

import contextlib
import hashlib
import pickle
import sys
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import event
from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

UNKEPT = "motes:unkept"
"""The event that a kernel could not be written; its data is the OSError."""


class Kept(NullCache):
    """What a dispatcher asks for compiled code: a file for each signature, a checksum in front.

    Parameters
    ----------
    function
        The loop before it is compiled.
    folder
        Where the files are; it is for one state of all sources, and may be read-only.
    """

    def __init__(self, function: Callable[..., object], folder: Path) -> None:
        self._folder = folder
        self._name = f"{function.__module__}.{function.__qualname__}"
        self._line = function.__code__.co_firstlineno

    @property
    def cache_path(self) -> str:
        """The folder."""
        return str(self._folder)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the code for a signature; None where there is no file, or a damaged one."""
        target_context.refresh()
        try:
            content = self._path(sig, target_context.codegen()).read_bytes()
        except OSError:
            return None
        data = content[hashlib.sha256().digest_size :]
        if content != _sealed(data):
            return None
        return CompileResult._rebuild(target_context, *pickle.loads(data))  # type: ignore[no-untyped-call]

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write the code for a signature, in one step; an event tells where that fails."""
        if data.library.has_dynamic_globals:  # addresses, which the next start does not have
            return
        path = self._path(sig, data.codegen)
        part = path.with_name(f"{path.name}.{uuid.uuid4().hex}")
        try:
            part.write_bytes(_sealed(dumps(data._reduce())))  # type: ignore[no-untyped-call]
            part.replace(path)
        except OSError as error:
            event.start_event(UNKEPT, error)  # type: ignore[no-untyped-call]
        finally:
            with contextlib.suppress(OSError):
                part.unlink()

    def _path(self, sig: Any, codegen: Any) -> Path:
        """Return the file for a signature, and for this machine's instructions and software."""
        machine = codegen.magic_tuple(), numba.__version__, sys.implementation.cache_tag
        key = repr((self._name, self._line, sig, machine))
        name = self._name.rpartition(".")[2]
        return self._folder / f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:32]}.nbc"


def _sealed(data: bytes) -> bytes:
    """Return data with its checksum in front."""
    return hashlib.sha256(data).digest() + data
