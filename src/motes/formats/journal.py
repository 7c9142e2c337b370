"""The rows of a document whose run was killed: `NAME.rows.jsonl`."""

from __future__ import annotations

from pathlib import Path

from motes.formats.recording import FilmFacts, sound
from motes.formats.text import at
from motes.output.journal import Journal


def read(path: Path, facts: FilmFacts) -> Journal:
    """Return the rows; they hold all that is known of their film."""
    del facts
    found = Journal(path)
    for offset, row in found.rows():
        with at(f"byte {offset}"):
            for each in row.objects:
                sound(each)
    return found
