"""The protocol's one description, and the page that is too slow."""

import asyncio
from typing import Any

import msgspec
import numpy as np
import pytest

import loops
from motes import ConfigError, Ellipse, Status, Track
from motes_studio import messages, protocol, tables
from motes_studio.board import Board
from motes_studio.clients import AHEAD, Client
from motes_studio.commands import Places
from motes_studio.tables import Table, line, table_of


def test_messages_come_back_as_they_were() -> None:
    rows = messages.Rows(1, tables.rows(row(4)))
    for message in (overlay(3), rows, messages.Reply(4, "no", 5, 6)):
        assert msgspec.json.decode(protocol.encode(message), type=messages.Message) == message


@pytest.mark.parametrize("text", ["", "{}", '{"type":"state"}', '{"type":"undo","id":1.5}'])
def test_what_is_no_command_is_refused(text: str) -> None:
    with pytest.raises(ConfigError, match="This message is no command"):
        protocol.decode(text)


def overlay(frame: int) -> messages.Overlay:
    return messages.Overlay(0, 1, frame, (0, 0, 1, 1, 0), (1, 0, 1), [], [])


def row(frame: int) -> Table:
    """Return a row of an object."""
    track = Track(frame, 0.0, Ellipse(0, 0, 1, 1), np.eye(5), 1.0, Status.TRACKING, 0.0, 0.0)
    return table_of([line(track, [], final=True)], 0)


def test_a_slow_page_misses_overlays_and_no_row() -> None:
    sent: list[Any] = []
    free = asyncio.Event()
    frames = 2000
    film = messages.OpenFilm("film", 8, 8, frames, 25.0)

    async def send(text: str) -> None:
        await free.wait()
        sent.append(msgspec.json.decode(text, type=messages.Message))

    def state() -> messages.WholeSession:
        jobs = [job.progress() for job in board.jobs.values()]
        return messages.WholeSession("a", film, 1, [], Places(), jobs, 0.0, False, False)

    board = Board(frames)

    async def show() -> None:
        client = Client(board, state, lambda first: (None, first))
        board.news.add(client.news)
        board.void(1, 0)
        job = board.begin_job("track", [1])
        task = asyncio.create_task(client.run(send))
        for frame in range(frames):
            board.show(1, row(frame))
            board.overlay(overlay(frame))
            job.done = frame
            board.progress(job)
            if frame % 100 == 0:
                await asyncio.sleep(0)
        client.reply(messages.Reply(1))
        free.set()
        await until(lambda: any(isinstance(each, messages.Reply) for each in sent))
        for frame in range(2000, 2010):
            board.overlay(overlay(frame))
            await asyncio.sleep(0.001)
        assert len(overlays()) == AHEAD
        client.acknowledge(overlays()[-1].number)
        client.acknowledge(10**9)
        await until(lambda: len(overlays()) > AHEAD)
        task.cancel()

    def overlays() -> list[messages.Overlay]:
        return [each for each in sent if isinstance(each, messages.Overlay)]

    async def until(done: Any) -> None:
        while not done():
            await asyncio.sleep(0.001)

    loops.run(show(), 600)
    batches = [message.rows for message in sent if isinstance(message, messages.Rows)]
    rows = [each.frame for batch in batches for each in batch]
    assert sorted(set(rows)) == [*range(frames)]
    assert len(rows) < frames + 200
    progress = [each for each in sent if isinstance(each, messages.Progress)]
    assert progress[-1].done == frames - 1
    assert len(progress) <= 3
    assert overlays()[-1].frame == 2009


def test_pages_see_what_is_new() -> None:
    """A page that comes later sees all there is then."""
    board = Board(10)
    board.void(1, 0)
    board.show(1, row(3))
    seen = board.now
    board.show(1, row(5))
    assert [[each.frame for each in rows.rows] for rows in board.rows_since(seen)] == [[5]]
    assert [rows.reset for rows in board.rows_since(0)] == [True, False]
    seen = board.now
    board.outdate(1, 4, 9)
    ((outdated,),) = (rows.rows for rows in board.rows_since(seen))
    assert (outdated.frame, outdated.final) == (5, False)
    assert len(board.rows(1, 0, 9)) == 2
    board.void(1, 0)
    assert not len(board.rows(1, 0, 9))
    for _ in range(30):
        board.begin_job("track", [1]).status = "done"
    assert [*board.jobs] == [*range(10, 31)]
