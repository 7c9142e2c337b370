"""Messages that wait to be delivered, in a file that outlives the program.

The file is an SQLite database with a write-ahead log: a message is in the file before `put`
returns, and stays there until `remove`. So a `kill -9` loses none. After a loss of power, the file
system decides about the last seconds.
"""

from __future__ import annotations

import contextlib
import sqlite3
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Self

from motes import FormatError

_KIND = 0x6D6F7465
"""The mark of a queue in an SQLite file (`application_id`)."""
_TABLE = """
    CREATE TABLE IF NOT EXISTS message (
        number INTEGER PRIMARY KEY AUTOINCREMENT, receiver TEXT NOT NULL, body TEXT NOT NULL
    )
"""


Message = tuple[int, str]
"""A message that waits: its number in the queue, and its text."""


class MessageQueue:
    """The messages of several receivers, each in order. Any thread may use it.

    Parameters
    ----------
    path
        The file; it may be missing. One program at a time can use it.

    Raises
    ------
    FormatError
        Here and from all methods, if the file is none of a queue, is used by another program, or
        cannot be written.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._changed = threading.Condition()
        with self._problems():
            # Commits are explicit: without `isolation_level`, each statement is one.
            self._data = sqlite3.connect(
                path, timeout=0, isolation_level=None, check_same_thread=False
            )
            try:
                for setting in ("locking_mode=EXCLUSIVE", "journal_mode=WAL", "synchronous=NORMAL"):
                    self._data.execute(f"PRAGMA {setting}").fetchall()
                known = self._data.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
                if known and self._data.execute("PRAGMA application_id").fetchone()[0] != _KIND:
                    raise sqlite3.DatabaseError("file is not a database of motes")
                self._data.execute(f"PRAGMA application_id={_KIND}")
                self._data.execute(_TABLE)
            except BaseException:
                self._data.close()
                raise

    def put(self, receivers: Sequence[str], bodies: Sequence[str]) -> None:
        """Add messages for each of some receivers, all or none of them."""
        rows = [(receiver, body) for body in bodies for receiver in receivers]
        with self._changed, self._problems():
            self._data.execute("BEGIN")
            try:
                self._data.executemany("INSERT INTO message (receiver, body) VALUES (?, ?)", rows)
                self._data.execute("COMMIT")
            except BaseException:
                with contextlib.suppress(sqlite3.Error):
                    self._data.execute("ROLLBACK")
                raise
            self._changed.notify_all()

    def oldest(self, receiver: str, most: int, wait: float) -> list[Message]:
        """Return the oldest messages for a receiver; wait some seconds for one if there is none."""
        with self._changed:
            found = self._oldest(receiver, most)
            if not found and wait > 0 and self._changed.wait(wait):
                found = self._oldest(receiver, most)
            return found

    def _oldest(self, receiver: str, most: int) -> list[Message]:
        query = "SELECT number, body FROM message WHERE receiver = ? ORDER BY number LIMIT ?"
        with self._problems():
            return self._data.execute(query, (receiver, most)).fetchall()

    def remove(self, messages: Sequence[Message]) -> None:
        """Remove messages that have been delivered."""
        numbers = [(number,) for number, _ in messages]
        with self._changed, self._problems():
            self._data.executemany("DELETE FROM message WHERE number = ?", numbers)

    def waiting(self) -> dict[str, int]:
        """Return the number of messages that wait for each receiver that has any."""
        query = "SELECT receiver, count(*) FROM message GROUP BY receiver"
        with self._changed, self._problems():
            return dict(self._data.execute(query).fetchall())

    def wake(self) -> None:
        """End all waiting."""
        with self._changed:
            self._changed.notify_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        with self._changed, self._problems():
            self._data.close()

    @contextlib.contextmanager
    def _problems(self) -> Iterator[None]:
        """Turn an error of the database into a FormatError with what to do."""
        try:
            yield
        except sqlite3.Error as error:
            text = str(error)
            if "locked" in text:
                what = "is used by another run; give each its own with --queue"
            elif "not a database" in text:
                what = "is no queue of events; choose another name with --queue"
            else:
                what = f"cannot be used as a queue of events: {text}; choose another with --queue"
            raise FormatError(f"{self.path} {what}.") from error
