"""What Home Assistant has to know of a run: MQTT discovery of a device with several components.

See https://www.home-assistant.io/integrations/mqtt/#mqtt-discovery; version 2024.11 or later.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, get_args

import msgspec

from motes import __version__
from motes.mot.analytics.event import Event, Kind
from motes.mot.analytics.regions import Regions

PREFIX = "homeassistant"
"""Where Home Assistant listens, unless it is configured otherwise."""


def discovery(topic: str, regions: Regions) -> dict[str, str]:
    """Return the message that announces a run, by its topic.

    The device has a sensor for the number of objects, one for each direction of a line and for each
    zone's entries and exits, and an event entity for all events.

    Parameters
    ----------
    topic
        The topic of events. TOPIC/state has the numbers, as `state` makes them, and TOPIC/status
        whether the run goes on.
    regions
        The lines and zones that are counted.
    """
    own = f"motes_{_key(topic)}"
    sensors: dict[str, dict[str, Any]] = {
        "objects": {"name": "Objects", "state_class": "measurement", "icon": "mdi:motion-sensor"}
    }
    for name in _totals(regions):
        sensors[_key(name)] = {"name": name, "state_class": "total_increasing"}
    components: dict[str, dict[str, Any]] = {
        key: {
            "platform": "sensor",
            "unique_id": f"{own}_{key}",
            "value_template": f"{{{{ value_json['{key}'] }}}}",
            **sensor,
        }
        for key, sensor in sensors.items()
    }
    components["events"] = {
        "platform": "event",
        "unique_id": f"{own}_events",
        "name": "Events",
        "event_types": list(get_args(Kind)),
        "state_topic": topic,
        "value_template": "{{ dict(value_json, event_type=value_json.event) | tojson }}",
    }
    message = {
        "device": {"identifiers": [own], "name": f"motes {topic}", "sw_version": __version__},
        "origin": {"name": "motes", "sw_version": __version__},
        "state_topic": f"{topic}/state",
        "availability_topic": f"{topic}/status",
        "qos": 1,
        "components": components,
    }
    return {f"{PREFIX}/device/{own}/config": msgspec.json.encode(message).decode()}


def total_of(event: Event) -> str:
    """Return the name of the total that an event adds to, if it is one of a line or zone."""
    return f"{event.place} {event.direction or event.event}"


def state(objects: int, totals: Mapping[str, int], regions: Regions) -> str:
    """Return the numbers of the sensors as JSON.

    Parameters
    ----------
    objects
        The number of objects in the picture.
    totals
        The events of the whole run so far, by `total_of`.
    regions
        The lines and zones that are counted.
    """
    numbers = {_key(name): totals.get(name, 0) for name in _totals(regions)}
    return msgspec.json.encode({"objects": objects, **numbers}).decode()


def _totals(regions: Regions) -> list[str]:
    """Return the names of the totals: the directions of lines, entries and exits of zones."""
    names = [f"{name} {label}" for name, line in regions.lines.items() for label in line.label]
    return names + [f"{name} {what}" for name in regions.zones for what in ("enters", "leaves")]


def _key(name: str) -> str:
    """Return a name in letters that identifiers may have; others become their code."""
    return re.sub(r"[^a-z0-9]", _plain, name.lower())


def _plain(found: re.Match[str]) -> str:
    return "_" if found[0] in " /-_" else f"u{ord(found[0]):x}"
