"""Options that are keys of the configuration, such as `--motion.noise.size 0.1`."""

from __future__ import annotations

import difflib
import inspect
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter, Token

from motes.cli.exit_codes import EXIT_CODES
from motes.core.config_keys import NAME, Key, all_keys, keys
from motes.core.errors import ConfigError

if TYPE_CHECKING:
    from cyclopts import ArgumentCollection

HELP = f"""\
Every key of the configuration is an option too, such as {{example}}. The preset comes first, then \
the file of --config, then these options. motes config lists the presets; {{command}} lists all \
keys with their types, values and meanings.

{EXIT_CODES}"""
TRACKER_HELP = HELP.format(
    example="--motion.noise.size 0.1 of preset nummiaro", command="motes config PRESET"
)


def _read_setting(kind: Any, tokens: Any, depth: int = 1) -> Any:
    """Return the value of a key from its tokens, or the values of the keys inside it."""
    from motes.core.config import DEEPEST, from_flag

    if depth > DEEPEST:
        raise ConfigError(f"An option has no more than {DEEPEST} parts.")
    if isinstance(tokens, dict):
        return {key: _read_setting(kind, inner, depth + 1) for key, inner in tokens.items()}
    token: Token = tokens[-1]
    return from_flag(token.value)


Settings = Annotated[Any, Parameter(converter=_read_setting, show=False)]


def refuse_clashes(app: App, commands: Sequence[str], arguments: ArgumentCollection) -> None:
    """Refuse settings that the parser cannot pass on; it calls this when all options are read.

    These are `--motion 1 --motion.noise 2`, a value and keys inside it, and the name of one of the
    command's Python parameters, such as `--frames`.

    Raises
    ------
    ConfigError
        For such options.
    """
    names = inspect.signature(app.default_command).parameters if app.default_command else ()
    for argument in arguments:
        if argument.field_info.kind is not inspect.Parameter.VAR_KEYWORD:
            continue
        given = {token.keys: str(token.keyword) for token in argument.tokens}
        for path, option in given.items():
            if path[0] in names:
                values = {each.name: each.tokens[-1].value for each in arguments if each.tokens}
                raise ConfigError(_known(app, _preset(app, values)).unknown(option))
            for length in range(1, len(path)):
                if path[:length] in given:
                    raise ConfigError(
                        f"{given[path[:length]]} and {option} contradict each other; give one."
                    )


def as_keys(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings with underscores for hyphens: an option may have either, a key has none."""
    return {
        key.replace("-", "_"): as_keys(value) if isinstance(value, dict) else value
        for key, value in settings.items()
    }


def check_settings(app: App, preset: str, kind: Any, settings: Mapping[str, Any]) -> None:
    """Check that settings are keys of a configuration type.

    Parameters
    ----------
    app
        The command; an unknown setting may be one of its options, misspelled.
    preset
        The preset, for messages.
    kind
        The configuration class.
    settings
        The settings.

    Raises
    ------
    ConfigError
        If a key is unknown, with the nearest known one, or if it takes keys and not a value.
    """
    if not settings or "type" in settings:  # which has other keys: checked with the values
        return
    known = _Known(app, preset, kind)
    for path, value in _flat(settings):
        key = known.find(path)
        if key is None:
            raise ConfigError(known.unknown(f"--{path}"))
        if key.choices and not isinstance(value, dict):
            raise ConfigError(known.needs_key(key))


def without_value(app: App, flag: str, words: Sequence[str]) -> str:
    """Return the message for a setting without a value: it may also be unknown.

    Parameters
    ----------
    app, flag
        The command and the option.
    words
        The words of the command line.

    Raises
    ------
    ConfigError
        If the preset on the command line is unknown.
    """
    parts = [part for word in words for part in word.split("=", 1)]
    known = _known(app, _preset(app, dict(pairwise(parts))))
    key = known.find(flag.lstrip("-"))
    if key is None:
        return known.unknown(flag)
    return known.needs_key(key) if key.choices else f"{flag} needs a value: {key.type}."


def default_preset(particles: bool) -> str:
    """Return the preset of `motes track`; only particle filters find colors."""
    return "nummiaro" if particles else "default"


def _preset(app: App, values: Mapping[str, str]) -> str:
    """Return the preset of a command that has options with these values."""
    if "--preset" in values:
        return values["--preset"]
    arguments = app.assemble_argument_collection()
    default = next(each.field_info.default for each in arguments if each.name == "--preset")
    particles = ("--histogram", "--save-histogram")
    return default or default_preset(any(name in values for name in particles))


def _known(app: App, preset: str) -> _Known:
    """Return the options and keys of a command with a preset."""
    from motes.mot.pipeline_config import WatchConfig
    from motes.sot import presets

    watch = app.name == ("watch",)
    return _Known(app, preset, WatchConfig if watch else type(presets.preset(preset)))


class _Known:
    """The options of a command and the keys of its configuration."""

    def __init__(self, app: App, preset: str, kind: Any) -> None:
        from motes.sot.presets import PRESETS

        self._preset = preset
        self._command = app.name[0]
        kinds = {type(each) for each in PRESETS.values()}
        others = kinds - {kind} if kind in kinds else set()  # motes watch has one kind alone
        self._elsewhere = {key.path for other in others for key in keys(other)}
        self._keys = {key.path: key for key in all_keys(keys(kind))}
        self._options = [
            name
            for argument in app.assemble_argument_collection()
            for name in argument.names
            if re.fullmatch("--[a-z-]+", name)
        ]

    def find(self, path: str) -> Key | None:
        """Return the key at a path, if there is one."""
        path = path.replace("-", "_")
        for known, key in self._keys.items():
            if re.fullmatch(re.escape(known).replace(NAME, r"[^.]+"), path):
                return key
        return None

    def unknown(self, flag: str) -> str:
        """Return that there is no such option, with the nearest one."""
        wanted = flag.lstrip("-").replace("-", "_")
        names = {option.lstrip("-").replace("-", "_"): option for option in self._options}
        names |= {path: f"--{path}" for path in self._keys if NAME not in path}
        # Whoever omits the tables of a key gives its last part alone.
        last = {path.rpartition(".")[2]: name for path, name in names.items() if "." in path}
        alike = [last[wanted]] if wanted in last else []
        for known in (names, last):
            alike += [known[name] for name in difflib.get_close_matches(wanted, known, n=1)]
        command = f"motes config {'--watch' if self._command == 'watch' else self._preset}"
        hint = f"see motes {self._command} --help and {command}."
        if not wanted:
            hint = "for standard input give /dev/stdin."
        elif os.path.exists(flag):
            hint = f"for the file write ./{flag}."
        elif alike:
            key = self._keys.get(alike[0].lstrip("-"))
            group = key is not None and key.choices
            hint = f"did you mean {alike[0]}{'.KEY' if group else ''}?"
        part = f" with preset {self._preset}" * (wanted.partition(".")[0] in self._elsewhere)
        return f"There is no option {flag}{part}; {hint}"

    def needs_key(self, key: Key) -> str:
        """Return that an option takes keys and not a value."""
        inside = [path for path in self._keys if path.startswith(f"{key.path}.")]
        return f"--{key.path} takes no value itself; set a key of it, such as --{inside[0]}."


def _flat(settings: Mapping[str, Any], path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the path and value of each setting that is no table of settings."""
    for key, value in settings.items():
        if isinstance(value, dict) and value:
            yield from _flat(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", value
