"""The trained networks of the studio: files that were sent once, for all sessions."""

from __future__ import annotations

import asyncio
import hashlib
import tempfile
from collections.abc import AsyncIterator, Sequence
from pathlib import Path

from motes.core.errors import ConfigError, FormatError
from motes.core.import_callable import explain
from motes.core.system import system
from motes.core.worker_processes import blocked_signals, cause
from motes.studio.processes import worker_context
from motes.studio.safety import Limits, plain_name


class Networks:
    """The networks that can be chosen; the files of each lie in a folder of their own.

    Parameters
    ----------
    folder
        Where the folders are; it is made.
    limits
        Of the size of a network.
    """

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._folder, self._limits = folder.absolute(), limits
        folder.mkdir(parents=True, exist_ok=True)

    def listed(self) -> list[list[str]]:
        """Return the paths of the files of each network."""
        return [_models(each) for each in sorted(self._folder.iterdir()) if each.is_dir()]

    async def take(
        self, names: Sequence[str], sizes: Sequence[int], parts: AsyncIterator[bytes]
    ) -> list[str]:
        """Write the files of a network, and return the paths of those that end in .onnx.

        The others hold weights. Files that motes cannot use leave nothing.

        Parameters
        ----------
        names, sizes
            The name and the number of bytes of each file.
        parts
            The bytes of all files, one file after the other.

        Raises
        ------
        MotesError
            If they are no network, too large, or cannot be written.
        """
        names = [plain_name(name).replace(",", "_") for name in names]
        if len(names) != len(sizes) or len(set(names)) != len(names):
            raise ConfigError("Each file of a network needs a name of its own, and its size.")
        if not any(name.lower().endswith(".onnx") for name in names):
            raise ConfigError("A network's files end in .onnx; choose them.")
        if sum(sizes) > (most := self._limits.network):
            raise FormatError(f"A network has {most >> 20} MB at most; this one is larger.")
        data = bytearray()
        async for part in parts:
            data += part
            if len(data) > sum(sizes):
                break
        if len(data) != sum(sizes):
            raise FormatError("The files have other sizes than was said; send them again.")
        return await asyncio.to_thread(self._kept, names, sizes, bytes(data))

    def _kept(self, names: Sequence[str], sizes: Sequence[int], data: bytes) -> list[str]:
        digest = hashlib.blake2b(repr((names, sizes)).encode() + data, digest_size=8).hexdigest()
        folder, start = self._folder / digest, 0
        try:
            with tempfile.TemporaryDirectory(dir=self._folder.parent, prefix=".") as name:
                made = Path(name) / digest
                made.mkdir()
                for file, size in zip(names, sizes, strict=True):
                    (made / file).write_bytes(data[start : start + size])
                    start += size
                if problem := _problem(_models(made), self._limits, made.parent / "found"):
                    raise FormatError(problem.replace(f"{made}/", ""))
                if not folder.exists():
                    made.rename(folder)
        except OSError as error:
            raise FormatError(f"The network cannot be written: {error.strerror}.") from None
        return _models(folder)


def _models(folder: Path) -> list[str]:
    return sorted(str(each) for each in folder.iterdir() if each.suffix.lower() == ".onnx")


def _problem(files: Sequence[str], limits: Limits, found: Path) -> str:
    """Return why a network cannot be used, or nothing. It may end the process that opens it."""
    with blocked_signals():
        arguments = (files, limits.memory, found)
        process = worker_context().Process(target=_open, args=arguments, daemon=True)
        process.start()
    process.join(limits.silence)
    process.kill()
    process.join()
    if found.exists():
        return found.read_text(encoding="utf-8")
    why = f"{cause(process.exitcode)}, or it took more than {limits.silence:g} s"
    return f"The network has ended its process ({why}); choose another one."


def _open(files: Sequence[str], memory: int, found: Path) -> None:
    """Open a network, and write what is wrong with it."""
    from motes.sot.network.network import Network

    system.limit_memory(memory)
    try:
        Network(tuple(files)).open()
    except Exception as error:
        found.write_text(explain(error), encoding="utf-8")
    else:
        found.touch()
