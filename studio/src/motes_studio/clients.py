"""The pages that look at a session: rows wait for a slow page, pictures do not."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator

from msgspec.structs import replace

from motes_studio.board import Board
from motes_studio.messages import FoundScene, Message, Overlay, Reply, State, WholeSession
from motes_studio.protocol import encode

AHEAD = 3
"""Overlays that a page gets before it has acknowledged the first of them."""

SceneFrom = Callable[[int], tuple[FoundScene | None, int]]
"""Returns the many-object mode from a part on, and the number of the part after."""


class Client:
    """What a page has seen, and what it has still to get.

    Parameters
    ----------
    board
        What there is to see.
    state, scene_from
        The session without rows, and the parts of its many-object mode.
    """

    def __init__(
        self, board: Board, state: Callable[[], WholeSession], scene_from: SceneFrom
    ) -> None:
        self._board, self._state, self._scene_from = board, state, scene_from
        self._seen = self._part = 0
        self._painted = board.now
        self._replies: list[Reply] = []
        self._number = self._acknowledged = 0
        self._ended = False
        self.news = asyncio.Event()
        self.news.set()

    def reply(self, reply: Reply) -> None:
        """Send a reply; it comes after all that its command has changed."""
        self._replies.append(reply)
        self.news.set()

    def acknowledge(self, number: int) -> None:
        """Note that the page has drawn an overlay."""
        self._acknowledged = max(self._acknowledged, min(number, self._number))
        self.news.set()

    def end(self) -> None:
        """Let the page come again: the session is opened anew."""
        self._ended = True
        self.news.set()

    async def run(self, send: Callable[[str], Awaitable[None]]) -> None:
        """Send what is new, until the page is to come again, or cancelled."""
        while not self._ended:
            await self.news.wait()
            self.news.clear()
            for message in self._batch():
                await send(encode(message))
            for message in self._newest_overlays():
                await send(encode(message))

    def _batch(self) -> Iterator[Message]:
        """Yield all that is new; what comes meanwhile is of the next batch.

        Rows come before the progress and the reply that follow from them.
        """
        board, seen, replies = self._board, self._seen, self._replies
        self._seen, self._replies = board.now, []
        rows = board.rows_since(seen)
        if board.state > seen:
            yield State(self._state())
        yield from rows
        if board.scene_begun > seen:
            self._part = 0
        if board.scene > seen:
            yield from self._scene()
        if seen:  # the first state has all jobs
            for job in [*board.jobs.values()]:
                if job.changed > seen:
                    yield job.progress()
        yield from replies

    def _scene(self) -> Iterator[FoundScene]:
        more = True
        while more:
            before = self._part
            scene, self._part = self._scene_from(before)
            more = self._part > before
            if scene is not None:
                yield scene

    def _newest_overlays(self) -> Iterator[Overlay]:
        for changed, overlay in sorted(self._board.overlays.values(), key=lambda each: each[0]):
            if changed > self._painted and self._number - self._acknowledged < AHEAD:
                self._painted = changed
                self._number += 1
                yield replace(overlay, number=self._number)
