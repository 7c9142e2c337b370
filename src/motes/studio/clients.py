"""The pages that look at a session: rows wait for a slow page, pictures do not."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Iterator

from msgspec.structs import replace

from motes.studio.messages import Message, Overlay, Progress, Reply, Row, Rows, State
from motes.studio.protocol import encode

AHEAD = 3
"""Overlays that a page gets before it has acknowledged the first of them."""
ROWS = 500
"""Rows of a message at most."""

RowsOf = Callable[[int, list[int]], list[Row]]
"""Returns the rows of an object in these frames, as they are now."""


SceneFrom = Callable[[int], tuple[list[Message], int]]
"""Returns messages of the many-object mode from a part on, and the number of the part after."""


class Client:
    """What a page has still to get.

    Of what changes, only the newest state waits: the rows by object and frame, the progress by job.
    So a slow page needs no more memory than the session itself, and loses no row.

    Parameters
    ----------
    rows_of, scene_from
        The rows of the session, and the parts of its many-object mode.
    """

    def __init__(self, rows_of: RowsOf, scene_from: SceneFrom) -> None:
        self._rows_of, self._scene_from = rows_of, scene_from
        self._part = 0
        self._messages: list[Message] = []
        self._replies: list[Reply] = []
        self._rows: dict[int, dict[int, None]] = {}
        self._resets: set[int] = set()
        self._progress: dict[int, Progress] = {}
        self._overlays: dict[int, Overlay] = {}
        self._number = self._acknowledged = 0
        self._more = self._ended = False
        self._news = asyncio.Event()

    def send(self, message: Message) -> None:
        """Send a message; a reply comes after all that its command has changed."""
        if isinstance(message, Reply):
            self._replies.append(message)
        else:
            if isinstance(message, State):
                self._messages = [each for each in self._messages if not isinstance(each, State)]
            self._messages.append(message)
        self._news.set()

    def rows(self, number: int, frames: Iterable[int]) -> None:
        """Send the rows of an object in these frames."""
        self._rows.setdefault(number, {}).update(dict.fromkeys(frames))
        self._news.set()

    def reset(self, number: int) -> None:
        """Let all rows of an object be void."""
        self._resets.add(number)
        self._rows.pop(number, None)
        self._overlays.pop(number, None)
        self._news.set()

    def progress(self, progress: Progress) -> None:
        """Send the state of a job."""
        self._progress[progress.job] = progress
        self._news.set()

    def overlay(self, overlay: Overlay) -> None:
        """Send an overlay, unless the page is slow."""
        self._overlays[overlay.object] = overlay
        self._news.set()

    def scene(self, *, reset: bool = False) -> None:
        """Send what the many-object mode has found and the page has not."""
        self._part = 0 if reset else self._part
        self._more = True
        self._news.set()

    def acknowledge(self, number: int) -> None:
        """Note that the page has drawn an overlay."""
        self._acknowledged = max(self._acknowledged, min(number, self._number))
        self._news.set()

    def end(self) -> None:
        """Let the page come again: the session is opened anew."""
        self._ended = True
        self._news.set()

    async def run(self, send: Callable[[str], Awaitable[None]]) -> None:
        """Send what waits, until the page is to come again, or cancelled."""
        while not self._ended:
            await self._news.wait()
            self._news.clear()
            for message in self._batch():
                await send(encode(message))
            for message in self._newest_overlays():
                await send(encode(message))

    def _batch(self) -> Iterator[Message]:
        """Yield all that waits now; what comes meanwhile is of the next batch.

        Rows come before the progress and the reply that follow from them.
        """
        messages, resets, rows = self._messages, self._resets, self._rows
        progress, replies, more = self._progress, self._replies, self._more
        self._messages, self._resets, self._rows = [], set(), {}
        self._progress, self._replies, self._more = {}, [], False
        yield from messages
        for number in resets:
            yield Rows(number, [], reset=True)
        for number, known in rows.items():
            frames = sorted(known)
            for i in range(0, len(frames), ROWS):
                found = self._rows_of(number, frames[i : i + ROWS])
                if found:
                    yield Rows(number, found)
        while more:
            before = self._part
            found_parts, self._part = self._scene_from(before)
            more = self._part > before
            yield from found_parts
        yield from progress.values()
        yield from replies

    def _newest_overlays(self) -> Iterator[Overlay]:
        while self._overlays and self._number - self._acknowledged < AHEAD:
            overlay = self._overlays.pop(next(iter(self._overlays)))
            self._number += 1
            yield replace(overlay, number=self._number)
