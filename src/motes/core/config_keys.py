"""The keys of a configuration: their names, values, meanings and choices, and their types in words.

The meaning of a field stands once, below it; fields without a text share the next one.
"""

from __future__ import annotations

import ast
import inspect
import json
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, get_args, get_origin

import msgspec
from msgspec import NODEFAULT, Struct, inspect as types

from motes.core.registry import fields_of, open_registry, registry_of


def words(kind: Any) -> str:
    """Return the values that a type accepts, such as `integer, 1 to 9` or `"rgb" or "hsv"`."""
    return _words(types.type_info(kind))


def _words(info: types.Type) -> str:
    match info:
        case types.IntType():
            return ", ".join(["integer", *_bounds(info)])
        case types.FloatType():
            return ", ".join(["number", *_bounds(info)])
        case types.BoolType():
            return "true or false"
        case types.LiteralType():
            *others, last = (json.dumps(value) for value in info.values)
            return " or ".join([", ".join(others), last] if others else [last])
        case types.UnionType():
            parts = [part for part in info.types if not isinstance(part, types.NoneType)]
            return " or ".join(map(_words, parts))
        case types.TupleType():
            return f"list of {len(info.item_types)}: {_words(info.item_types[0])}"
        case types.VarTupleType() | types.ListType():
            return f"list{_length(info)}: {_words(info.item_type)}"
        case _:
            return "text"


def _length(info: types.VarTupleType | types.ListType) -> str:
    """Return the number of items: ` of 9`, ` of at least 6`, ` of 4 to 8`; nothing for any."""
    least, most = info.min_length, info.max_length
    if least == most:
        return "" if most is None else f" of {most}"
    return f" of at least {least}" if most is None else f" of {least or 0} to {most}"


def _bounds(info: types.IntType | types.FloatType) -> Iterator[str]:
    """Yield the bounds of a number: `0 to 1`, `above 0`, `at most 9`, `multiple of 8`."""
    if info.ge is not None and info.le is not None:
        yield f"{_number(info.ge)} to {_number(info.le)}"
        named = []
    else:
        named = [("at least", info.ge), ("above", info.gt), ("at most", info.le)]
    for word, bound in (*named, ("below", info.lt), ("multiple of", info.multiple_of)):
        if bound is not None:
            yield f"{word} {_number(bound)}"


def _number(number: float) -> str:
    return f"{int(number):,}" if number == int(number) else f"{number:g}"


NAME = "NAME"
"""The placeholder in a path for a key that users choose, such as the name of a cue."""


@dataclass(frozen=True, slots=True)
class KeyChoice:
    """A configuration class that may stand at a key."""

    tag: str | None
    """Value of the key `type`; None if there is only one class."""
    meaning: str
    """First sentence of the class's docstring."""
    keys: tuple[Key, ...]
    """Its keys."""
    chosen: bool
    """Whether the described value is of this class."""


@dataclass(frozen=True, slots=True)
class Key:
    """A key of a configuration."""

    path: str
    """Its name, after the names of the keys around it: `motion.noise.position`."""
    type: str
    """The values that it takes, in words; empty if it takes keys."""
    value: str | None
    """The value, or the default, as TOML; None if no value is set."""
    required: bool
    """Whether there is no default."""
    meaning: str
    """The meaning of the value."""
    choices: tuple[KeyChoice, ...] = ()
    """The classes that it takes; empty if it takes a plain value."""


def alternatives(kind: Any) -> list[type[Struct]]:
    """Return the configuration classes that a type accepts.

    These are the type itself, the members of a union, or the implementations of an interface, those
    of other packages included.
    """
    found: list[type[Struct]] = []
    for part in configurations(kind):
        registry = registry_of(part)
        known = [part] if registry is None else registry.usable().values()
        found += [each for each in known if issubclass(each, part)]
    return found


def configurations(kind: Any) -> list[type]:
    """Return the configuration classes and the interfaces with a registry that a type accepts."""
    if isinstance(kind, type) and (issubclass(kind, Struct) or registry_of(kind) is not None):
        return [kind]
    if get_origin(kind) in (dict, tuple, list):
        return []
    return [found for part in get_args(kind) for found in configurations(part)]


def keys(
    kind: Any, value: Any = None, path: str = "", within: frozenset[type] = frozenset()
) -> tuple[Key, ...]:
    """Return the keys of a configuration class, or of all in a union.

    The values described are those of `value`, by default the defaults. `path` is the name of the
    key that it stands at, and `within` the classes around it: one that holds one of its own kind is
    described once.
    """
    found: dict[str, Key] = {}
    for part in alternatives(kind):
        for field in fields(part):
            usual = field.default
            if field.default_factory is not NODEFAULT:
                usual = field.default_factory()
            given = usual if value is None else _given(value, field.name)
            name = f"{path}.{field.name}" if path else field.name
            meaning = meanings(part).get(field.name, "")
            found.setdefault(name, _key(field.type, given, name, meaning, within | {part}))
    return tuple(found.values())


def fields(kind: type) -> list[msgspec.structs.FieldInfo]:
    """Return the fields of a configuration class; an open one becomes those that it may hold."""
    name, registry = open_registry(kind)
    own = [field for field in fields_of(kind) if field.name != name]
    taken = {field.name for field in own}
    added = {} if registry is None else registry.usable()
    return own + [
        msgspec.structs.FieldInfo(key, key, held | None, default=None)
        for key, held in added.items()
        if key not in taken
    ]


def _given(value: Any, name: str) -> Any:
    """Return the value of a field, or what an open field holds by that name; else None."""
    held = getattr(value, getattr(value, "open_field", None) or "", {})
    return getattr(value, name, held.get(name))


def all_keys(keys: Iterable[Key]) -> Iterator[Key]:
    """Yield keys and all keys inside them, those of every choice included."""
    for key in keys:
        yield key
        if len(key.choices) > 1:
            yield type_key(key)
        for choice in key.choices:
            yield from all_keys(choice.keys)


def type_key(key: Key) -> Key:
    """Return the key `type` of a key with several choices, which names the choice."""
    tags = [f'"{choice.tag}"' for choice in key.choices]
    chosen = next((f'"{choice.tag}"' for choice in key.choices if choice.chosen), None)
    return Key(f"{key.path}.type", ", ".join(tags), chosen, key.required, key.meaning)


@cache
def meanings(kind: type[Struct]) -> Mapping[str, str]:
    """Return the meaning of each field of a class, its bases' included, from their source."""
    found: dict[str, str] = {}
    for part in reversed(kind.__mro__):
        found |= _texts(part.__module__).get(part.__name__, {})
    return {name: text for name, text in found.items() if name in kind.__struct_fields__}


@cache
def _texts(module: str) -> Mapping[str, Mapping[str, str]]:
    """Return the texts below the fields of a module's classes; none where its source is missing."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (OSError, TypeError):  # it is built in, or was typed in
        return {}
    return {
        node.name: _below(node.body) for node in ast.walk(tree) if isinstance(node, ast.ClassDef)
    }


def _below(body: Iterable[ast.stmt]) -> dict[str, str]:
    """Return the text of each field of a class."""
    found: dict[str, str] = {}
    fields: list[str] = []
    for line in body:
        match line:
            case ast.AnnAssign(target=ast.Name(id=name)):
                fields.append(name)
            case ast.Expr(value=ast.Constant(value=str(text))):
                found |= dict.fromkeys(fields, " ".join(text.split()))
                fields = []
    return found


def _key(kind: Any, value: Any, path: str, meaning: str, within: frozenset[type]) -> Key:
    """Return a field as a key, with the choices of its type."""
    required = value is NODEFAULT
    set_value = None if required else value
    if get_origin(kind) is dict:
        inner = get_args(kind)[1]
        entries = set_value or {NAME: None}
        named = tuple(
            _key(inner, each, f"{path}.{name}", "", within) for name, each in entries.items()
        )
        return Key(path, "", None, required, meaning, (KeyChoice(None, "", named, True),))
    if get_origin(kind) in (list, tuple) and alternatives(get_args(kind)[0]):
        kind, set_value = get_args(kind)[0], None  # each item has these keys
    classes = [each for each in alternatives(kind) if each not in within]
    if not classes:
        text = None if set_value is None else json.dumps(msgspec.to_builtins(set_value))
        return Key(path, words(kind), text, required, meaning)
    choices = []
    for each in classes:
        chosen = type(set_value) is each
        inside = keys(each, set_value if chosen else None, path, within)
        tag = each.__struct_config__.tag if len(classes) > 1 else None
        choices.append(KeyChoice(None if tag is None else str(tag), summary(each), inside, chosen))
    return Key(path, "", None, required, meaning, tuple(choices))


def summary(kind: type) -> str:
    """Return the first line of a class's docstring."""
    return (kind.__doc__ or "").partition("\n")[0]
