"""Configurations and targets from a preset, a file and options."""

from __future__ import annotations

import contextlib
import difflib
import inspect
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motes.cli.input_checks import read_text
from motes.core.errors import ConfigError, FormatError, SourceError
from motes.core.renamed_keys import RENAMED

if TYPE_CHECKING:
    from motes.core.config import Config
    from motes.sot.known_target import Target
    from motes.sot.presets import TrackerConfig


def tracker_config(
    command: Callable[..., object],
    preset: str,
    file: Path | None,
    settings: dict[str, Any],
    target: Target | None = None,
) -> TrackerConfig:
    """Return the preset, with the target's cue, the file and the settings laid over it in turn.

    An unknown setting may be a misspelled option of the command, whose parameters name them.

    Raises
    ------
    ConfigError
        For what is unknown or makes no sense.
    SourceError
        If the file cannot be read.
    """
    from motes.core.config import from_toml, to_dict
    from motes.sot import presets

    base = presets.preset(preset)
    if target is not None:
        base = presets.configure(base, {"color": to_dict(target.cue)})
    if file is not None:
        with error_context(file):
            base = presets.configure(base, from_toml(read_text(file), "this file"))
    check_settings(command, base, settings)
    return presets.configure(base, as_keys(settings))


def as_keys(settings: dict[str, Any]) -> dict[str, Any]:
    """Return settings by keys as a file has them: an option may have hyphens for underscores."""
    return {
        key.replace("-", "_"): as_keys(value) if isinstance(value, dict) else value
        for key, value in settings.items()
    }


def check_settings(
    command: Callable[..., object], config: Config, settings: dict[str, Any]
) -> None:
    """Check that settings are keys of a configuration; others may be misspelled options.

    The keys of other packages are looked up only for a setting that is none of ours. A cue passes:
    a configuration that takes none says so itself.

    Raises
    ------
    ConfigError
        With the nearest known key or option.
    """
    from motes.core.config_keys import names
    from motes.cues.base import CUES

    given = {key.replace("-", "_"): key for key in settings}
    declared = config.__struct_fields__
    unknown = [name for name in given if name not in declared and name not in CUES]
    if unknown and "type" not in settings:
        raise ConfigError(no_such_option(command, f"--{given[unknown[0]]}", names(type(config))))


def no_such_option(command: Callable[..., object], flag: str, known: Iterable[str]) -> str:
    """Return that a command has no such option, with the nearest of its own and of known keys."""
    known = list(known)
    renamed = {old: new for old, new in RENAMED.items() if new.partition(".")[0] in known}
    name = flag.lstrip("-").replace("-", "_")
    if name in renamed:
        return f"There is no option {flag}; it is --{renamed[name]} now."
    options = [name.replace("_", "-") for name in inspect.signature(command).parameters]
    near = difflib.get_close_matches(flag.lstrip("-"), [*known, *options, *renamed], n=1)
    hint = f"see motes {command.__name__} --help."
    if near:
        hint = f"did you mean --{renamed.get(near[0], near[0])}?"
    return f"There is no option {flag} with this preset; {hint}"


@contextlib.contextmanager
def error_context(where: Path | str) -> Iterator[None]:
    """Add the file or option to the message of a configuration's error."""
    try:
        yield
    except ConfigError as error:
        raise ConfigError(f"{where}: {error}") from None


def load_target(path: Path) -> Target:
    """Return the target in a histogram file; raise a SourceError where there is none."""
    from motes.sot.known_target import Target

    try:
        return Target.load(path)
    except FormatError as error:
        raise SourceError(str(error)) from None
