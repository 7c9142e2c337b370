"""The protocol's one description, and the page that is too slow."""

from __future__ import annotations

import asyncio
from typing import Any, get_args

import msgspec
import pytest

import loops
from motes.studio import commands, messages, protocol
from motes.studio.clients import AHEAD, Client


def test_every_type_is_described() -> None:
    found = protocol.schema()["$defs"]
    for kind in (*get_args(commands.Command), *get_args(messages.Message)):
        assert found[kind.__name__]["properties"]["type"]["enum"] == [kind.__struct_config__.tag]
        assert "description" in found[kind.__name__], kind
    for kind in get_args(commands.Command):
        assert not found[kind.__name__].get("additionalProperties", True), kind


def test_messages_come_back_as_they_were() -> None:
    for message in (overlay(3), messages.Rows(1, [row(4)]), messages.Reply(4, "no", 5, 6)):
        assert msgspec.json.decode(protocol.encode(message), type=messages.Message) == message


@pytest.mark.parametrize("text", ["", "{}", '{"type":"state"}', '{"type":"undo","id":1.5}'])
def test_what_is_no_command_is_refused(text: str) -> None:
    with pytest.raises(msgspec.MsgspecError):
        protocol.decode(text)


def overlay(frame: int) -> messages.Overlay:
    return messages.Overlay(0, 1, frame, (0, 0, 1, 1, 0), (1, 0, 1), [], [], {})


def row(frame: int) -> messages.Row:
    return messages.Row(
        frame, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, "tracking", None, None, None, (), True, None, None
    )


def test_a_slow_page_misses_overlays_and_no_row() -> None:
    sent: list[Any] = []
    free = asyncio.Event()

    async def send(text: str) -> None:
        await free.wait()
        sent.append(msgspec.json.decode(text, type=messages.Message))

    async def show() -> None:
        client = Client(lambda _, frames: [*map(row, frames)], lambda first: ([], first))
        task = asyncio.create_task(client.run(send))
        for frame in range(2000):
            client.rows(1, [frame])
            client.overlay(overlay(frame))
            client.progress(messages.Progress(1, "track", [1], frame, 2000, None, None, "running"))
            if frame % 100 == 0:
                await asyncio.sleep(0)
        client.send(messages.Reply(1))
        free.set()
        await until(lambda: any(isinstance(each, messages.Reply) for each in sent))
        for frame in range(2000, 2010):
            client.overlay(overlay(frame))
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
    assert sorted(set(rows)) == [*range(2000)]
    assert len(rows) < 2100
    progress = [each for each in sent if isinstance(each, messages.Progress)]
    assert progress[-1].done == 1999
    assert len(progress) <= 3
    assert overlays()[-1].frame == 2009
