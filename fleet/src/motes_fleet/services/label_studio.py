"""Label Studio's ML backend: it tracks the rectangles that a user has drawn in a video.

Label Studio asks for `/health`, `/setup` and `/predict`. A request to predict holds the task and,
as its context, the regions drawn so far; the answer continues their sequences to the video's end.
https://labelstud.io/guide/ml_create
"""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from functools import partial
from http.server import BaseHTTPRequestHandler
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit
from xml.etree import ElementTree

import msgspec

from motes import (
    Box,
    ConfigError,
    Ellipse,
    MotesError,
    Status,
    Track,
    Tracker,
    __version__,
    open_source,
)
from motes.core import Alive, Answer, Done, Failed, Worker, WorkerLine, do_tasks, receive
from motes.formats import FilmFacts, guessed, label_studio, recording_of
from motes_fleet.delivery.local_server import Server, reply

SAME_RATE = 1e-3
"""Rates that differ by a smaller share are one: it is less than a frame in half a minute."""
WAITING = 8
"""Requests to predict that wait for their turn at once; there are connections for others then."""
NOTHING = {"error": "There is nothing here; ask for /predict."}


class DrawnRegion(label_studio.VideoRegion):
    """An object that a user has drawn."""

    id: str = ""


class Context(msgspec.Struct):
    """What a user has drawn."""

    result: list[DrawnRegion] = []


class Params(msgspec.Struct):
    """The parameters of a request."""

    context: Context | None = None


class LabelTask(msgspec.Struct):
    """A task: its data, by the names in the labeling configuration."""

    data: dict[str, Any]


class PredictionRequest(msgspec.Struct):
    """A request to predict."""

    tasks: list[LabelTask]
    label_config: str = ""
    params: Params = msgspec.field(default_factory=Params)


def predict(body: bytes, files: Path, preset: str = "default") -> dict[str, Any]:
    """Return the answer to a request.

    Parameters
    ----------
    body
        The request, in JSON.
    files
        The folder of the videos; none outside of it is opened.
    preset
        The preset of the trackers.

    Raises
    ------
    ConfigError
        If the request has another form, or its video is not in the folder.
    SourceError
        If the video cannot be read.
    """
    try:
        request = msgspec.json.decode(body, type=PredictionRequest)
    except (msgspec.MsgspecError, RecursionError) as error:
        raise ConfigError(f"This is not a request of Label Studio: {error}") from None
    box, video, key = tags(request.label_config)
    results = []
    for task in request.tasks:
        drawn = request.params.context.result if request.params.context else []
        chosen = [region for region in drawn if region.value.sequence]
        found = _track(video_path(task.data, key, files), chosen, preset) if chosen else []
        for region in found:
            region["from_name"], region["to_name"] = box, video
        results.append({"result": found, "model_version": version()})
    return {"results": results, "model_version": version()}


def version() -> str:
    """Return the name and version that Label Studio shows."""
    return f"motes {__version__}"


def tags(config: str) -> tuple[str, str, str]:
    """Return the names of the tags of rectangles and of the video, and the key of the video's path.

    Raises
    ------
    ConfigError
        If the labeling configuration has no video with rectangles.
    """
    try:
        root = ElementTree.fromstring(config)
    except ElementTree.ParseError:
        raise ConfigError("The labeling configuration is not XML.") from None
    box, video = root.find(".//VideoRectangle"), root.find(".//Video")
    if box is None or video is None:
        raise ConfigError(
            "The labeling configuration has no Video with a VideoRectangle; use the template for "
            "video object tracking."
        )
    return box.get("name", "box"), video.get("name", "video"), video.get("value", "$video")[1:]


def video_path(data: Mapping[str, Any], key: str, files: Path) -> Path:
    """Return the video of a task: the file in a folder that its path or address ends with.

    Raises
    ------
    ConfigError
        If there is none.
    """
    whole = str(data.get(key, ""))
    try:
        address = urlsplit(whole)
        given = parse_qs(address.query).get("d", [unquote(address.path)])[0]
    except ValueError:
        raise ConfigError(f"{whole!r} is not the address of a video.") from None
    parts = [part for part in Path(given).parts if part not in ("/", "..", ".")]
    root = files.resolve()
    for start in range(len(parts)):
        path = root.joinpath(*parts[start:])
        try:
            if path.exists() and path.resolve().is_relative_to(root):
                return path
        except OSError:  # as of a name that is too long
            break
    raise ConfigError(f"There is no video {given or key} in {files}; put it there.")


def _track(video: Path, drawn: list[DrawnRegion], preset: str) -> list[dict[str, Any]]:
    """Return the regions with the tracks of their targets from each drawn rectangle on."""
    objects: list[Track] = []
    times: dict[int, float] = {}
    keys = [{each.frame - 1: each for each in region.value.sequence} for region in drawn]
    with open_source(str(video)) as film:
        facts = FilmFacts(source=video.name, width=film.width, height=film.height)
        rate = label_studio.rate_of([key for each in keys for key in each.values()])
        if rate and film.fps and abs(rate - film.fps) > SAME_RATE * film.fps:
            raise ConfigError(
                f"Label Studio shows {video.name} at {rate:g} frames a second, and it has "
                f"{film.fps:g}; set the frameRate of the labeling configuration's Video to that."
            )
        trackers: list[Tracker | None] = [None] * len(drawn)
        for frame in film:
            times[frame.index] = frame.time
            for i, region in enumerate(drawn):
                tracker, key = trackers[i], keys[i].get(frame.index)
                if key is not None:
                    tracker = trackers[i] = tracker or Tracker(preset, i)
                    track = tracker.init(frame, _region(key, facts))
                elif tracker is not None:
                    track = tracker.update(frame)
                else:
                    continue
                if key is not None and not key.enabled:  # the object ends here
                    trackers[i] = None
                guess = key is None and guessed(track.status, track.confidence)
                if track.status is Status.TRACKING and not guess:
                    label = next(iter(region.value.labels), None)
                    objects.append(msgspec.structs.replace(track, identity=i + 1, label=label))
    for index in sorted({index for each in keys for index in each} - {*times}):
        raise ConfigError(
            f"A rectangle is in frame {index + 1}, and {video.name} has the frames 1 to "
            f"{len(times)}; check the frame rate of the labeling configuration's Video."
        )
    found = label_studio.regions(recording_of(facts, objects, times))
    names = {f"motes-{i}": region for i, region in enumerate(drawn, start=1)}
    for each in found:
        region = names[each["id"]]
        each["id"] = region.id or each["id"]
        each["value"]["labels"] = region.value.labels
    return found


def _region(key: label_studio.VideoKeyframe, facts: FilmFacts) -> Box | Ellipse:
    """Return where a rectangle was drawn; in one that is turned, the ellipse."""
    if key.rotation:
        try:
            return label_studio.place_of(key, facts)
        except (ValueError, OverflowError) as error:
            raise ConfigError(f"The rectangle in frame {key.frame} is none: {error}.") from None
    x, y = key.x / 100 * facts.width, key.y / 100 * facts.height
    return Box(x, y, key.width / 100 * facts.width, key.height / 100 * facts.height)


class Backend(Server):
    """The server of the backend: it answers in `serve_forever`.

    Requests to predict are answered one after another by a process of their own, so that all others
    are answered meanwhile.

    Parameters
    ----------
    host, port, files, preset
        Where it listens; the folder of the videos and the preset of the trackers.

    Raises
    ------
    ConfigError
        If it cannot listen there.
    """

    def __init__(self, host: str, port: int, files: Path, preset: str) -> None:
        self._task = partial(_predicted, files=files, preset=preset)
        self._room, self._turn = threading.BoundedSemaphore(WAITING), threading.Lock()
        self._worker: Worker | None = None
        super().__init__(host, port, _get, self._post)

    def _post(self, request: BaseHTTPRequestHandler, body: bytes) -> None:
        path = urlsplit(request.path).path
        if path in ("/setup", "/validate"):
            _answer(request, 200, {"model_version": version()})
        elif path in ("/webhook", "/train"):  # there is nothing to train
            _answer(request, 201, {})
        elif path != "/predict":
            _answer(request, 404, NOTHING)
        elif not self._room.acquire(blocking=False):
            _answer(request, 503, {"error": f"{WAITING} requests wait already; try again later."})
        else:
            try:
                with self._turn:
                    answer = self._ask(body)
            finally:
                self._room.release()
            _answer(request, *answer)

    def _ask(self, body: bytes) -> tuple[int, dict[str, Any]]:
        """Return the status and the content of an answer to a request to predict."""
        if self._worker is None:
            self._worker = Worker(do_tasks)
        self._worker.give(partial(self._task, body=body))
        while isinstance(answer := receive(self._worker.pipe, Answer), Alive):
            pass
        if isinstance(answer, Done):
            return msgspec.json.decode(answer.data, type=tuple[int, dict[str, Any]])
        if isinstance(answer, Failed):
            return 500, {"error": f"The tracker failed: {answer.error}"}
        how = self._worker.cause()
        self._end()
        return 500, {"error": f"The tracker has ended ({how})."}

    def _end(self) -> None:
        if self._worker is not None:
            self._worker.end()
        self._worker = None

    def server_close(self) -> None:
        """Stop listening, and end the process."""
        super().server_close()
        self._end()


def _predicted(line: WorkerLine, body: bytes, files: Path, preset: str) -> bytes:
    """Return the status and the content of an answer, in JSON; a task."""
    del line
    try:
        return json.dumps((200, predict(body, files, preset))).encode()
    except MotesError as error:
        return json.dumps((400, {"error": str(error)})).encode()


def _get(request: BaseHTTPRequestHandler) -> None:
    if urlsplit(request.path).path in ("/", "/health"):
        _answer(request, 200, {"status": "UP", "model_class": version()})
    else:
        _answer(request, 404, NOTHING)


def _answer(request: BaseHTTPRequestHandler, status: int, content: Mapping[str, Any]) -> None:
    reply(request, "application/json", json.dumps(content).encode(), status)
