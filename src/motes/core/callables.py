"""What is imported by name: callables of the user's own, and packages that may be missing."""

from __future__ import annotations

import importlib
import os
import shlex
import sys
from collections.abc import Callable
from functools import reduce
from typing import Any, cast

from motes.core.errors import ConfigError, MissingDependencyError, MotesError

BROKEN = "it is installed, but its import fails ({}): install it anew, or what it lacks"


def import_callable(name: str) -> Callable[..., Any]:
    """Return the callable with a name `module:callable`, also from the current folder.

    That folder comes last: a file there cannot take the place of an installed module. Raises a
    ConfigError if a file is named, or it is not callable. The import may raise other errors.
    """
    module, _, path = name.partition(":")
    if module.endswith(".py") or {"/", "\\"} & {*module}:
        raise ConfigError("Name a module, without folders and .py, and run motes in its folder.")
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())
    found = reduce(getattr, path.split("."), importlib.import_module(module))
    if not callable(found):
        raise ConfigError(f"{path} of {module} is a {type(found).__name__}, which is not callable.")
    return cast("Callable[..., Any]", found)


def explain(error: BaseException) -> str:
    """Return an error of the user's own code in one line."""
    if isinstance(error, MotesError):
        return str(error)
    kind = type(error)
    name = kind.__name__ if kind.__module__ == "builtins" else f"{kind.__module__}.{kind.__name__}"
    return " ".join(f"{name}: {error}".split())[:300].rstrip(": ")


def optional(module: str, need: str, package: str) -> Any:
    """Return a module of a package that may be missing.

    Raises a MissingDependencyError if it cannot be imported. `need` is what needs it, such as "MQTT
    needs paho-mqtt", and `package` what is to be installed, such as "motes[onnx]".
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        if is_missing(error, module):
            remedy = f"install it with: pip install {shlex.quote(package)}"
        else:
            remedy = BROKEN.format(explain(error))
        raise MissingDependencyError(f"{need}; {remedy}.") from None


def is_missing(error: Exception, module: str) -> bool:
    """Return whether an import failed as a package is not installed; else it is broken."""
    return isinstance(error, ModuleNotFoundError) and f"{module}.".startswith(f"{error.name}.")
