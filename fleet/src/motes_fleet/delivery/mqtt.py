"""Events over MQTT, each confirmed by the broker (QoS 1)."""

from __future__ import annotations

import contextlib
import secrets
import time
from collections.abc import Sequence
from typing import Any
from urllib.parse import unquote, urlsplit

from motes import ConfigError
from motes.core import optional, parts_of, without_password
from motes_fleet.delivery.delivery import DeliveryError

PORTS = {"mqtt": 1883, "mqtts": 8883}
ANSWER = 5.0
"""Seconds within which a broker must answer."""
KEEP_ALIVE = 15
"""Seconds after which a silent connection is tried; a broker drops it after one and a half."""
ONLINE, OFFLINE = "online", "offline"


class Mqtt:
    """Publishes messages under a topic, and keeps two retained messages beside it.

    - TOPIC/status: `online`, or `offline` after the run, also if it was killed;
    - TOPIC/state: the state that was set last.

    Parameters
    ----------
    address
        mqtt://USER:PASSWORD@HOST:PORT/TOPIC, or mqtts://... for TLS.

    Raises
    ------
    ConfigError
        If the address has no host or no topic, or the topic is a pattern.
    MissingDependencyError
        If paho-mqtt is not installed.
    """

    batch = 50

    def __init__(self, address: str) -> None:
        self._paho = optional("paho.mqtt.client", "MQTT needs paho-mqtt", "motes-fleet[mqtt]")
        self.name, self._parts = without_password(address), urlsplit(address)
        self.topic = topic_of(address)
        self._state = self._published = ""
        self._client: Any = None

    def set_state(self, state: str) -> None:
        """Set the text of TOPIC/state; it is published with the next messages, or soon."""
        self._state = state

    def send(self, bodies: Sequence[str]) -> None:
        """Publish messages; raise a DeliveryError if the broker does not confirm all of them."""
        if self._client is None:
            self._open()
        elif not self._client.is_connected():
            raise DeliveryError(f"{self.name} has closed the connection.")
        state = self._state
        messages = [(self.topic, body, False) for body in bodies]
        if state != self._published:
            messages.append((f"{self.topic}/state", state, True))
        self._publish(messages)
        self._published = state

    def close(self) -> None:
        """Disconnect from the broker, if it is there."""
        client, self._client, self._published = self._client, None, ""
        if client is None:
            return
        if client.is_connected():
            # The broker publishes no last will of a client that disconnects. The connection may
            # break at any moment.
            with contextlib.suppress(RuntimeError, ValueError):
                client.publish(f"{self.topic}/status", OFFLINE, 1, True).wait_for_publish(1.0)
        client.disconnect()
        client.loop_stop()

    def _open(self) -> None:
        """Connect, and publish that the run goes on."""
        paho, parts = self._paho, self._parts
        # A failed connection is replaced by a new one, so that no message is sent from two queues.
        client = paho.Client(
            paho.CallbackAPIVersion.VERSION2,
            f"motes-{secrets.token_hex(8)}",
            reconnect_on_failure=False,
        )
        client.max_inflight_messages_set(self.batch)
        client.connect_timeout = ANSWER
        if parts.username is not None:
            client.username_pw_set(unquote(parts.username), unquote(parts.password or ""))
        if parts.scheme == "mqtts":
            client.tls_set()
        client.will_set(f"{self.topic}/status", OFFLINE, 1, True)
        refusals: list[str] = []

        def connected(_: Any, __: Any, ___: Any, reason: Any, ____: Any) -> None:
            if reason.is_failure:
                refusals.append(str(reason))

        client.on_connect = connected
        try:
            client.connect(parts.hostname, parts.port or PORTS[parts.scheme], KEEP_ALIVE)
        except (OSError, ValueError) as error:
            text = getattr(error, "strerror", None) or str(error) or type(error).__name__
            raise DeliveryError(f"{self.name} cannot be reached: {text}.") from error
        self._client = client
        client.loop_start()
        until = time.monotonic() + ANSWER
        while not (client.is_connected() or refusals) and time.monotonic() < until:
            time.sleep(0.01)
        if refusals:
            raise DeliveryError(f"{self.name} refuses the connection: {refusals[0]}.")
        if not client.is_connected():
            raise DeliveryError(f"{self.name} does not answer.")
        self._publish([(f"{self.topic}/status", ONLINE, True)])

    def _publish(self, messages: Sequence[tuple[str, str, bool]]) -> None:
        """Publish texts under topics, retained or not; wait for all confirmations."""
        sent = [self._client.publish(topic, text, 1, keep) for topic, text, keep in messages]
        until = time.monotonic() + ANSWER
        for each in sent:
            try:
                while not each.is_published():
                    if time.monotonic() > until or not self._client.is_connected():
                        raise DeliveryError(f"{self.name} does not confirm events.")
                    each.wait_for_publish(0.1)
            except (RuntimeError, ValueError) as error:  # it was never sent
                raise DeliveryError(f"{self.name} takes no events: {error}.") from error


def topic_of(address: str) -> str:
    """Return the topic of an address; raise a ConfigError if the address cannot be used."""
    parts, name = parts_of(address), without_password(address)
    topic = unquote(parts.path).strip("/")
    if not parts.hostname or not topic:
        raise ConfigError("An address of MQTT lacks a host or a topic; give mqtt://HOST/TOPIC.")
    if "+" in topic or "#" in topic + address or not topic.isprintable():
        raise ConfigError(f"The topic of {name} is a pattern; give one without + and #.")
    return topic
