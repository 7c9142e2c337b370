"""From plain values to configurations, with the implementations that registries hold."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from types import UnionType
from typing import Any, Union, get_args, get_origin

import msgspec
from msgspec import Struct

from motes.core.registry import open_registry, registry_of, tag_of


def decode(values: Any, kind: Any) -> Any:
    """Return plain values, or a value that fits already, converted to a type.

    Raises
    ------
    msgspec.ValidationError
        If a value does not fit; the places in its message stand innermost first.
    UnicodeEncodeError
        For a text that is no UTF-8.
    PluginError
        If a value belongs to another package that cannot be used.
    """
    return msgspec.convert(_gathered(values, kind), kind, dec_hook=_implementation)


def _implementation(kind: Any, values: Any) -> Any:
    """Return the implementation of an interface that plain values name by the key `type`.

    It is the hook of `msgspec.convert` for types that msgspec does not know: a ValueError becomes
    a ValidationError with the place, and other errors pass through.
    """
    if isinstance(values, kind):
        return values
    registry = registry_of(kind)
    assert registry is not None, f"{kind} has no registry"
    try:
        tag = msgspec.convert(values, dict[str, Any]).get("type")
        if tag is None:
            raise ValueError("Object missing required field `type`")
        with _at("type"):
            tag = msgspec.convert(tag, str)
            tag.encode()
            if tag not in registry or not issubclass(registry.resolve(tag), kind):
                raise msgspec.ValidationError(f"Invalid value {tag!r}")
        return decode(values, registry.resolve(tag))
    except UnicodeEncodeError as error:
        raise ValueError(f"It takes texts in UTF-8, got {error.object!r}") from None
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from None


def _gathered(values: Any, kind: Any) -> Any:
    """Return plain values; those of other packages are moved into the open field for them."""
    union = get_origin(kind) in (Union, UnionType)
    kinds = [
        part
        for part in (get_args(kind) if union else (kind,))
        if isinstance(part, type) and issubclass(part, Struct) and isinstance(values, Mapping)
    ]
    if len(kinds) > 1:
        kinds = [part for part in kinds if tag_of(part) == values.get("type")]
    if not kinds:
        return values
    declared = {field.name: field.type for field in msgspec.structs.fields(kinds[0])}
    gathered: dict[str, Any] = {}
    for key, value in values.items():
        with _at(key):
            gathered[key] = _gathered(value, declared[key]) if key in declared else value
    name, registry = open_registry(kinds[0])
    if registry is None:
        return gathered
    if name in gathered:
        raise msgspec.ValidationError(f"Object contains unknown field `{name}`")
    added = {}
    for key in [key for key in gathered if key not in declared and key != "type"]:
        if key in registry:
            value = gathered.pop(key)
            with _at(key):
                if value is not None:
                    added[key] = decode(value, registry.resolve(key))
    return gathered | {name: added}


@contextlib.contextmanager
def _at(key: str) -> Iterator[None]:
    """Add a key to the place in a ValidationError, as msgspec writes places."""
    try:
        yield
    except msgspec.ValidationError as error:
        raise msgspec.ValidationError(f"{error} - at `$.{key}`") from None
