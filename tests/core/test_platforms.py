"""What motes asks of the system is the same on all of them."""

import ast
from pathlib import Path

import pytest

from motes.core import platforms as module
from motes.core.platforms import system


def functions(name: str) -> dict[str, str]:
    """Return the functions of a module beside `system`: their arguments and results as text."""
    path = Path(module.__file__).with_name(f"{name}.py")
    return {
        node.name: f"{len(node.args.args)} -> {ast.unparse(node.returns or ast.Constant(None))}"
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef)
    }


def test_windows_has_the_same_functions_as_posix() -> None:
    assert functions("windows") == functions("posix")
    assert len(functions("posix")) == 5


def test_a_file_is_locked_once_until_it_is_closed(tmp_path: Path) -> None:
    with (tmp_path / "lock").open("wb") as first, (tmp_path / "lock").open("wb") as second:
        system.lock(first)
        with pytest.raises((BlockingIOError, PermissionError)):
            system.lock(second)
    with (tmp_path / "lock").open("wb") as third:
        system.lock(third)


def test_limits_are_of_addresses_and_files() -> None:
    addresses, files = system.limits()
    assert addresses > 1e8
    assert files >= 32
