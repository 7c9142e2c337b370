"""The sessions on disk: each change is in the file before it is answered, and survives a kill."""

from __future__ import annotations

import contextlib
import datetime
import os
import secrets
import sqlite3
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from motes import FormatError
from motes_studio.document import Document
from motes_studio.messages import SessionCard

SCHEMA = """
CREATE TABLE IF NOT EXISTS session (
    id TEXT PRIMARY KEY, film TEXT, uploaded INTEGER, place INTEGER, tracked TEXT, changed TEXT
) STRICT;
CREATE TABLE IF NOT EXISTS document (
    session TEXT REFERENCES session ON DELETE CASCADE, place INTEGER, content BLOB,
    PRIMARY KEY (session, place)
) STRICT;
CREATE TABLE IF NOT EXISTS part (
    session TEXT REFERENCES session ON DELETE CASCADE, key TEXT, number INTEGER, content BLOB,
    PRIMARY KEY (session, key, number)
) STRICT;
"""
VERSION = 3


class Store:
    """Sessions in an SQLite file. Only one thread uses it at a time.

    Parameters
    ----------
    path
        The file; it is made with its folder.

    Raises
    ------
    FormatError
        From all methods, if the file cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with self._problems():
            path.parent.mkdir(parents=True, exist_ok=True)
            self._base = sqlite3.connect(
                path, isolation_level=None, timeout=10, check_same_thread=False
            )
            try:
                for kept in ("journal_mode=WAL", "synchronous=NORMAL", "foreign_keys=ON"):
                    self._base.execute(f"PRAGMA {kept}")
                version = self._base.execute("PRAGMA user_version").fetchone()[0]
                if version not in (0, VERSION):
                    raise FormatError(f"{path} is of another version of motes; move it away.")
                self._base.executescript(SCHEMA)
                self._base.execute(f"PRAGMA user_version={VERSION}")
            except BaseException:
                self._base.close()
                raise

    def close(self) -> None:
        """Close the file."""
        self._base.close()

    def sessions(self) -> list[SessionCard]:
        """Return all sessions, the one that changed last first."""
        query = """
            SELECT id, film, changed, content, EXISTS
                (SELECT 1 FROM part WHERE part.session = id AND key = 'scene') FROM session
            JOIN document ON document.session = id AND document.place = session.place
            ORDER BY changed DESC"""
        return [
            SessionCard(number, film, len(_document(content).targets), bool(counted), changed)
            for number, film, changed, content, counted in self._rows(query)
        ]

    def of_film(self, film: str, *, uploaded: bool) -> list[tuple[str, bool]]:
        """Return the sessions of a film, the one that changed last first.

        Each comes with whether anything was ever done in it.
        """
        query = """
            SELECT id, EXISTS (SELECT 1 FROM document WHERE session = id AND place > 0)
                OR EXISTS (SELECT 1 FROM part WHERE session = id AND key = 'scene run')
            FROM session WHERE film = ? AND uploaded = ? ORDER BY changed DESC"""
        return [(name, bool(touched)) for name, touched in self._rows(query, film, uploaded)]

    def begin(self, film: str, *, uploaded: bool) -> str:
        """Make a session, and return its name."""
        name = secrets.token_hex(8)
        with self._change():
            self._base.execute(
                "INSERT INTO session VALUES (?, ?, ?, 0, '[]', ?)", (name, film, uploaded, _now())
            )
            self._put(name, 0, Document())
        return name

    def remove(self, session: str) -> None:
        """Remove a session with all that belongs to it."""
        with self._change():
            self._base.execute("DELETE FROM session WHERE id = ?", (session,))

    def session(self, session: str) -> tuple[str, bool, int, list[int]]:
        """Return a session's film, and whether that is uploaded; its place; the tracked objects.

        The place is that of its document among all. Raise a FormatError if there is no session.
        """
        query = "SELECT film, uploaded, place, tracked FROM session WHERE id = ?"
        rows = self._rows(query, session)
        if not rows:
            raise FormatError("There is no such session; choose one of the list.")
        ((film, uploaded, place, tracked),) = rows
        return film, bool(uploaded), place, msgspec.json.decode(tracked, type=list[int])

    def document(self, session: str, place: int) -> Document:
        """Return a document of a session."""
        query = "SELECT content FROM document WHERE session = ? AND place = ?"
        ((content,),) = self._rows(query, session, place)
        return _document(content)

    def last_place(self, session: str) -> int:
        """Return the place of the last document, to which changes can be made again."""
        query = "SELECT max(place) FROM document WHERE session = ?"
        ((place,),) = self._rows(query, session)
        return int(place)

    def change(self, session: str, place: int, document: Document) -> None:
        """Put a new document at a place; those behind it, which were taken back, are forgotten."""
        with self._change():
            self._base.execute(
                "DELETE FROM document WHERE session = ? AND place >= ?", (session, place)
            )
            self._put(session, place, document)
            self._go(session, place)

    def rewrite(self, session: str, change: Callable[[Document], Document], key: str) -> None:
        """Change all documents of a session, also those taken back; the data of `key` are used."""
        query = "SELECT place, content FROM document WHERE session = ?"
        with self._change():
            for place, content in self._rows(query, session):
                changed = msgspec.json.encode(change(_document(content)))
                self._base.execute(
                    "UPDATE document SET content = ? WHERE session = ? AND place = ?",
                    (changed, session, place),
                )
            self._base.execute(
                "UPDATE part SET content = x'' WHERE session = ? AND key = ?", (session, key)
            )

    def go(self, session: str, place: int) -> None:
        """Take the document at another place: undo and redo."""
        with self._change():
            self._go(session, place)

    def set_tracked(self, session: str, objects: list[int]) -> None:
        """Keep which objects have been tracked."""
        with self._change():
            self._base.execute(
                "UPDATE session SET tracked = ? WHERE id = ?",
                (msgspec.json.encode(objects).decode(), session),
            )

    def parts(self, session: str, key: str) -> bytes:
        """Return the computed data of a key: its parts in order; empty if there are none."""
        return b"".join(self.parts_from(session, key))

    def parts_from(self, session: str, key: str, first: int = 0, most: int = -1) -> list[bytes]:
        """Return parts of a key from number `first` on, `most` at most; all, if that is -1."""
        query = """
            SELECT content FROM part WHERE session = ? AND key = ? AND number >= ?
            ORDER BY number LIMIT ?"""
        return [row[0] for row in self._rows(query, session, key, first, most)]

    def add_part(self, session: str, key: str, data: bytes) -> None:
        """Add computed data to those of a key."""
        query = """
            INSERT INTO part SELECT ?, ?, coalesce(max(number) + 1, 0), ? FROM part
            WHERE session = ? AND key = ?"""
        with self._change():
            self._base.execute(query, (session, key, data, session, key))

    def replace_parts(self, session: str, key: str, data: bytes) -> None:
        """Keep these computed data of a key, and no others."""
        with self._change():
            self._base.execute("DELETE FROM part WHERE session = ? AND key = ?", (session, key))
            self._base.execute("INSERT INTO part VALUES (?, ?, 0, ?)", (session, key, data))

    def forget(self, session: str, key: str) -> None:
        """Remove the computed data of a key."""
        with self._change():
            self._base.execute("DELETE FROM part WHERE session = ? AND key = ?", (session, key))

    def _rows(self, query: str, *values: str | int) -> list[tuple[Any, ...]]:
        with self._problems():
            return self._base.execute(query, values).fetchall()

    def _put(self, session: str, place: int, document: Document) -> None:
        content = msgspec.json.encode(document)
        self._base.execute("INSERT INTO document VALUES (?, ?, ?)", (session, place, content))

    def _go(self, session: str, place: int) -> None:
        self._base.execute(
            "UPDATE session SET place = ?, changed = ? WHERE id = ?", (place, _now(), session)
        )

    @contextlib.contextmanager
    def _change(self) -> Iterator[None]:
        """Make all changes of the block, or none."""
        with self._problems():
            self._base.execute("BEGIN IMMEDIATE")
            try:
                yield
            except BaseException:
                self._base.execute("ROLLBACK")
                raise
            self._base.execute("COMMIT")

    @contextlib.contextmanager
    def _problems(self) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, OSError) as error:
            raise FormatError(
                f"{self._path} cannot be used ({error}); make room, or move it away."
            ) from None


def _document(content: bytes) -> Document:
    return msgspec.json.decode(content, type=Document)


def _now() -> str:
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds")


def data_folder() -> Path:
    """Return the user's folder for data of motes, where the system wants it.

    Raises a RuntimeError if the user has no home folder, as in some containers.
    """
    if sys.platform == "win32":
        folder = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        folder = Path.home() / "Library" / "Application Support"
    else:
        folder = Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share")
    return folder / "motes"
