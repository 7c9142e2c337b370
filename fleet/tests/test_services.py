"""The adapters for CVAT and Label Studio, with requests in the form that these tools send."""

from __future__ import annotations

import json
import socket
import struct
import threading
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from PIL import Image

from brokers import wait_until
from motes import Box, ConfigError
from motes.core import WorkerLine, iou
from motes.synthetic import crowd
from motes_fleet.services import cvat_agent, label_studio

SIZE = (160, 120)
CONFIG = (
    '<View><Labels name="videoLabels" toName="clip"><Label value="Cell"/></Labels>'
    '<Video name="clip" value="$film" framerate="25.0"/><VideoRectangle name="rect" toName="clip"/>'
    "</View>"
)


def frames(count: int) -> list[tuple[Any, Box]]:
    """Return the pictures of a moving target, with its boxes."""
    return [(frame.pixels, truths[0].ellipse.box) for frame, truths in crowd(SIZE, (24, 30), count)]


def test_the_box_of_a_polygon_is_around_it() -> None:
    box = cvat_agent.box_of([5.0, 1.0, 9.0, 3.0, 4.0, 8.0])
    assert box == Box(4, 1, 5, 7)
    assert cvat_agent.corners_of(box) == [4, 1, 9, 8]


def test_cvats_agent_runs_the_function() -> None:
    sdk = pytest.importorskip(
        "cvat_sdk.auto_annotation",
        reason="cvat-sdk is not installed; try it in an environment of its own",
    )
    function = cvat_agent.create()
    assert function.spec.supported_shape_types == {"rectangle"}
    film = frames(5)
    first = function.preprocess_image(None, Image.fromarray(film[0][0]))
    shape = sdk.TrackableShape(type="rectangle", points=cvat_agent.corners_of(film[0][1]))
    state = function.init_tracking_state(None, first, shape)
    for pixels, truth in film[1:]:
        found = function.track(
            None, function.preprocess_image(None, Image.fromarray(pixels)), state
        )
        assert found.type == "rectangle"
        assert iou(cvat_agent.box_of(found.points), truth) > 0.6


@pytest.fixture
def videos(tmp_path: Path) -> Path:
    """Return a folder with the film upload/cells: eight images."""
    folder = tmp_path / "upload" / "cells"
    folder.mkdir(parents=True)
    for i, (pixels, _) in enumerate(frames(8)):
        Image.fromarray(pixels).save(folder / f"{i}.png")
    return tmp_path


def request(truth: Box, frame: int, film: str = "/data/upload/cells") -> dict[str, Any]:
    """Return a request as Label Studio sends it when a rectangle has been drawn."""
    percent = [100 * value / SIZE[i % 2] for i, value in enumerate(truth)]
    key = dict(zip(("x", "y", "width", "height"), percent, strict=True))
    sequence = [{"frame": frame, "enabled": True, "rotation": 0, "time": frame / 25, **key}]
    region = {
        "id": "Xw3Tt", "type": "videorectangle", "from_name": "rect", "to_name": "clip",
        "origin": "manual",
        "value": {"framesCount": 8, "duration": 0.32, "sequence": sequence, "labels": ["Cell"]},
    }  # fmt: skip
    return {
        "tasks": [{"id": 7, "data": {"film": film}}], "project": "1.1700000000",
        "label_config": CONFIG, "params": {"context": {"result": [region]}, "login": None},
    }  # fmt: skip


@pytest.mark.slow
def test_label_studio_asks_over_http(videos: Path, capfd: pytest.CaptureFixture[str]) -> None:
    truths = [truth for _, truth in frames(8)]
    answering = label_studio.Backend("127.0.0.1", 0, videos, "default")
    thread = threading.Thread(target=answering.serve_forever)
    thread.start()
    before = threading.active_count()
    address = f"http://127.0.0.1:{answering.server_address[1]}"

    def ask(path: str, content: Any = None) -> tuple[int, Any]:
        data = None if content is None else json.dumps(content).encode()
        try:
            with urllib.request.urlopen(f"{address}{path}", data, timeout=600) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as error:
            return error.code, json.load(error)

    try:
        assert ask("/health")[1]["status"] == "UP"
        assert ask("/setup", {"project": "1", "schema": CONFIG})[0] == 200
        status, answer = ask("/predict", request(truths[2], 3))
        assert status == 200
        (region,) = answer["results"][0]["result"]
        assert (region["id"], region["from_name"], region["to_name"]) == ("Xw3Tt", "rect", "clip")
        assert region["value"]["labels"] == ["Cell"]
        sequence = region["value"]["sequence"]
        assert (sequence[0]["frame"], sequence[-1]["frame"]) == (3, 8)
        last = [sequence[-1][name] / 100 for name in ("x", "y", "width", "height")]
        assert iou(np.multiply(last, [*SIZE, *SIZE]), truths[7]) > 0.6
        status, answer = ask("/predict", {**request(truths[0], 1), "params": {}})
        assert answer["results"][0]["result"] == []
        status, answer = ask("/predict", request(truths[0], 1, "/data/none.mp4"))
        assert (status, "There is no video /data/none.mp4" in answer["error"]) == (400, True)
        assert ask("/nothing")[0] == ask("/nothing", {})[0] == 404
        for name in ("/data/a\0b", "/data/" + 5000 * "a"):
            assert ask("/predict", request(truths[0], 1, name))[0] == 400
        foreign = urllib.request.Request(f"{address}/predict", b"{}", {"Origin": "http://evil"})
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(foreign, timeout=600)
        body = json.dumps(request(truths[0], 1)).encode()
        with socket.create_connection(("127.0.0.1", answering.server_address[1])) as leaving:
            head = f"POST /predict HTTP/1.0\r\nHost: localhost\r\nContent-Length: {len(body)}"
            leaving.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            leaving.sendall(head.encode() + b"\r\n\r\n" + body)
        wait_until(lambda: threading.active_count() == before)
    finally:
        answering.shutdown()
        answering.server_close()
        thread.join()
    assert capfd.readouterr().err == ""  # also of the client that hung up


def test_only_videos_of_the_folder_are_opened(videos: Path, tmp_path: Path) -> None:
    inner = videos / "upload"
    long = "/data/" + 5000 * "a"
    for name in ("/data/../../etc/passwd", "http://host/etc/passwd", "/etc/passwd", "", long):
        with pytest.raises(ConfigError, match="There is no video"):
            label_studio.video_path({"film": name}, "film", inner)
    (inner / "link").symlink_to("/etc")
    with pytest.raises(ConfigError, match="There is no video"):
        label_studio.video_path({"film": "/link/passwd"}, "film", inner)
    with pytest.raises(ConfigError, match="not the address"):
        label_studio.video_path({"film": "http://[x/cells"}, "film", inner)
    address = {"film": "/data/local-files/?d=my/cells"}
    assert label_studio.video_path(address, "film", inner) == (inner / "cells").resolve()


@pytest.mark.parametrize("frame", [0, 9, 500])
def test_rectangles_in_frames_that_the_film_has_not_are_refused(frame: int, videos: Path) -> None:
    """As with a wrong frame rate in the project."""
    asked = json.dumps(request(frames(1)[0][1], frame)).encode()
    with pytest.raises(ConfigError, match=f"is in frame {frame}, and cells has the frames 1 to 8;"):
        label_studio.predict(asked, videos)


def test_a_film_that_label_studio_shows_at_another_rate_is_refused(videos: Path) -> None:
    (videos / "upload/cells/seqinfo.ini").write_text("[Sequence]\nframeRate=24\n")
    asked = json.dumps(request(frames(1)[0][1], 2)).encode()
    with pytest.raises(ConfigError, match="at 25 frames a second, and it has 24; set the frame"):
        label_studio.predict(asked, videos)


def test_a_turned_rectangle_is_where_it_was_drawn(videos: Path) -> None:
    """Turned by a right angle around its upper left corner, it lies to the left of it."""
    x, y, width, height = frames(1)[0][1]
    asked = request(Box(x + width, y, height, width), 1)
    asked["params"]["context"]["result"][0]["value"]["sequence"][0]["rotation"] = 90
    answer = label_studio.predict(json.dumps(asked).encode(), videos)
    found = answer["results"][0]["result"][0]["value"]["sequence"][0]
    percent = [found[name] for name in ("x", "y", "width", "height")]
    seen = Box(*(value / 100 * SIZE[n % 2] for n, value in enumerate(percent)))
    assert iou(seen, Box(x, y, width, height)) > 0.9


def test_a_target_ends_where_its_rectangle_is_switched_off(videos: Path) -> None:
    truths = [truth for _, truth in frames(8)]
    asked = request(truths[0], 1)
    sequence = asked["params"]["context"]["result"][0]["value"]["sequence"]
    (off,) = request(truths[4], 5)["params"]["context"]["result"][0]["value"]["sequence"]
    sequence.append({**off, "enabled": False})
    answer = label_studio.predict(json.dumps(asked).encode(), videos)
    last = answer["results"][0]["result"][0]["value"]["sequence"][-1]
    assert (last["frame"], last["enabled"]) == (5, False)


def _slow(_: WorkerLine, body: bytes, files: Path, preset: str) -> bytes:
    (files / f"begun {preset}").write_bytes(body)
    wait_until((files / "go").exists)
    return b'[200,{"results":[]}]'


@pytest.mark.slow
def test_health_is_told_while_the_tracker_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(label_studio, "_predicted", _slow)
    monkeypatch.setattr(label_studio, "WAITING", 1)
    with label_studio.Backend("127.0.0.1", 0, tmp_path, "default").start() as answering:
        ask = httpx.Client(base_url=answering.address, timeout=600)
        answers: list[httpx.Response] = []
        asking = threading.Thread(target=lambda: answers.append(ask.post("predict", content=b"1")))
        asking.start()
        wait_until((tmp_path / "begun default").exists)
        assert ask.get("health").status_code == 200
        assert ask.post("predict").status_code == 503
        (tmp_path / "go").touch()
        asking.join()
        assert [answer.status_code for answer in answers] == [200]
        answering.shutdown()
