"""Configurations from a preset, a file, a trained network and options.

Keys are options by `--set motion.noise.size=0.1`.
"""

from __future__ import annotations

import contextlib
import re
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motes.cli.exit_codes import EXIT_CODES
from motes.cli.input_checks import error_context, numbers_of
from motes.core.config import DEEPEST
from motes.core.errors import ConfigError
from motes.core.files import read_text

if TYPE_CHECKING:
    from motes.cli.option_groups import ConfigOptions
    from motes.cli.watch_options import ObjectOptions
    from motes.mot.scene_config import WatchConfig
    from motes.sot.presets import TrackerConfig

HELP = f"""\
Each key of the configuration is changed by --set KEY=VALUE, such as {{example}}. The preset comes \
first, then the file of --config, then --set. motes config lists the presets; {{command}} lists \
all keys with their types, values and meanings.

{EXIT_CODES}"""
TRACKER_HELP = HELP.format(
    example="--set motion.noise.size=0.1 with preset nummiaro", command="motes config PRESET"
)


def settings_of(given: Sequence[str]) -> dict[str, Any]:
    """Return the values of --set as the tables of a configuration.

    Raises a ConfigError if one has another form, or two contradict each other. Each is KEY=VALUE,
    with dots between the parts of a key, and a value as in TOML; a text needs no quotes, and a list
    of numbers no brackets.
    """
    found: dict[str, Any] = {}
    for text in given:
        key, equals, value = text.partition("=")
        *above, last = parts = [part.strip().replace("-", "_") for part in key.split(".")]
        if not (equals and all(parts)) or len(parts) > DEEPEST:
            raise ConfigError(f"--set takes KEY=VALUE, as in motion.noise.size=0.1; got {text!r}.")
        table = found
        for part in above:
            inner = table.setdefault(part, {})
            if not isinstance(inner, dict):
                raise ConfigError(f"--set gives {part} itself and a key inside it; give one.")
            table = inner
        if last in table:
            raise ConfigError(f"--set gives {key.strip()} twice, or keys inside it too; give one.")
        table[last] = value_of(value.strip())
    return found


def value_of(text: str) -> Any:
    """Return the value of a text, such as 0.2 of `--set motion.noise=0.2`.

    The text is read as a TOML value; `8,8,8` is a list, and any other text is a string.
    """
    listed = f"[{text}]" if re.match(r"[^\[].*,", text) else text
    with contextlib.suppress(ValueError, RecursionError):
        return tomllib.loads(f"value = {listed}")["value"]
    return text


def is_key(path: str) -> bool:
    """Return whether a path is that of a configuration's value, as of an option that was one."""
    from motes.core.config_keys import keys
    from motes.mot.scene_config import WatchConfig
    from motes.sot.presets import PRESETS

    kinds: set[Any] = {WatchConfig, *map(type, PRESETS.values())}
    first, *inside = path.split(".")
    found = [key for kind in kinds for key in keys(kind) if key.path == first]
    return path == "type" or any(bool(inside) or not key.choices for key in found)


def tracker_config(
    preset: str, file: Path | None, changes: Sequence[str] = (), network: str | None = None
) -> TrackerConfig:
    """Return a preset, changed by the file and the options, in this order.

    Raises a ConfigError for an unknown preset or key, or a value that does not fit; and a
    SourceError if the file cannot be read.
    """
    from motes.core.config import from_toml
    from motes.sot import presets

    base = presets.preset(preset)
    if file is not None:
        with error_context(file):
            base = presets.configure(base, from_toml(read_text(file), "this file"))
    settings = with_network(settings_of(changes), preset, network)
    if not settings:
        return base
    with error_context("--set"):
        return presets.configure(base, settings)


def load_watch_config(
    preset: str, objects: ObjectOptions, values: ConfigOptions, *, own_code: bool = False
) -> WatchConfig:
    """Return the scene of a preset, changed by the file, the options and --set in turn.

    Raises a ConfigError for an unknown preset, detector or key, or a value that does not fit; and a
    SourceError if the file cannot be read. With both --detector and --like, the configuration is
    that of --like. `own_code` is whether the file may name a detector that is code.
    """
    from motes.core.config import from_toml
    from motes.mot.detection.custom import CustomConfig
    from motes.mot.scene_config import WatchConfig, check_code

    file, config = values.config, WatchConfig.of(preset)
    if objects.like is not None:
        config = config.for_lookalikes()
    if file is not None:
        with error_context(file):
            config = config.changed(from_toml(read_text(file), "this file"))
            if isinstance(config.detector, CustomConfig):
                check_code(config.detector.name, own_code)
    if objects.like is not None:
        box = numbers_of("--like", objects.like, "x,y,width,height")
        config = config.changed({"detector": {"type": "like", "box": box}})
    else:
        config = config.changed({}, detector=objects.detector)
    config = config.changed(objects.selection())
    with error_context("--set"):
        return config.changed(settings_of(values.changes or ()))


def with_network(settings: dict[str, Any], preset: str, given: str | None) -> dict[str, Any]:
    """Return settings with --network as their key `network.files`.

    Raises a ConfigError if the preset takes no network, or the settings have this key too.
    """
    if given is None:
        return settings
    from motes.sot import presets
    from motes.sot.network.network import Network

    if "network" not in presets.preset(preset).__struct_fields__:
        raise ConfigError(
            f"Preset {preset} takes no network; omit --network or choose another preset."
        )
    others = settings.get("network", {})
    if not isinstance(others, dict) or "files" in others:
        raise ConfigError("--network and --set network.files contradict each other; give one.")
    return {**settings, "network": {**others, "files": [*Network.named(given).files]}}
