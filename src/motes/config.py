"""Configuration: frozen values that check themselves, from Python, TOML or command-line flags."""

from __future__ import annotations

import difflib
import math
import re
import tomllib
from collections.abc import Mapping
from typing import Annotated, Any, TypeVar

import msgspec
from msgspec import Meta

from motes.errors import ConfigError

Positive = Annotated[float, Meta(gt=0)]
NonNegative = Annotated[float, Meta(ge=0)]
Share = Annotated[float, Meta(ge=0, le=1)]
Count = Annotated[int, Meta(ge=1)]


class Config(
    msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="type"
):
    """Base of all configuration: frozen, keyword-only, checked on construction.

    A field's type says what it accepts; anything else, NaN and infinity included, raises a
    `ConfigError` that names the field. Subclasses with a `tag` are told apart by the key `type`.
    """

    def __post_init__(self) -> None:
        for field in msgspec.structs.fields(self):
            value = getattr(self, field.name)
            try:
                if isinstance(value, float) and not math.isfinite(value):
                    raise ConfigError(f"Expected a finite number, got {value}")
                msgspec.convert(value, field.type)
            except (msgspec.ValidationError, ConfigError) as error:
                raise ConfigError(f"{field.name}: {error}") from None


C = TypeVar("C", bound=Config)


def to_dict(config: Config) -> dict[str, Any]:
    """Return a configuration as nested plain dicts."""
    plain: dict[str, Any] = msgspec.to_builtins(config)
    return plain


def merge(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with `changes` laid over it, nested mappings key by key.

    Where a change names another `type`, the base's values there belong to something else and are
    dropped, so that the new type starts from its own defaults.
    """
    if "type" in changes and changes["type"] != base.get("type"):
        return dict(changes)
    merged = dict(base)
    for key, value in changes.items():
        old = merged.get(key)
        if isinstance(value, Mapping) and isinstance(old, Mapping):
            value = merge(old, value)
        merged[key] = value
    return merged


def from_dict(values: Mapping[str, Any], kind: type[C] | Any) -> Any:
    """Return the configuration of type `kind` (a class or a union of classes) from plain values.

    Raises
    ------
    ConfigError
        For an unknown key, with the nearest known one, or a value that does not fit.
    """
    try:
        return msgspec.convert(values, kind)
    except msgspec.ValidationError as error:
        message, _, path = str(error).partition(" - at `$")
        where = path.rstrip("`").lstrip(".")
        unknown = re.search(r"unknown field `(.+?)`", message)
        if unknown is None:
            raise ConfigError(f"Config{' ' + where if where else ''}: {message}.") from None
        name = unknown[1]
        known = _keys(kind)
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"known keys: {', '.join(known)}."
        raise ConfigError(
            f"Config has no key {f'{where}.{name}' if where else name!r}; {hint}"
        ) from None


def _keys(kind: Any) -> list[str]:
    """Return the names of all fields in a configuration type and the types inside it."""
    keys: set[str] = set()
    for part in getattr(kind, "__args__", ()) or (kind,):
        if isinstance(part, type) and issubclass(part, Config):
            for field in msgspec.structs.fields(part):
                keys.add(field.name)
                keys.update(_keys(field.type))
    return sorted(keys)


def from_toml(text: str, name: str) -> dict[str, Any]:
    """Return the values in a TOML text; `name` is what an error calls it."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{name} is not valid TOML: {error}.") from None


def to_toml(config: Config) -> str:
    """Return a configuration as TOML text that `from_toml` reads back."""
    return msgspec.toml.encode(to_dict(config)).decode()


def from_flag(key: str, text: str) -> dict[str, Any]:
    """Return `{"motion": {"noise": 0.2}}` for the flag `--motion.noise 0.2`.

    The text is read as a TOML value; `8,8,8` is a list, and what is no TOML value is a string.
    """
    value: Any = text
    for candidate in (text, f"[{text}]"):
        try:
            value = tomllib.loads(f"value = {candidate}")["value"]
            break
        except tomllib.TOMLDecodeError:
            continue
    if value == [text]:  # a lone word in brackets is no list
        value = text
    for part in reversed(key.split(".")):
        value = {part: value}
    nested: dict[str, Any] = value
    return nested
