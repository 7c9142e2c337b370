"""Configuration: frozen values that check themselves, from Python, TOML or command-line flags."""

from __future__ import annotations

import contextlib
import difflib
import math
import numbers
import re
import tomllib
from collections.abc import Iterator, Mapping
from functools import reduce
from types import UnionType
from typing import Annotated, Any, ClassVar, Literal, TypeVar, Union, get_args, get_origin

import msgspec
from msgspec import Meta

from motes.core.errors import ConfigError
from motes.core.registry import Registry, registry_of, tag_of
from motes.core.renamed_keys import RENAMED

Positive = Annotated[float, Meta(gt=0, le=1e9)]
NonNegative = Annotated[float, Meta(ge=0, le=1e9)]
Share = Annotated[float, Meta(ge=0, le=1)]
Count = Annotated[int, Meta(ge=1, le=2**31 - 1)]
"""What fits into an `int` of C, in which libraries count."""
Particles = Annotated[int, Meta(ge=1, le=1_000_000)]
"""More of them would take more memory than machines have."""

DEEPEST = 100
"""Parts of a dotted key in TOML."""
_DEEP = re.compile(rf"(?<![\w\"'-])(?:[\w\"'-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}")


class Config(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Base of all configuration: frozen, and checked on construction.

    A field's type says what it accepts; anything else, NaN and infinity included, raises a
    `ConfigError` that names the field. Subclasses with a `tag` are told apart by the key `type`.
    A field whose type has a registry takes every implementation in it.
    """

    open_field: ClassVar[str | None] = None
    """A field that holds values of other packages by name. As plain values they stand among the
    other fields: `hue.bins`, not `extra_cues.hue.bins`."""

    def __post_init__(self) -> None:
        for field in msgspec.structs.fields(self):
            value = getattr(self, field.name)
            if type(value) is not bool and isinstance(value, numbers.Real):
                # numpy's numbers are as good as Python's
                value = int(value) if isinstance(value, numbers.Integral) else float(value)
            try:
                for number in value if isinstance(value, list | tuple) else (value,):
                    if isinstance(number, float) and not math.isfinite(number):
                        raise ConfigError(f"Expected a finite number, got {number}")
                # Keeps what was meant: a list becomes a tuple, a mapping a configuration.
                converted = _convert(value, field.type)
                msgspec.structs.force_setattr(self, field.name, converted)
            except (msgspec.ValidationError, ConfigError) as error:
                raise ConfigError(f"{field.name}: {error}") from None


C = TypeVar("C", bound=Config)


def to_dict(config: Config) -> dict[str, Any]:
    """Return a configuration as nested plain dicts."""
    plain: dict[str, Any] = _spread(config, msgspec.to_builtins(config))
    return plain


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
    PluginError
        If a value is of another package, which cannot be used.
    """
    try:
        return _convert(values, kind)
    except UnicodeEncodeError as error:  # of an option, which may be any bytes
        raise ConfigError(f"Config takes texts in UTF-8, got {error.object!r}.") from None
    except msgspec.ValidationError as error:
        message, *places = str(error).split(" - at `$")  # the innermost first
        where = "".join(place.rstrip("`") for place in reversed(places)).lstrip(".")
        unknown = re.search(r"unknown field `(.+?)`", message)
        if message.endswith("."):  # it is of a configuration itself, and complete
            raise ConfigError(f"Config {where}: {message}" if where else message) from None
        if unknown is None:
            given = reduce(_item, re.findall(r"[^.\[\]]+", where), values)
            got = "" if re.search("got|nvalid", message) else f", got {given}"
            choices = _choices(kind, where.split("."))
            words = f"; known are {', '.join(choices)}" if choices else ""
            place = f"Config {where}: " if where else ""
            raise ConfigError(f"{place}{message}{got}{words}.") from None
        name = unknown[1]
        known = [key for key in _all_keys(kind) if key != name]  # it may well be one elsewhere
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"known keys: {', '.join(known)}."
        if RENAMED.get(name) in known:
            hint = f"it is {RENAMED[name]!r} now."
        raise ConfigError(
            f"Config has no key {f'{where}.{name}' if where else name!r}; {hint}"
        ) from None


def _convert(values: Any, kind: Any) -> Any:
    """Return values as a type says, or raise a `msgspec.ValidationError`."""
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
        return _convert(values, registry.resolve(tag))
    except UnicodeEncodeError as error:
        raise ValueError(f"It takes texts in UTF-8, got {error.object!r}") from None
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from None


def _gathered(values: Any, kind: Any) -> Any:
    """Return plain values with those of other packages under the open field that holds them."""
    kinds = [part for part in _structs(kind) if isinstance(values, Mapping)]
    if len(kinds) > 1:
        kinds = [part for part in kinds if tag_of(part) == values.get("type")]
    if not kinds:
        return values
    declared = {field.name: field.type for field in msgspec.structs.fields(kinds[0])}
    gathered: dict[str, Any] = {}
    for key, value in values.items():
        with _at(key):
            gathered[key] = _gathered(value, declared[key]) if key in declared else value
    name, registry = kinds[0].open_field, _open_registry(kinds[0])
    if name is None or registry is None:
        return gathered
    if name in gathered:
        raise msgspec.ValidationError(f"Object contains unknown field `{name}`")
    added = {}
    for key in [key for key in gathered if key not in declared and key != "type"]:
        if key in registry:
            value = gathered.pop(key)
            with _at(key):
                if value is not None:
                    added[key] = _convert(value, registry.resolve(key))
    return gathered | {name: added}


@contextlib.contextmanager
def _at(key: str) -> Iterator[None]:
    """Add a key to the place in a ValidationError, as msgspec writes places."""
    try:
        yield
    except msgspec.ValidationError as error:
        raise msgspec.ValidationError(f"{error} - at `$.{key}`") from None


def keys(kind: Any) -> list[str]:
    """Return the keys that values of a configuration type, or of any in a union, may have."""
    return sorted({key for part in _structs(kind, opened=True) for key in _declared(part)})


def _structs(kind: Any, *, opened: bool = False) -> list[type[Config]]:
    """Return the types in a union, or the type itself, that are configurations.

    If `opened`, also those inside of lists and mappings, and the implementations of interfaces.
    """
    union = get_origin(kind) in (Union, UnionType)
    found: list[type[Config]] = []
    for part in ((union or opened) and get_args(kind)) or (kind,):
        if isinstance(part, type) and issubclass(part, Config):
            found.append(part)
        elif opened and (registry := registry_of(part)) is not None:
            found += [each for each in registry.usable().values() if issubclass(each, part)]
    return found


def _open_registry(kind: type[Config]) -> Registry[Any] | None:
    """Return the registry of what a type's open field holds; None if it has no open field."""
    if kind.open_field is None:
        return None
    [held] = (field.type for field in msgspec.structs.fields(kind) if field.name == kind.open_field)
    return registry_of(get_args(held)[1])


def _declared(kind: type[Config]) -> dict[str, Any]:
    """Return the types of all keys of a configuration type, those of other packages included."""
    found = {field.name: field.type for field in msgspec.structs.fields(kind)}
    registry = _open_registry(kind)
    if kind.open_field is not None and registry is not None:
        del found[kind.open_field]
        found |= {name: held for name, held in registry.usable().items() if name not in found}
    return found


def _choices(kind: Any, path: list[str]) -> list[str]:
    """Return the words that may stand at a path in a configuration type, if it takes words."""
    if not path:
        return [str(word) for word in get_args(kind)] if get_origin(kind) is Literal else []
    parts = _structs(kind, opened=True)
    if path == ["type"]:
        return [str(tag) for part in parts if (tag := tag_of(part)) is not None]
    found: list[str] = []
    for part in parts:
        declared = _declared(part)
        if path[0] in declared:
            found += _choices(declared[path[0]], path[1:])
    return list(dict.fromkeys(found))


def _item(values: Any, key: str) -> Any:
    """Return an item of a mapping or list, or what is there instead."""
    if isinstance(values, Mapping):
        return values.get(key, values)
    return values[int(key)] if isinstance(values, list | tuple) else values


def _all_keys(kind: Any) -> list[str]:
    """Return the keys of a configuration type and of all types inside it."""
    found: set[str] = set()
    for part in _structs(kind, opened=True):
        for key, inner in _declared(part).items():
            found |= {key, *_all_keys(inner)}
    return sorted(found)


def from_toml(text: str, name: str) -> dict[str, Any]:
    """Return the values in a TOML text; `name` is what an error calls it."""
    if _DEEP.search(text):  # whose reading takes time and memory with the square of its length
        raise ConfigError(f"{name} has a key of more than {DEEPEST} parts.")
    try:
        return tomllib.loads(text)
    except ValueError as error:  # a number of thousands of digits is no TOMLDecodeError
        raise ConfigError(f"{name} is not valid TOML: {error}.") from None
    except RecursionError:
        raise ConfigError(f"{name} is nested too deeply.") from None


def from_json(data: bytes) -> Any:
    """Return the values in a JSON text; raise a ConfigError if it is none."""
    try:
        return msgspec.json.decode(data)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ConfigError(f"It is not valid JSON: {error}") from None


def to_toml(config: Config) -> str:
    """Return a configuration as TOML text that `from_toml` reads back.

    TOML knows no null: what is None, always its default, is left out.
    """
    return msgspec.toml.encode(_without_none(to_dict(config))).decode()


def _without_none(values: dict[str, Any]) -> dict[str, Any]:
    return {
        key: _without_none(value) if isinstance(value, dict) else value
        for key, value in values.items()
        if value is not None
    }


def from_flag(key: str, text: str) -> dict[str, Any]:
    """Return `{"motion": {"noise": 0.2}}` for the flag `--motion.noise 0.2`.

    The text is read as a TOML value; `8,8,8` is a list, and what is no TOML value is a string.
    """
    value: Any = text
    with contextlib.suppress(ValueError, RecursionError):
        value = tomllib.loads(
            f"value = [{text}]" if re.match(r"[^\[].*,", text) else f"value = {text}"
        )["value"]
    for part in reversed(key.split(".")):
        value = {part: value}
    nested: dict[str, Any] = value
    return nested
