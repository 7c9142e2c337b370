"""A rig on a cluster of three nodes: rows as on one machine, and cameras that move on."""

from __future__ import annotations

import itertools
import os
import re
import signal
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pytest

from motes import ConfigError
from motes.cli import main
from motes_fleet.cameras.camera_report import CameraEnded, CameraMessage, CameraReport
from motes_fleet.cameras.reidentification import REIDENTIFICATION_WINDOW
from motes_fleet.cameras.rig import RigRunner
from motes_fleet.cameras.rig_config import Camera, Rig
from motes_fleet.cluster.ray_connection import connected
from motes_fleet.cluster.rig_on_ray import check_nodes, cluster_rig
from red_box import moving, walk
from streams import camera

LIVES = re.compile("its process ended|its node died|it is back")
ROOMS = """
[[camera]]
name = "hall"
source = "hall.mkv"
place = [{ name = "door", box = [150, 0, 10, 96] }]

[[camera]]
name = "attic"
source = "hall.mkv"

[[camera]]
name = "office"
source = "office.mkv"
offset = 2.0
node = "reaches-hall"
place = [{ name = "door", box = [0, 0, 10, 96] }]

[[passage]]
between = ["hall/door", "office/door"]
seconds = [0.5, 4]
"""


@pytest.fixture(scope="module")
def rooms(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a folder with a rig of three recordings."""
    folder = tmp_path_factory.mktemp("rooms")
    for name, enters in (("hall", 4), ("office", 14)):
        walk(folder / f"{name}.mkv", 52, enters)
    (folder / "rig.toml").write_text(ROOMS)
    return folder


@pytest.mark.slow
def test_recordings_have_the_rows_of_one_machine(
    cluster: Any, rooms: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(rooms)
    summaries = []
    for output, where in (("local.csv", []), ("cluster.csv", ["--cluster", cluster.address])):
        assert main(["watch", "rig.toml", "-o", output, *where]) == 0
        summaries.append(capfd.readouterr().err.replace(output, "").splitlines()[-1])
    assert "2 objects, 1 time handed over" in summaries[0]
    assert summaries[1] == summaries[0]
    rows = Path("local.csv").read_bytes()
    assert rows.count(b"\n") > 80
    assert Path("cluster.csv").read_bytes() == rows


class Watched:
    """What a camera of a cluster has reported, what was said of it, when an object was seen."""

    def __init__(self, news: Iterable[Any]) -> None:
        self._news = iter(news)
        self.reports: list[CameraReport] = []
        self.said: list[str] = []
        self.identities: set[int] = set()
        self.seen_at: list[float] = []

    def until_message(self, number: int) -> None:
        """Go on until so many messages have come, and an object has been seen since."""
        seen = False
        while len(self.said) < number or not seen:
            news = next(self._news)
            if isinstance(news, CameraMessage):
                if LIVES.match(news.text):  # a busy machine has more to say
                    self.said.append(news.text)
                    seen = False
            else:
                assert not isinstance(news, CameraEnded), news.failure
                self.reports.append(news[0])
                self.identities |= set(news[1].values())
                seen = bool(news[1])
                if seen:
                    self.seen_at.append(news[0].time)


@pytest.mark.slow
def test_a_camera_goes_on_when_its_process_and_its_node_are_killed(cluster: Any) -> None:
    with camera(moving) as stream, connected(cluster.address) as ray:
        hall = Camera("hall", stream.url, detector="red_box:red", node="reaches-hall")
        with cluster_rig(ray, Rig((hall,))) as watching:
            watched = Watched(watching)
            watched.until_message(0)
            os.kill(_where(cluster)[1], signal.SIGKILL)
            watched.until_message(2)
            raylet, _ = _where(cluster)
            os.kill(raylet, signal.SIGKILL)
            watched.until_message(4)
            assert _where(cluster)[0] != raylet
    assert [re.sub(r" after .* s\.", "", text) for text in watched.said] == [
        "its process ended. It is started again, with growing pauses.",
        "it is back",
        "its node died. It is started again, with growing pauses.",
        "it is back",
    ]
    unseen = max(after - before for before, after in itertools.pairwise(watched.seen_at))
    if unseen < REIDENTIFICATION_WINDOW:  # a busy machine takes longer to start a process
        assert watched.identities == {1}
    order = [(report.frame, report.time) for report in watched.reports]
    assert all(a < c and b < d for (a, b), (c, d) in itertools.pairwise(order))


@pytest.mark.slow
def test_recordings_go_on_when_actors_and_their_node_are_killed(
    cluster: Any, rooms: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """What follows each kill is as on one machine, to the last digit.

    The office begins after 104 reports of the others. No camera dies twice at the same report.
    """
    monkeypatch.chdir(rooms)
    rig = Rig.parse(Path("rig.toml").read_text())
    with RigRunner(rig) as local:
        whole = [news for news in local if isinstance(news, tuple)]
    found, said = [], list[str]()
    with connected(cluster.address) as ray, cluster_rig(ray, rig) as watching:
        for news in watching:
            if isinstance(news, tuple):
                found.append(news)
                if len(found) in (1, 106):
                    os.kill(_where(cluster)[1], signal.SIGKILL)
                elif len(found) == 110:
                    os.kill(_where(cluster)[0], signal.SIGKILL)
            elif isinstance(news, CameraMessage):
                said.append(news.text)
            else:
                assert news.failure is None
    assert found == whole
    assert any("It is started again" in text for text in said)
    assert capfd.readouterr().out == "", "standard output is for rows"


def _where(cluster: Any) -> tuple[int, int]:
    """Wait for the actor of a camera; return the processes of its node, and of the actor."""
    until = time.monotonic() + 600
    while time.monotonic() < until:
        for node in cluster.list_all_nodes():
            raylet = node.all_processes["raylet"][0].process.pid
            for children in Path(f"/proc/{raylet}/task").glob("*/children"):
                for pid in children.read_text().split():
                    if b"CameraActor" in Path(f"/proc/{pid}/cmdline").read_bytes():
                        return raylet, int(pid)
        time.sleep(0.1)
    raise AssertionError("no process of a camera")


def test_a_camera_that_no_node_reaches_is_pointed_out() -> None:
    nodes = [
        {"Alive": True, "Resources": {"CPU": 2.0, "north": 1.0}},
        {"Alive": False, "Resources": {"CPU": 2.0, "south": 1.0}},
    ]
    north, south = (Camera(name, "0", node=name) for name in ("north", "south"))
    check_nodes(Rig((north, Camera("any", "0"))), nodes)
    with pytest.raises(ConfigError, match="Camera 'south' needs a node with 'south'") as caught:
        check_nodes(Rig((north, south)), nodes)
    assert """--resources '{"south": 1}'""" in str(caught.value)
