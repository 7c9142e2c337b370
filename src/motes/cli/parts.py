"""What commands of motes leave to other programs, which join by entry points.

A rig of cameras and events over networks are in motes-fleet, the figures of the papers
in motes-lab; a run that asks for one of these without its program says what to install.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from motes.core.errors import MissingDependencyError
from motes.core.registry import Registry

PARTS = Registry[Callable[..., Any]]("part", "motes.parts", Callable, {}, values=True)


def part(name: str, need: str, program: str = "fleet") -> Callable[..., Any]:
    """Return what another program brings.

    Raises a MissingDependencyError if no installed package has it. `name` is that of its entry
    point, and `need` what needs it, as the subject of an error.
    """
    if name not in PARTS:
        raise missing(need, program)
    return PARTS.resolve(name)


def missing(need: str, program: str) -> MissingDependencyError:
    """Return the error for something that a program brings which is not installed."""
    return MissingDependencyError(
        f"{need} needs motes-{program}; install it with: pip install 'motes[{program}]'."
    )
