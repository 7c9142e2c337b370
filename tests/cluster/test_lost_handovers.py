"""Handover actors that end in the middle: the next process gives what the first would have given.

Reports are those of simulated cameras. A run without an end is what all others must equal.
"""

from __future__ import annotations

import asyncio
import random
import types
from collections.abc import Mapping, Sequence

import msgspec
import pytest

import loops
from handovers import Handovers, settled
from motes.cluster import handover_actor
from motes.cluster.handover_part import HandoverPart
from motes.cluster.rig_messages import Associated, Heard, PartNews, Restart
from motes.mot.cameras.bordered import BorderedAssociation, Merged, News
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import CameraEnded, NextFrame, Ready
from motes.mot.cameras.neighborhoods import parts_of
from simulated_cameras import Building, Simulation

Run = tuple[list[list[PartNews | Restart]], list[bytes | None]]
PAIRS = Building(1, 3, cameras=2)
"""Rooms with two cameras that see the same ground."""
ENDS = 12
"""Number of ends of an actor in a run."""


@pytest.fixture(autouse=True)
def _short_log(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the program get the state often: after 20 entries."""
    monkeypatch.setattr(handover_actor, "LOG", 20)


def reports_of(building: Building, seconds: float) -> list[CameraReport]:
    """Return the reports of simulated cameras, in the order of time."""
    return [*Simulation(building, seconds, people=1.5).reports()]


def live(building: Building, seconds: float, largest: int, rng: random.Random | None) -> Run:
    """Return the news and the answers of a run of live cameras, which send one after the other.

    `rng` determines between which messages actors end, and how much later; None for no end.
    """
    rig, reports = building.rig(), reports_of(building, seconds)
    parts = parts_of(rig, largest)
    moments = rng.sample(range(len(reports)), ENDS) if rng is not None else ()

    async def play() -> Run:
        handovers, answers = Handovers(rig, parts), []
        for camera in rig.camera:
            await handovers.send(camera.name, Ready(camera.name, True))
        for n, report in enumerate(reports):
            answer = handovers.send(report.camera, report)
            if rng is not None and n in moments:
                await _turns(rng)
                handovers.kill(rng.randrange(len(parts)))
            answers.append(await answer)
            await settled()
        for camera in rig.camera:
            await handovers.send(camera.name, CameraEnded(camera.name, 1))
        return handovers.news, answers

    return loops.run(play(), 60)


def recorded(building: Building, seconds: float, rng: random.Random | None) -> Run:
    """Return the news and the answers of a run of recordings, which all send at once."""
    rig, reports = building.rig(), reports_of(building, seconds)

    async def play() -> Run:
        handovers = Handovers(rig, [tuple(camera.name for camera in rig.camera)])

        async def film(name: str) -> list[bytes | None]:
            answers, last = [], None
            await handovers.send(name, Ready(name, False))
            for report in [each for each in reports if each.camera == name]:
                go = handovers.send(name, NextFrame(report.time))
                if last is not None:
                    await handovers.send(name, last)
                answers.append(await go)
                last = report
            assert last is not None
            await handovers.send(name, last)
            await handovers.send(name, CameraEnded(name, 1))
            return answers

        films = asyncio.gather(*(film(camera.name) for camera in rig.camera))
        while rng is not None and not films.done():
            for _ in range(20):
                await _turns(rng)
            handovers.kill()
        found = await films
        return handovers.news, [answer for answers in found for answer in answers]

    return loops.run(play(), 60)


async def _turns(rng: random.Random) -> None:
    """Let tasks go on for a random number of turns: a call and its answer take some ten."""
    for _ in range(rng.randrange(15)):
        await asyncio.sleep(0)


def identities(news: Sequence[PartNews | Restart]) -> list[tuple[str, int, Mapping[int, int]]]:
    """Return the identities of each report."""
    return [
        (each.report.camera, each.report.frame, each.identities)
        for each in news
        if isinstance(each, Associated)
    ]


def numbers(news: Sequence[PartNews | Restart]) -> set[int]:
    """Return all identities of some reports."""
    return {number for *_, found in identities(news) for number in found.values()}


def test_live_cameras_go_on_as_if_no_actor_had_ended() -> None:
    """Identities and arrivals are the same; each report is used once."""
    whole, answers = live(PAIRS, 6.0, 100, None)
    assert len(numbers(whole[0])) > 4
    assert len({*answers}) > 1, "no camera was ever told what to expect"
    for seed in range(3):
        assert live(PAIRS, 6.0, 100, random.Random(seed)) == (whole, answers)


def test_recordings_go_on_as_if_no_actor_had_ended() -> None:
    whole, answers = recorded(PAIRS, 6.0, None)
    assert len(numbers(whole[0])) > 4
    assert len({*answers}) > 1
    for seed in range(3):
        assert recorded(PAIRS, 6.0, random.Random(seed)) == (whole, answers)


def test_parts_hear_all_news_of_others_once_and_in_their_order() -> None:
    pytest.importorskip("ray", reason="news go through ray: pip install 'motes[cluster]'")
    building = Building(2, 2)
    whole, answers = live(building, 8.0, 2, None)
    assert numbers(whole[0]) & numbers(whole[1]), "nobody has crossed the border"
    for seed in range(3):
        assert live(building, 8.0, 2, random.Random(seed)) == (whole, answers)


def test_news_that_overlap_are_used_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A part that begins again repeats news that others may have, and newer ones with them."""
    heard: list[News] = []
    monkeypatch.setattr(BorderedAssociation, "hear", lambda _, news: heard.extend(news))
    part = HandoverPart(Building(1, 1).rig(), [("0.0",)], 0)
    news: list[News] = [Merged(n + 1, n) for n in range(5)]
    for first, end in ((0, 2), (0, 2), (1, 4), (4, 5)):
        part.use(Heard(1, first, msgspec.msgpack.encode(news[first:end])))
    assert heard == news


def test_news_are_answered_when_the_program_holds_them() -> None:
    async def play() -> None:
        handovers = Handovers(Building(1, 1).rig(), [("0.0",)])
        await settled()
        handovers.listening.clear()
        handovers.send("0.0", Ready("0.0", True))
        await settled()
        data = msgspec.msgpack.encode([Merged(2, 1)])
        answer = handovers.peer(0).hear.remote(1, 0, 1, data)
        await settled()
        assert not answer.done()
        handovers.kill()
        handovers.listening.set()
        await answer
        assert handovers.part().has_heard(1, 1)

    loops.run(play(), 60)


def test_news_wait_until_the_program_holds_the_batch() -> None:
    """Also news that come while earlier ones are on the way to the other part."""
    pytest.importorskip("ray", reason="news go through ray: pip install 'motes[cluster]'")
    building = Building(1, 2)

    async def play() -> None:
        heard: list[asyncio.Future[None]] = []

        def hear(*_: object) -> asyncio.Future[None]:
            heard.append(asyncio.get_running_loop().create_future())
            return heard[-1]

        peer = types.SimpleNamespace(hear=types.SimpleNamespace(remote=hear))
        actor = handover_actor.HandoverActor(building.rig(), [("0.0",), ("0.1",)], 0)
        batch = asyncio.ensure_future(actor.start({1: peer}, 0, None, []))
        messages = [Ready("0.0", True), *(CameraReport("0.0", n, n / 10, ()) for n in range(2))]
        calls = []
        for number, message in enumerate(messages):
            data = msgspec.msgpack.encode(message)
            calls.append(asyncio.ensure_future(actor.receive("0.0", 0, number, data)))
            await settled()
            if number < 2:
                batch = asyncio.ensure_future(actor.take(number + 1))
                await settled()
        assert len(heard) == 1
        assert batch.done()  # and on its way to the program, with the news of the last report
        heard[0].set_result(None)
        await settled()
        assert len(heard) == 1
        batch = asyncio.ensure_future(actor.take(3))
        await settled()
        assert len(heard) == 2

    loops.run(play(), 60)


def test_the_program_holds_little() -> None:
    """It gets the state in place of the entries before they are many."""
    building = Building(1, 1)
    name = building.rig().camera[0].name

    async def play() -> list[int]:
        handovers, held = Handovers(building.rig(), [(name,)]), []
        await handovers.send(name, Ready(name, True))
        for report in reports_of(building, 12.0):
            await handovers.send(name, report)
            entries = map(msgspec.msgpack.decode, handovers.held[0].entries)
            held.append(sum(map(len, entries)))
        return held

    held = loops.run(play(), 60)
    assert len(held) > 100
    assert 10 < max(held) < 20
