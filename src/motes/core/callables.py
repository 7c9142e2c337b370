"""Callables of the user's own, by name."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable
from functools import reduce
from typing import Any

from motes.core.errors import ConfigError, MotesError


def import_callable(name: str) -> Callable[..., Any]:
    """Return the callable with a name `module:callable`, also from the current folder.

    That folder comes last: a file there cannot take the place of an installed module. Raises a
    ConfigError if it is not callable. The import may raise other errors.
    """
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    module, _, path = name.partition(":")
    found = reduce(getattr, path.split("."), importlib.import_module(module))
    if not callable(found):
        raise ConfigError(f"{path} of {module} is a {type(found).__name__}, which is not callable.")
    made: Callable[..., Any] = found
    return made


def explain(error: BaseException) -> str:
    """Return an error of the user's own code in one line."""
    if isinstance(error, MotesError):
        return str(error)
    kind = type(error)
    name = kind.__name__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__name__}"
    return " ".join(f"{name}: {error}".split())[:300].rstrip(": ")
