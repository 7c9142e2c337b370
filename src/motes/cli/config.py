"""`motes config`: the presets, and every key of the configuration with type, value and meaning."""

from __future__ import annotations

import difflib
import shutil
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Annotated

from cyclopts import App

from motes.cli.exit_codes import DONE
from motes.cli.option_groups import FLAG, PresetName
from motes.core.config_keys import Key, KeyChoice, all_keys, keys, type_key
from motes.core.errors import ConfigError

app = App(name="config", help_format="plaintext")
MAX_COLUMNS = 100
"""Longer lines are hard to read."""
LIST_END = """\
motes config PRESET lists the keys of a preset, motes config --watch those of motes watch."""
USE = """\
Each key is set by --set {example} of motes {command}, or by a line of a TOML file for --config."""


@app.default
def config(
    preset: PresetName | None = None,
    key: str | None = None,
    /,
    *,
    watch: Annotated[bool, FLAG] = False,
) -> int:
    """List the presets, or every key of one with its type, value and meaning.

    --dump-config of motes track and motes watch prints the values alone, as a TOML file.

    Parameters
    ----------
    preset
        A preset. Without one, the presets are listed.
    key
        List only this key and those inside it, such as motion or color.bins.
    watch
        List the keys of motes watch: the scene, the detector and, as tracker.KEY, the keys of the
        preset.
    """
    if preset is None and not watch:
        print("\n".join(_presets()))
        return DONE
    from motes.mot.scene_config import WatchConfig
    from motes.sot import presets

    name = preset or "nummiaro:adaptive"
    chosen = WatchConfig.of(name) if watch else presets.preset(name)
    title = f"motes watch with the preset {name}."
    if not watch:
        title = f"Preset {name}. {presets.DESCRIPTIONS[name]}"
    listed = keys(type(chosen), chosen)
    example = next(each for each in _entries(listed) if each.value is not None)
    command = "watch" if watch else "track"
    use = USE.format(example=f"{example.path}={example.value}", command=command)
    head = [*_wrapped(title), *_wrapped(use), ""] if key is None else []
    lines = list(_sections(listed, None if key is None else key.replace("-", "_")))
    if not lines:
        command = " ".join(["motes config", *filter(None, [preset]), *["--watch"] * watch])
        near = difflib.get_close_matches(key or "", [each.path for each in all_keys(listed)], n=1)
        hint = f"did you mean {near[0]}?" if near else f"see {command}."
        raise ConfigError(f"There is no key {key}; {hint}")
    print("\n".join([*head, *lines]))
    return DONE


def _presets() -> Iterator[str]:
    """Yield the list of presets, with a line on each."""
    from motes.sot.presets import DESCRIPTIONS

    width = max(map(len, DESCRIPTIONS)) + 2
    narrow = _columns() < 2 * width
    for name, text in DESCRIPTIONS.items():
        if narrow:
            yield name
        yield from _wrapped(text, "    " if narrow else name.ljust(width))
    yield ""
    yield from _wrapped(LIST_END)


def _sections(listed: Sequence[Key], only: str | None) -> Iterator[str]:
    """Yield the keys in use, then those of other choices; with `only`, those at and inside it."""
    for key in _entries(listed):
        if _within(key.path, only):
            yield from _entry(key)
    for key, choice in _others(listed):
        if not _within(key.path, only):
            continue
        yield ""
        name = key.path if choice.tag is None else f'{key.path}.type = "{choice.tag}"'
        head = f"{name} (not used; to add it, set one of its keys)"
        yield from _wrapped(f"{head if choice.tag is None else name}: {choice.meaning}")
        for each in _entries(choice.keys):
            yield from _entry(each, "  ")


def _within(path: str, only: str | None) -> bool:
    return only is None or path == only or path.startswith(f"{only}.")


def _entries(listed: Iterable[Key]) -> Iterator[Key]:
    """Yield keys, and those of the choices made, in the order of a reader."""
    for key in listed:
        chosen = next((choice for choice in key.choices if choice.chosen), None)
        if chosen is None and key.choices and not key.required:
            continue  # among the others
        if chosen is not None and chosen.tag is not None:
            yield type_key(key)
        else:
            yield key
        yield from _entries(chosen.keys if chosen else ())


def _others(listed: Iterable[Key]) -> Iterator[tuple[Key, KeyChoice]]:
    """Yield the choices that are not made, each with its key."""
    for key in listed:
        for choice in key.choices:
            if not choice.chosen:
                yield key, choice
        for choice in key.choices:
            yield from _others(choice.keys)


def _entry(key: Key, indent: str = "") -> Iterator[str]:
    """Yield the lines on one key."""
    if key.choices:
        head = key.path
    elif key.value is not None:
        head = f"{key.path} = {key.value}"
    else:
        head = f"{key.path} ({'required' if key.required else 'not set'})"
    yield from _wrapped(f"{head}  [{key.type}]" if key.type else head, indent, len(indent) + 2)
    if key.meaning:
        yield from _wrapped(key.meaning, indent + "    ")


def _wrapped(text: str, first: str = "", indent: int | None = None) -> list[str]:
    """Return the lines of a text that begins after `first`, in the width of the terminal."""
    later = " " * (len(first) if indent is None else indent)
    return textwrap.wrap(
        text, _columns(), initial_indent=first, subsequent_indent=later, break_on_hyphens=False
    )


def _columns() -> int:
    return min(shutil.get_terminal_size().columns, MAX_COLUMNS)
