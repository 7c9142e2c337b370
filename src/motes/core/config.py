"""Configuration: frozen values that check themselves, from Python, TOML or command-line flags."""

from __future__ import annotations

import difflib
import math
import numbers
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import msgspec
from msgspec import Meta

from motes.core.decode import MisfitError, decode, decode_at, of_numpy
from motes.core.errors import ConfigError
from motes.core.files import read_text
from motes.core.registry import fields_of

Positive = Annotated[float, Meta(gt=0, le=1e9)]
NonNegative = Annotated[float, Meta(ge=0, le=1e9)]
Share = Annotated[float, Meta(ge=0, le=1)]
Count = Annotated[int, Meta(ge=1, le=2**31 - 1)]
"""A count, which fits into an `int` of C: some libraries count with it."""
Particles = Annotated[int, Meta(ge=1, le=1_000_000)]
"""A number of particles. More would need more memory than machines have."""

DEEPEST = 100
"""Largest number of parts of a dotted key in TOML."""
_DEEP = re.compile(rf"(?<![\w\"'-])(?:[\w\"'-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}")


class Config(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all configuration: frozen, and checked on construction.

    A field accepts the values of its type. Any other value, NaN and infinity included, raises a
    `ConfigError` that names the field. The key `type` names one of several subclasses by its `tag`.
    A field whose type has a registry takes every implementation in it.
    """

    open_field: ClassVar[str | None] = None
    """A field that holds values of other packages by name. As plain values they stand among the
    other fields: `hue.bins`, not `extra_cues.hue.bins`."""

    def __post_init__(self) -> None:
        for field in fields_of(type(self)):
            value = of_numpy(getattr(self, field.name))
            for number in map(of_numpy, value if isinstance(value, list | tuple) else (value,)):
                if isinstance(number, float) and not math.isfinite(number):
                    raise MisfitError(f"got {number}; it takes finite numbers", (field.name,))
            # Keeps the converted value: a list becomes a tuple, a mapping a configuration.
            msgspec.structs.force_setattr(
                self, field.name, decode_at(field.name, value, field.type)
            )
        for name in getattr(self, self.open_field or "", ()):
            if name in self.__struct_fields__:
                raise ConfigError(
                    f"{self.open_field} names {name!r}, which is the name of another key; choose "
                    "another name."
                )

    @classmethod
    def parse(cls, text: str) -> Self:
        """Return the configuration in a TOML text; raise a ConfigError if it is not valid."""
        config: Self = from_dict(from_toml(text, "this file"), cls)
        return config

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Return the configuration in a TOML file.

        Raises
        ------
        SourceError
            If the file cannot be read.
        ConfigError
            If it is not valid; the message begins with the name of the file.
        """
        text = read_text(path)
        try:
            return cls.parse(text)
        except ConfigError as error:
            raise ConfigError(f"{path}: {error}") from None

    def to_dict(self) -> dict[str, Any]:
        """Return the configuration as nested plain dicts."""
        plain: dict[str, Any] = _spread(self, msgspec.to_builtins(self))
        return plain

    def to_toml(self) -> str:
        """Return the configuration as TOML text that `parse` reads back.

        TOML has no null, so fields that are None are left out; None is always their default.
        """
        return msgspec.toml.encode(_without_none(self.to_dict())).decode()


def _spread(value: Any, plain: Any) -> Any:
    """Return the plain values of a configuration, those of open fields among the others."""
    if isinstance(value, Config):
        for name in value.__struct_fields__:
            plain[name] = _spread(getattr(value, name), plain[name])
        if value.open_field is not None:
            plain |= plain.pop(value.open_field)
    return plain


def merge(base: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with `changes` laid over it, nested mappings key by key.

    If a change names another `type`, the base's values there belong to the old type. They are
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


def from_dict(values: Mapping[str, Any], kind: Any) -> Any:
    """Return the configuration of type `kind` (a class or a union of classes) from plain values.

    Raises a ConfigError for an unknown key, with the nearest known one, or a value that does not
    fit; and a PluginError if a value belongs to another package that cannot be used.
    """
    try:
        return decode(values, kind)
    except MisfitError as error:
        where = error.where
        if error.unknown is None:
            end = "" if error.reason.endswith(".") else "."
            place = f"Config {where}: " if where else ""
            raise ConfigError(f"{place}{error.reason}{end}") from None
        name, known = error.unknown, sorted(error.known)
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"known keys: {', '.join(known)}."
        raise ConfigError(
            f"Config has no key {f'{where}.{name}' if where else name!r}; {hint}"
        ) from None


def from_toml(text: str, name: str) -> dict[str, Any]:
    """Return the values in a TOML text; `name` names the text in errors."""
    if _DEEP.search(text):  # to read it takes time and memory with the square of its length
        raise ConfigError(f"{name} has a key of more than {DEEPEST} parts.")
    try:
        return tomllib.loads(text)
    except ValueError as error:  # a number of thousands of digits is no TOMLDecodeError
        raise ConfigError(f"{name} is not valid TOML: {error}.") from None
    except RecursionError:
        raise ConfigError(f"{name} is nested too deeply.") from None


def checked_seed(seed: object) -> int:
    """Return a seed as an int; raise a ConfigError if it is not from 0 to 2**64 - 1."""
    if not isinstance(seed, numbers.Integral) or not 0 <= int(seed) < 1 << 64:
        raise ConfigError(f"A seed is a whole number from 0 to 2**64 - 1; got {seed!r}.")
    return int(seed)


def _without_none(value: Any) -> Any:
    """Return plain values without the keys whose value is None, at any depth."""
    if isinstance(value, dict):
        return {key: _without_none(each) for key, each in value.items() if each is not None}
    return [*map(_without_none, value)] if isinstance(value, list | tuple) else value
