"""The metrics of `motes watch`, on a page that Prometheus reads."""

from __future__ import annotations

import time
from collections import Counter
from http.server import BaseHTTPRequestHandler
from typing import TYPE_CHECKING, Self

from motes.cli.messages import log
from motes.cli.moment import Moment, Sink
from motes.core.errors import ConfigError
from motes.output.local_server import Server, reply
from motes.output.metrics import CONTENT_TYPE, Metric, text

if TYPE_CHECKING:
    from motes.cli.sent_events import SentEvents
    from motes.mot.scene import Scene
    from motes.video.sources import Source


def place_of(text: str) -> tuple[str, int]:
    """Return the host and the port of PORT or HOST:PORT; by default only this computer may ask.

    Raises
    ------
    ConfigError
        If this is no port.
    """
    host, _, port = text.rpartition(":")
    if not (port.isdecimal() and int(port) < 1 << 16):
        raise ConfigError(f"--metrics takes PORT or HOST:PORT; got {text!r}.")
    return host or "127.0.0.1", int(port)


class MetricsPage(Sink):
    """Serves the numbers of a run of `motes watch`, at /metrics.

    Parameters
    ----------
    place
        The host and the port.
    film, scene, sent
        The parts of the run.
    """

    def __init__(
        self,
        place: tuple[str, int],
        film: Source,
        scene: Scene,
        sent: SentEvents | None,
    ) -> None:
        self._place = place
        self._film, self._scene, self._sent = film, scene, sent
        self._events: Counter[tuple[str, ...]] = Counter()
        self._frames = self._objects = 0
        self._lag = self._newest = 0.0
        self._server: Server | None = None

    def write(self, moment: Moment) -> None:
        """Count a frame."""
        self._frames += 1
        self._objects = len(moment.tracks)
        self._events.update(
            (each.event, each.place or "", each.direction or "", each.label or "")
            for each in moment.events
        )
        self._newest = time.monotonic()
        arrived = moment.frame.arrived
        self._lag = 0.0 if arrived is None else self._newest - arrived

    def __enter__(self) -> Self:
        self._server = Server(*self._place, self._answer).start()
        log(f"Metrics are at {self._server.address}metrics")
        return self

    def __exit__(self, *_: object) -> None:
        if self._server is not None:
            self._server.close()

    def _answer(self, request: BaseHTTPRequestHandler) -> None:
        if request.path.split("?")[0] in ("/", "/metrics"):
            reply(request, CONTENT_TYPE, text(self._metrics()).encode())
        else:
            reply(request, "text/plain", b"Metrics are at /metrics.\n", 404)

    def _metrics(self) -> list[Metric]:
        report = self._film.report
        since = time.monotonic() - self._newest if self._frames else 0.0
        waiting = {} if self._sent is None else self._sent.waiting()
        numbers = [
            ("frames_total", "Frames used.", self._frames),
            ("dropped_frames_total", "Frames of a live source left out, as newer ones had come.",
             report.late),
            ("reconnects_total", "Times that a live source broke and was opened again.",
             report.drops),
            ("lag_seconds", "Time from the arrival of the newest frame of a live source to its "
             "results.", self._lag),
            ("seconds_since_frame", "Time since the newest results.", since),
            ("objects", "Objects in the picture.", self._objects),
            ("objects_total", "Objects so far.", self._scene.created),
        ]  # fmt: skip
        return [
            Metric(
                f"motes_{name}",
                "counter" if name.endswith("_total") else "gauge",
                text,
                {(): value},
            )
            for name, text, value in numbers
        ] + [
            Metric(
                "motes_events_total",
                "counter",
                "Events so far.",
                dict(self._events),
                ("event", "place", "direction", "label"),
            ),
            Metric(
                "motes_waiting_events",
                "gauge",
                "Events that are not delivered yet.",
                {(name,): number for name, number in waiting.items()},
                ("receiver",),
            ),
        ]
