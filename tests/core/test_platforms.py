"""What motes asks of the system is the same on all of them."""

import ast
from pathlib import Path

import pytest

from motes.core import platforms


def functions(body: list[ast.stmt]) -> dict[str, str]:
    """Return the functions of a part of a module: their arguments and results as text."""
    return {
        node.name: f"{ast.unparse(node.args)} -> {ast.unparse(node.returns or ast.Constant(None))}"
        for node in body
        if isinstance(node, ast.FunctionDef)
    }


def test_windows_has_the_same_functions_as_posix() -> None:
    *_, systems = ast.parse(Path(platforms.__file__).read_text(encoding="utf-8")).body
    assert isinstance(systems, ast.If)
    assert functions(systems.body) == functions(systems.orelse)
    assert len(functions(systems.body)) == 5


def test_a_file_is_locked_once_until_it_is_closed(tmp_path: Path) -> None:
    with (tmp_path / "lock").open("wb") as first, (tmp_path / "lock").open("wb") as second:
        platforms.lock(first)
        with pytest.raises((BlockingIOError, PermissionError)):
            platforms.lock(second)
    with (tmp_path / "lock").open("wb") as third:
        platforms.lock(third)


def test_limits_are_of_addresses_and_files() -> None:
    addresses, files = platforms.limits()
    assert addresses > 1e8
    assert files >= 32
