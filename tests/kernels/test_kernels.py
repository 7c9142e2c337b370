"""What is kept of compiled kernels, until when, and what harm its files may come to."""

from __future__ import annotations

import importlib
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from motes.kernels import compiling

LOW = "from {0}.compiling import kernel\n\n\n@kernel\ndef low(x):\n    return {1}\n"
HIGH = (
    "from {0}.compiling import kernel\nfrom {0}.low import low\n\n\n"
    "@kernel\ndef high(x):\n    return 10 * low(x)\n"
)
Start = Callable[..., Any]
"""Writes what `low` returns, and gives `high` as a program finds it that starts afresh."""


@pytest.fixture
def kept(tmp_path: Path) -> Path:
    return tmp_path / "kept"


@pytest.fixture
def start(tmp_path: Path, kept: Path, monkeypatch: pytest.MonkeyPatch) -> Start:
    package = tmp_path / "few_kernels"
    package.mkdir()
    (package / "__init__.py").touch()
    source = Path(compiling.__file__).read_text(encoding="utf-8")
    (package / "compiling.py").write_text(source, encoding="utf-8")
    (package / "high.py").write_text(HIGH.format(package.name), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(kept))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # which is by the second

    def started(returned: str = "x") -> Any:
        (package / "low.py").write_text(LOW.format(package.name, returned), encoding="utf-8")
        importlib.invalidate_caches()
        for name in [name for name in sys.modules if name.startswith(package.name)]:
            monkeypatch.delitem(sys.modules, name)
        return importlib.import_module(f"{package.name}.high").high

    return started


def found(high: Any) -> int:
    """Return how many kernels were found compiled."""
    return sum(high.stats.cache_hits.values())


def test_a_kernel_is_compiled_anew_when_one_that_it_calls_has_changed(start: Start) -> None:
    """The code of the kernel that is called last is within that of the first."""
    results = []
    for returned in "1121":
        high = start(returned)
        results.append((high(0), found(high)))
    assert results == [(10, 0), (10, 1), (20, 0), (10, 1)]


def test_each_kind_of_arguments_has_a_file_of_its_own(start: Start) -> None:
    first, second = start(), start()
    assert (first(2), second(2.5)) == (20, 25.0)
    both = start()
    assert (both(2), both(2.5), found(both)) == (20, 25.0, 2)


@pytest.mark.slow
@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: content[: len(content) // 2],
        lambda content: bytes(len(content)),
        lambda content: content[:-1000] + bytes([content[-1000] ^ 1]) + content[-999:],
    ],
    ids=["empty", "half", "zeros", "a bit"],
)
def test_a_damaged_file_is_compiled_again(
    start: Start, kept: Path, damage: Callable[[bytes], bytes]
) -> None:
    start()(2)
    files = [*kept.rglob("*.nbc")]
    assert len(files) == 2
    for file in files:
        file.write_bytes(damage(file.read_bytes()))
    for hits in 0, 1:
        high = start()
        assert (high(2), found(high)) == (20, hits)
    assert {*files} == {file for file in kept.rglob("*") if file.is_file()}


def test_kernels_work_and_it_is_told_when_they_cannot_be_written(start: Start, kept: Path) -> None:
    high, errors = start(), list[OSError]()
    compiling.when_unkept(errors.append)
    shutil.rmtree(kept)
    assert high(2) == 20
    assert [type(error) for error in errors] == [FileNotFoundError]  # of the two, the first


def test_there_may_be_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    assert compiling._folder() is None
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = compiling._folder()
    assert folder is not None
    assert folder.parent == tmp_path / "motes" / "numba"
