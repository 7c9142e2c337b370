"""Handover actors that end in the middle: the next process gives what the first would have given.

Reports are those of simulated cameras. A run without an end is what all others must equal.
"""

from __future__ import annotations

import asyncio
import random
from collections.abc import Mapping, Sequence

import msgspec
import pytest

import loops
from handovers import Meeting, settled
from motes.cluster import handover_actor
from motes.cluster.rig_messages import Associated, GroupNews, Restart
from motes.mot.cameras.camera_report import CameraReport
from motes.mot.cameras.messages import CameraEnded, CameraReady, NextFrame
from simulated_cameras import Building, Simulation

Run = tuple[list[GroupNews | Restart], list[bytes | None]]
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


def live(building: Building, seconds: float, rng: random.Random | None) -> Run:
    """Return the news and the answers of a run of live cameras, which send one after the other.

    `rng` determines between which messages the actor ends, and how much later; None for no end.
    """
    rig, reports = building.rig(), reports_of(building, seconds)
    moments = rng.sample(range(len(reports)), ENDS) if rng is not None else ()

    async def play() -> Run:
        meeting, answers = Meeting(rig), []
        for camera in rig.camera:
            await meeting.send(camera.name, CameraReady(camera.name, True))
        for n, report in enumerate(reports):
            answer = meeting.send(report.camera, report)
            if rng is not None and n in moments:
                await _turns(rng)
                meeting.kill()
            answers.append(await answer)
            await settled()
        for camera in rig.camera:
            await meeting.send(camera.name, CameraEnded(camera.name, 1))
        return meeting.news, answers

    return loops.run(play(), 600)


def recorded(building: Building, seconds: float, rng: random.Random | None) -> Run:
    """Return the news and the answers of a run of recordings, which all send at once."""
    rig, reports = building.rig(), reports_of(building, seconds)

    async def play() -> Run:
        meeting = Meeting(rig)

        async def film(name: str) -> list[bytes | None]:
            answers, last = [], None
            await meeting.send(name, CameraReady(name, False))
            for report in [each for each in reports if each.camera == name]:
                go = meeting.send(name, NextFrame(report.time))
                if last is not None:
                    await meeting.send(name, last)
                answers.append(await go)
                last = report
            assert last is not None
            await meeting.send(name, last)
            await meeting.send(name, CameraEnded(name, 1))
            return answers

        films = asyncio.gather(*(film(camera.name) for camera in rig.camera))
        while rng is not None and not films.done():
            for _ in range(20):
                await _turns(rng)
            meeting.kill()
        found = await films
        return meeting.news, [answer for answers in found for answer in answers]

    return loops.run(play(), 600)


async def _turns(rng: random.Random) -> None:
    """Let tasks go on for a random number of turns: a call and its answer take some ten."""
    for _ in range(rng.randrange(15)):
        await asyncio.sleep(0)


def identities(news: Sequence[GroupNews | Restart]) -> list[tuple[str, int, Mapping[int, int]]]:
    """Return the identities of each report."""
    return [
        (each.report.camera, each.report.frame, each.identities)
        for each in news
        if isinstance(each, Associated)
    ]


def numbers(news: Sequence[GroupNews | Restart]) -> set[int]:
    """Return all identities of some reports."""
    return {number for *_, found in identities(news) for number in found.values()}


def test_live_cameras_go_on_as_if_no_actor_had_ended() -> None:
    """Identities and arrivals are the same; each report is used once."""
    whole, answers = live(PAIRS, 6.0, None)
    assert len(numbers(whole)) > 4
    assert len({*answers}) > 1, "no camera was ever told what to expect"
    for seed in range(2):
        assert live(PAIRS, 6.0, random.Random(seed)) == (whole, answers)


def test_recordings_go_on_as_if_no_actor_had_ended() -> None:
    whole, answers = recorded(PAIRS, 6.0, None)
    assert len(numbers(whole)) > 4
    assert len({*answers}) > 1
    for seed in range(2):
        assert recorded(PAIRS, 6.0, random.Random(seed)) == (whole, answers)


def test_the_program_holds_little() -> None:
    """It gets the state in place of the entries before they are many."""
    building = Building(1, 1)
    name = building.rig().camera[0].name

    async def play() -> list[int]:
        meeting, held = Meeting(building.rig()), []
        await meeting.send(name, CameraReady(name, True))
        for report in reports_of(building, 12.0):
            await meeting.send(name, report)
            entries = map(msgspec.msgpack.decode, meeting.held.entries)
            held.append(sum(map(len, entries)))
        return held

    held = loops.run(play(), 600)
    assert len(held) > 100
    assert 10 < max(held) < 20
