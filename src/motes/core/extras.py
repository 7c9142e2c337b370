"""Packages that not every installation has."""

from __future__ import annotations

import importlib
import shlex
from typing import Any

from motes.core.errors import MissingDependencyError


def optional(module: str, need: str, package: str) -> Any:
    """Return a module of a package that may be missing.

    Raises a MissingDependencyError if it cannot be imported. `need` is what needs it, such as "MQTT
    needs paho-mqtt", and `package` what is to be installed, such as "motes[onnx]".
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise MissingDependencyError(
            f"{need}; install it with: pip install {shlex.quote(package)}."
        ) from None
