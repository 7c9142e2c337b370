"""The values that a configuration field accepts, in words."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from msgspec import inspect


def words(kind: Any) -> str:
    """Return the values that a type accepts, such as `integer, 1 to 9` or `"rgb" or "hsv"`."""
    return _words(inspect.type_info(kind))


def _words(info: inspect.Type) -> str:
    match info:
        case inspect.IntType():
            return ", ".join(["integer", *_bounds(info)])
        case inspect.FloatType():
            return ", ".join(["number", *_bounds(info)])
        case inspect.BoolType():
            return "true or false"
        case inspect.LiteralType():
            *others, last = (json.dumps(value) for value in info.values)
            return " or ".join([", ".join(others), last] if others else [last])
        case inspect.UnionType():
            parts = [part for part in info.types if not isinstance(part, inspect.NoneType)]
            return " or ".join(map(_words, parts))
        case inspect.TupleType():
            return f"list of {len(info.item_types)}: {_words(info.item_types[0])}"
        case inspect.VarTupleType() | inspect.ListType():
            return f"list{_length(info)}: {_words(info.item_type)}"
        case _:
            return "text"


def _length(info: inspect.VarTupleType | inspect.ListType) -> str:
    """Return the number of items: ` of 9`, ` of at least 6`, ` of 4 to 8`; nothing for any."""
    least, most = info.min_length, info.max_length
    if least == most:
        return "" if most is None else f" of {most}"
    return f" of at least {least}" if most is None else f" of {least or 0} to {most}"


def _bounds(info: inspect.IntType | inspect.FloatType) -> Iterator[str]:
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
