"""Programs of this repository that are no part of a package."""

import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).parents[1]


def script(path: str) -> ModuleType:
    """Return the module in a file, named from the root of the repository."""
    place = ROOT / path
    spec = importlib.util.spec_from_file_location(place.stem, place)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[place.stem] = module
    spec.loader.exec_module(module)
    return module


def uncounted() -> dict[str, str]:
    """Return the environment of a process whose lines `make coverage` does not count.

    To count them, modules are imported and processes end in other ways.
    """
    return {name: value for name, value in os.environ.items() if "COVERAGE" not in name}
