"""Keys of the configuration on the command line: `--set motion.noise.size=0.1`."""

from __future__ import annotations

import contextlib
import re
import tomllib
from collections.abc import Sequence
from typing import Any

from motes.cli.exit_codes import EXIT_CODES
from motes.core.config import DEEPEST
from motes.core.errors import ConfigError

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
    from motes.mot.pipeline_config import WatchConfig
    from motes.sot.presets import PRESETS

    kinds: set[Any] = {WatchConfig, *map(type, PRESETS.values())}
    first, *inside = path.split(".")
    found = [key for kind in kinds for key in keys(kind) if key.path == first]
    return path == "type" or any(bool(inside) or not key.choices for key in found)
