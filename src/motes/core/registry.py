"""Extension points: the implementations of an interface by name, ours and those of other packages.

A package adds an implementation with an entry point in its `pyproject.toml`:

    [project.entry-points."motes.cues"]
    hue = "motes_hue:Hue"

Entry points are read only for a name that motes does not have itself, so no start waits for them.
"""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any, Generic, TypeVar, get_args

import msgspec

from motes.core.errors import ConfigError, PluginError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

T = TypeVar("T")


class Registry(Generic[T]):
    """The implementations of one interface, by name.

    Errors call it `kind`, such as cue; `group` is that of its entry points, such as motes.cues.
    With `values`, the implementations are values of the class `base`, else subclasses of it: a
    field of a configuration with this type takes any of them, and if they are `tagged`, the key
    `type` names one by its tag. `own` are those in motes, by name; also as `module:Class`, to
    import when needed.
    """

    def __init__(
        self,
        kind: str,
        group: str,
        base: Any,
        own: Mapping[str, T | str],
        *,
        tagged: bool = True,
        values: bool = False,
    ) -> None:
        self.kind, self.group, self.base = kind, group, base
        self._tagged, self._values = tagged, values
        self._own = dict(own)
        _REGISTRIES[base] = self

    def names(self) -> list[str]:
        """Return the names of all implementations: ours, then those of other packages."""
        return [*self._own, *sorted(self._added())]

    def __contains__(self, name: object) -> bool:
        return name in self._own or name in self._added()

    def resolve(self, name: str) -> T:
        """Return the implementation of a name.

        Raises a ConfigError that lists the known names for an unknown one, and a PluginError if the
        package that adds the name cannot be used.
        """
        own = self._own.get(name)
        if isinstance(own, str):
            module, _, attribute = own.partition(":")
            found: T = getattr(importlib.import_module(module), attribute)
            return found
        if own is not None:
            return own
        entry = self._added().get(name)
        if entry is None:
            known = ", ".join(self.names())
            raise ConfigError(f"There is no {self.kind} {name!r}; known are {known}.")
        return self._load(entry)

    def target(self, name: str) -> str:
        """Return where another package has the implementation of a name, as `module:Class`."""
        return self._added()[name].value

    def usable(self) -> dict[str, T]:
        """Return all implementations that can be loaded, by name: the ones to choose from."""
        found: dict[str, T] = {}
        for name in self.names():
            with contextlib.suppress(PluginError):
                found[name] = self.resolve(name)
        return found

    def _added(self) -> dict[str, EntryPoint]:
        """Return what other packages add, by name."""
        added: dict[str, EntryPoint] = {}
        for entry in _entry_points(self.group):
            if entry.name in self._own:
                raise PluginError(
                    f"{_package(entry)} adds a {self.kind} {entry.name!r}, which motes has itself; "
                    f"uninstall the package, or rename its entry point."
                )
            if entry.name in added:
                raise PluginError(
                    f"{_package(added[entry.name])} and {_package(entry)} both add a {self.kind} "
                    f"{entry.name!r}; uninstall one of them."
                )
            added[entry.name] = entry
        return added

    def _load(self, entry: EntryPoint) -> T:
        """Return what an entry point names, checked."""
        named = f"The {self.kind} {entry.name!r} of {_package(entry)}"
        try:
            found: Any = entry.load()
        except (Exception, SystemExit) as error:  # whatever another package's code raises
            raise PluginError(
                f"{named} cannot be loaded: {type(error).__name__}: {error}; update or uninstall "
                f"the package."
            ) from error
        implementation: T = found
        if self._values:
            if not isinstance(found, self.base):
                raise PluginError(f"{named} is no {_path(self.base)}.")
            return implementation
        bases = {"motes.core.config.Config": msgspec.Struct, _path(self.base): self.base}
        for path, base in bases.items():
            if not (isinstance(found, type) and issubclass(found, base)):
                raise PluginError(f"{named} is not a subclass of {path}.")
        if self._tagged and tag_of(found) != entry.name:
            raise PluginError(
                f"{named} has the tag {tag_of(found)!r}; its tag and its entry point need one name."
            )
        return implementation


_REGISTRIES: dict[type, Registry[Any]] = {}


def registry_of(kind: object) -> Registry[Any] | None:
    """Return the registry of an interface, or of a narrower one; None for any other type."""
    bases = kind.__mro__ if isinstance(kind, type) and not issubclass(kind, msgspec.Struct) else ()
    return next((_REGISTRIES[base] for base in bases if base in _REGISTRIES), None)


@cache
def fields_of(kind: type) -> tuple[msgspec.structs.FieldInfo, ...]:
    """Return the fields of a configuration's type, kept as their annotations are read slowly."""
    return msgspec.structs.fields(kind)


def open_registry(kind: type) -> tuple[str, Registry[Any] | None]:
    """Return the open field of a configuration's type and the registry of what it holds.

    See `motes.core.config.Config.open_field`; the registry is None without such a field.
    """
    name: str | None = getattr(kind, "open_field", None)
    for field in fields_of(kind) if name is not None else ():
        if field.name == name:
            return name, registry_of(get_args(field.type)[1])
    return "", None


def tag_of(kind: type) -> str | int | None:
    """Return the tag of a configuration's type, by which the key `type` names it."""
    config: msgspec.structs.StructConfig = kind.__struct_config__  # type: ignore[attr-defined]
    return config.tag


@cache
def _entry_points(group: str) -> tuple[EntryPoint, ...]:
    from importlib.metadata import entry_points  # it takes time to load

    return tuple(entry_points(group=group))


def _path(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


def _package(entry: EntryPoint) -> str:
    """Return the package of an entry point, in the words of an error."""
    name = None if entry.dist is None else entry.dist.name  # None also if its metadata are lost
    return entry.value if name is None else f"package {name}"
