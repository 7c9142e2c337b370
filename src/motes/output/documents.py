"""Annotation documents of objects, written complete or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from motes.core.files import write_whole
from motes.output.annotations import coco, cvat
from motes.output.journal import Journal

DOCUMENTS: dict[str, Callable[[Journal], Iterator[bytes]]] = {".json": coco, ".xml": cvat}
"""The writer of each file ending."""


def is_document(name: str) -> bool:
    """Return whether a file name ends like an annotation document."""
    return Path(name).suffix.lower() in DOCUMENTS


def write_document(path: Path, journal: Journal) -> None:
    """Write the document of the kind that the ending gives; it appears at `path` when complete.

    Raises
    ------
    OSError
        If it cannot be written; what was at `path` stays.
    SourceError
        If the journal is damaged.
    """
    write_whole(path, DOCUMENTS[path.suffix.lower()](journal))
