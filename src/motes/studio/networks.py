"""The trained networks of the studio: files that were sent once, for all sessions."""

from __future__ import annotations

import asyncio
import hashlib
import tempfile
from collections.abc import AsyncIterator, Sequence
from functools import partial
from pathlib import Path

from motes.core.errors import ConfigError, FormatError
from motes.studio.processes import Worker, WorkerError
from motes.studio.safety import Limits, plain_name
from motes.studio.workplace import Workplace


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
        digest = hashlib.blake2b(repr((names, sizes)).encode() + data, digest_size=8).hexdigest()
        folder = self._folder / digest
        try:
            with tempfile.TemporaryDirectory(dir=self._folder.parent, prefix=".") as name:
                made = Path(name) / digest
                await asyncio.to_thread(_write, made, names, sizes, data)
                await self._check(made)
                if not folder.exists():
                    made.rename(folder)
        except OSError as error:
            raise FormatError(f"The network cannot be written: {error.strerror}.") from None
        return _models(folder)

    async def _check(self, folder: Path) -> None:
        """Raise a FormatError if a network cannot be used; it may end the worker that opens it."""
        opening = partial(open_network, files=_models(folder))
        worker = Worker("The network", self._limits, opening, remedy="choose another one")
        try:
            await worker.ready()
        except WorkerError as error:
            raise FormatError(str(error).replace(f"{folder}/", "")) from None
        finally:
            worker.close()


def open_network(place: Workplace, files: Sequence[str]) -> bytes:
    """Open a network, and return nothing: the task of a worker that tries it."""
    from motes.sot.network.network import Network

    Network(tuple(files)).open()
    return b""


def _write(folder: Path, names: Sequence[str], sizes: Sequence[int], data: bytearray) -> None:
    folder.mkdir()
    start = 0
    for name, size in zip(names, sizes, strict=True):
        (folder / name).write_bytes(data[start : start + size])
        start += size


def _models(folder: Path) -> list[str]:
    return sorted(str(each) for each in folder.iterdir() if each.suffix.lower() == ".onnx")
