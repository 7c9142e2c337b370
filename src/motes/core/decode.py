"""From plain values to configurations, with the implementations that registries hold."""

from __future__ import annotations

import contextlib
import reprlib
from collections.abc import Mapping, Sequence
from types import NoneType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin

import msgspec
import numpy as np

from motes.core.config_keys import alternatives, configurations, fields, words
from motes.core.errors import ConfigError
from motes.core.registry import fields_of, open_registry, registry_of, tag_of

Place = tuple[str | int, ...]
"""Where a value stands: keys, and the numbers of a list's items."""


class MisfitError(ConfigError):
    """A value does not fit at its place in a configuration.

    Attributes
    ----------
    reason
        What is wrong, in words.
    place
        Where it is wrong.
    unknown
        The key there that is not known, if that is wrong.
    known
        The keys that are known there then.
    """

    def __init__(
        self, reason: str, place: Place = (), unknown: str | None = None, known: Sequence[str] = ()
    ) -> None:
        where = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in place)
        self.reason, self.place, self.unknown, self.known = reason, place, unknown, known
        self.where = where.lstrip(".")
        super().__init__(f"{self.where}: {reason}" if place else reason)


def of_numpy(value: Any) -> Any:
    """Return numbers and arrays of numpy as those of Python, and all else as it is."""
    return value.tolist() if isinstance(value, np.generic | np.ndarray) else value


def decode(value: Any, kind: Any) -> Any:
    """Return a plain value, or one that fits already, converted to a type.

    Raises a MisfitError if it does not fit, with the place of what does not; and a PluginError if a
    value belongs to another package that cannot be used.
    """
    value = of_numpy(value)
    kinds = configurations(kind)
    if any(isinstance(value, each) for each in kinds):
        return value
    if kinds and isinstance(value, Mapping):
        return _made(value, _chosen(value, kind, kinds))
    if value is not None and get_origin(kind) in (Union, UnionType):
        others = [part for part in get_args(kind) if part is not NoneType]
        kind = others[0] if len(others) == 1 else kind
    bare = get_args(kind)[0] if get_origin(kind) is Annotated else kind
    origin, inner = get_origin(bare), get_args(bare)
    if origin in (list, tuple) and inner[0] is str and isinstance(value, str) and value:
        value = [part.strip() for part in value.split(",")]  # of a flag
    if origin is dict and isinstance(value, Mapping):
        return {key: decode_at(key, item, inner[1]) for key, item in value.items()}
    if origin in (list, tuple) and isinstance(value, list | tuple):
        items = inner if origin is tuple and ... not in inner else (inner[0],) * len(value)
        if len(items) == len(value):
            pairs = zip(value, items, strict=True)
            value = origin(decode_at(place, *pair) for place, pair in enumerate(pairs))
            if bare is kind:
                return value
    with contextlib.suppress(msgspec.ValidationError, UnicodeEncodeError):
        if not kinds or value is None:  # the number of items is checked here too
            return msgspec.convert(value, kind)
    if isinstance(value, type) and issubclass(value, tuple(kinds)):
        raise MisfitError(f"got {_short(value)}; it takes a value of it, {value.__name__}()")
    if kinds and registry_of(kinds[0]) is not None:
        if not (known := _tags(kind)):  # as of cues, which their keys name
            raise MisfitError(f"got {_short(value)}; it takes a {kinds[0].__name__}")
        reason = f"this key is missing before {_short(value)}; known are {known}"
        raise MisfitError(reason, ("type",))
    inside = f"keys: {', '.join(field.name for field in fields(kinds[0]))}" if kinds else "keys"
    takes = inside if kinds or origin is dict else words(kind)
    raise MisfitError(f"got {_short(value)}; it takes {takes}")


def _tags(kind: Any) -> str:
    """Return the tags of the classes that a type accepts, as text."""
    tags = map(tag_of, alternatives(kind))
    return ", ".join(str(tag) for tag in tags if tag is not None)


def _chosen(values: Mapping[str, Any], kind: Any, kinds: list[type]) -> type:
    """Return the class that plain values are of: the one that their key `type` names."""
    registry = registry_of(kinds[0])
    tag = values.get("type")
    if registry is None:
        if len(kinds) == 1 and (tag is None or tag_of(kinds[0]) is None):
            return kinds[0]
        fitting = [each for each in kinds if tag_of(each) == tag]
    elif isinstance(tag, str) and tag in registry:
        fitting = [each for each in [registry.resolve(tag)] if issubclass(each, kinds[0])]
    else:
        fitting = []
    if fitting:
        return fitting[0]
    if "type" not in values:
        raise MisfitError(f"it needs the key type; known are {_tags(kind)}")
    raise MisfitError(f"Invalid value {_short(tag)}; known are {_tags(kind)}", ("type",))


def _made(values: Mapping[str, Any], kind: type) -> Any:
    """Return a configuration of plain values; those of other packages go into its open field."""
    name, registry = open_registry(kind)
    own = {field.name: field for field in fields_of(kind) if field.name != name}
    given: dict[str, Any] = {}
    added: dict[str, Any] = {}
    for key, value in values.items():
        if key in own:
            given[key] = decode_at(key, value, own[key].type)
        elif key == "type" and tag_of(kind) is not None:
            continue
        elif registry is not None and key in registry:
            if value is not None:
                added[key] = decode_at(key, value, registry.resolve(key))
        else:
            known = [field.name for field in fields(kind)]
            known += ["type"] * (tag_of(kind) is not None)
            raise MisfitError(f"unknown key {key!r}", (), str(key), known)
    for key, field in own.items():
        if key not in given and field.required:
            raise MisfitError(f"the key {key!r} is missing")
    try:
        return kind(**given, **({name: added} if name else {}))
    except MisfitError:
        raise
    except ValueError as error:  # of the class itself, complete
        raise MisfitError(str(error)) from None


def _short(value: Any) -> str:
    """Return a value for a message, cut to one line."""
    try:
        return reprlib.repr(value)
    except ValueError:
        return "a number of thousands of digits"


def decode_at(key: str | int, value: Any, kind: Any) -> Any:
    """Return a converted value that stands at a key."""
    try:
        return decode(value, kind)
    except MisfitError as error:
        place, reason = (key, *error.place), error.reason
        several = get_args(kind)[0] if get_origin(kind) in (list, tuple) else None
        if configurations(several) and not error.place:
            reason = f"got {_short(value)}; it takes a list of tables, as in [[{key}]]"
        raise MisfitError(reason, place, error.unknown, error.known) from None
