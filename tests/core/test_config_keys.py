"""The keys of configuration types, and the one place where their meanings are written."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from typing import Annotated, Literal

import msgspec
import pytest
from msgspec import Meta

import motes
from motes.core.config import Config, Count, Positive, Share
from motes.core.config_keys import keys, meanings
from motes.core.type_words import words


class Small(Config, frozen=True, tag="small"):
    """A small one."""

    size: Count = 3
    """The size,
    in pixels."""
    left: float = 0.0
    right: float | None = None
    """The sides."""


class Large(Small, frozen=True, tag="large"):
    """A large one."""

    left: float = 0.0
    """The left side of a large one."""


class Holder(Config, frozen=True):
    """Holds one."""

    item: Small | Large
    maybe: Small | None = None
    several: tuple[Small, ...] = ()
    by_name: dict[str, Share] = {}  # noqa: RUF012  (msgspec copies it)


def test_meanings_are_read_from_docstrings() -> None:
    assert meanings(Small) == {
        "size": "The size, in pixels.",
        "left": "The sides.",
        "right": "The sides.",
    }
    assert meanings(Large) == {**meanings(Small), "left": "The left side of a large one."}


def test_keys_have_values_of_a_configuration_or_defaults() -> None:
    item, maybe, several, by_name = keys(Holder, Holder(Large(size=5), by_name={"a": 0.5}))
    assert [(choice.tag, choice.chosen) for choice in item.choices] == [
        ("small", False),
        ("large", True),
    ]
    assert [choice.keys[0].value for choice in item.choices] == ["3", "5"]
    assert [(choice.tag, choice.chosen) for choice in maybe.choices] == [(None, False)]
    assert several.choices[0].keys[0].path == "several.size"
    (entry,) = by_name.choices[0].keys
    assert (entry.path, entry.value, entry.type) == ("by_name.a", "0.5", "number, 0 to 1")
    assert [key.required for key in keys(Holder)] == [True, False, False, False]


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        (int, "integer"),
        (Positive, "number, above 0, at most 1,000,000,000"),
        (Annotated[float, Meta(ge=0.25, lt=1)], "number, at least 0.25, below 1"),
        (Annotated[int, Meta(ge=8, multiple_of=8)], "integer, at least 8, multiple of 8"),
        (bool | None, "true or false"),
        (Literal["a", "b", "c"], '"a", "b" or "c"'),
        (Literal["a"], '"a"'),
        (tuple[Share, Share], "list of 2: number, 0 to 1"),
        (tuple[int, ...], "list: integer"),
        (Annotated[tuple[int, ...], Meta(min_length=6)], "list of at least 6: integer"),
        (Annotated[list[int], Meta(min_length=9, max_length=9)], "list of 9: integer"),
        (Annotated[list[int], Meta(max_length=4)], "list of 0 to 4: integer"),
        (str, "text"),
    ],
)
def test_types_in_words(kind: object, text: str) -> None:
    assert words(kind) == text


def configurations(kind: type) -> Iterator[type]:
    each: type
    for each in kind.__subclasses__():
        if each.__module__.startswith("motes.") and not each.__name__.startswith("_"):
            yield each
        yield from configurations(each)


def test_every_field_of_every_configuration_has_a_meaning() -> None:
    for module in pkgutil.walk_packages(motes.__path__, "motes."):
        if not module.name.startswith(("motes.cli", "motes.core.posix", "motes.core.windows")):
            importlib.import_module(module.name)
    found = list(configurations(Config))
    assert len(found) > 40
    for kind in found:
        missing = {field.name for field in msgspec.structs.fields(kind)} - set(meanings(kind))
        assert not missing, f"{kind.__qualname__}: write a text below {missing}"
