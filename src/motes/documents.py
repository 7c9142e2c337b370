"""Documents of objects, written whole or not at all."""

from __future__ import annotations

import os
import secrets
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from motes.annotations import coco, cvat
from motes.journal import Journal

DOCUMENTS: dict[str, Callable[[Journal], Iterator[bytes]]] = {".json": coco, ".xml": cvat}
"""By file ending."""


def is_document(name: str) -> bool:
    """Return whether a file is a document, by its ending."""
    return Path(name).suffix.lower() in DOCUMENTS


def write_document(path: Path, journal: Journal) -> None:
    """Write the document that a name's ending asks for; nothing is at `path` before it is whole.

    Raises
    ------
    OSError
        If it cannot be written; what was at `path` stays.
    SourceError
        If the journal is damaged.
    """
    pieces = DOCUMENTS[path.suffix.lower()](journal)
    path = path.resolve()
    if path.exists() and not path.is_file():  # a pipe or device must not be replaced
        with path.open("wb") as file:
            file.writelines(pieces)
        return
    partial = path.with_name(f"{path.name}.{secrets.token_hex(4)}.partial")
    try:
        _write(partial, pieces)
        partial.replace(path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def _write(path: Path, pieces: Iterable[bytes]) -> None:
    with path.open("xb") as file:
        file.writelines(pieces)
        file.flush()
        os.fsync(file.fileno())  # some file systems say only then that they are full
