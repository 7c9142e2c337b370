"""Events of `motes watch` that are sent to webhooks and MQTT brokers."""

from __future__ import annotations

import re
import secrets
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Self

import msgspec

from motes import ConfigError, Event, Regions
from motes.cli import Moment, Sink, log
from motes.core import counted, parts_of, without_password
from motes_fleet.delivery.delivery import Delivery, Receiver
from motes_fleet.delivery.event_queue import MessageQueue
from motes_fleet.delivery.mqtt import PORTS, Mqtt
from motes_fleet.delivery.webhook import Webhook


class SentEvents(Sink):
    """Events on their way to webhooks and brokers, each until it is confirmed.

    They wait in the file `queue`. The source is part of each message.

    Raises
    ------
    ConfigError
        If an address cannot be used, or is given twice.
    MissingDependencyError
        If MQTT is asked for without paho-mqtt.
    """

    def __init__(
        self, addresses: Sequence[str], queue: Path, source: str, regions: Regions
    ) -> None:
        self._receivers = [_receiver(each) for each in addresses]
        self._names = [receiver.name for receiver in self._receivers]
        if len(set(self._names)) < len(self._names):
            raise ConfigError("Two addresses of --events are the same; give each once.")
        self._path, self._source = queue, without_password(source)
        self._regions = regions
        self._queue: MessageQueue | None = None
        self._deliveries: list[Delivery] = []
        self._objects = -1

    def write(self, moment: Moment) -> None:
        """Queue a frame's events; set the numbers for MQTT."""
        assert self._queue is not None
        for delivery in self._deliveries:
            if delivery.error is not None:
                raise delivery.error
        if moment.events:
            bodies = [message(event, self._source) for event in moment.events]
            self._queue.put(self._names, bodies)
        if moment.events or len(moment.tracks) != self._objects:
            self._objects = len(moment.tracks)
            numbers = state(self._objects, moment.totals, self._regions)
            for receiver in self._receivers:
                if isinstance(receiver, Mqtt):
                    receiver.set_state(numbers)

    def waiting(self) -> dict[str, int]:
        """Return the number of events that wait for each receiver."""
        found = {} if self._queue is None else self._queue.waiting()
        return {name: found.get(name, 0) for name in self._names}

    @property
    def result(self) -> str | None:
        """The number of events that each receiver has confirmed, with those of earlier runs."""
        sent = [(each.delivered, each.receiver.name) for each in self._deliveries]
        return ", ".join(f"{counted(n, 'event')} for {name}" for n, name in sent if n) or None

    def __enter__(self) -> Self:
        self._queue = MessageQueue(self._path)
        for name, number in self._queue.waiting().items():
            sends = "they are sent now" if name in self._names else "this run does not send them"
            log(f"{counted(number, 'event')} of earlier runs for {name} in {self._path}; {sends}.")
        self._deliveries = [Delivery(self._queue, each, log) for each in self._receivers]
        return self

    def __exit__(self, *_: object) -> None:
        assert self._queue is not None
        for delivery in self._deliveries:
            delivery.close()
        for name, number in self.waiting().items():
            if number:
                log(
                    f"{counted(number, 'event')} for {name} in {self._path}; the next run with "
                    f"this queue and address sends them."
                )
        self._queue.__exit__()


def message(event: Event, source: str) -> str:
    """Return an event as it is sent: with an identifier of its own, the date, and the source."""
    head = {
        "message": secrets.token_hex(16),
        "date": datetime.now(UTC).isoformat(timespec="milliseconds"),
        "source": source,
    }
    return msgspec.json.encode({**head, **event.fields()}).decode()


def _receiver(address: str) -> Receiver:
    """Return what sends messages to an address."""
    parts = parts_of(address)
    if parts.scheme in PORTS:
        return Mqtt(address)
    if not parts.hostname:
        raise ConfigError(f"{address} has no host; give https://HOST/PATH.")
    if not address.isascii() or not address.isprintable() or " " in address:
        raise ConfigError(f"{address} has characters that addresses write as %XX; write these.")
    return Webhook(address)


def state(objects: int, totals: Mapping[str, int], regions: Regions) -> str:
    """Return the numbers of a run so far, as the JSON of TOPIC/state.

    They are that of objects in the picture, and the totals (`Event.total`) of lines and zones.
    """
    numbers = {_key(name): totals.get(name, 0) for name in regions.totals}
    return msgspec.json.encode({"objects": objects, **numbers}).decode()


def _key(name: str) -> str:
    """Return a name in letters that identifiers may have; others become their code."""
    return re.sub(r"[^a-z0-9]", _plain, name.lower())


def _plain(found: re.Match[str]) -> str:
    return "_" if found[0] in " /-_" else f"u{ord(found[0]):x}"
