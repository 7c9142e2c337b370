"""What is kept of compiled kernels, and until when."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numba
import pytest

from motes.kernels import compiling

LOW = "from {0}.compiling import kernel\n\n\n@kernel\ndef low() -> int:\n    return {1}\n"
HIGH = (
    "from {0}.compiling import kernel\nfrom {0}.low import low\n\n\n"
    "@kernel\ndef high() -> int:\n    return 10 * low()\n"
)


def test_a_kernel_is_compiled_anew_when_one_that_it_calls_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By itself, numba looks only at the file of the kernel that is called first."""
    package = tmp_path / "few_kernels"
    package.mkdir()
    (package / "__init__.py").touch()
    source = Path(compiling.__file__).read_text(encoding="utf-8")
    (package / "compiling.py").write_text(source, encoding="utf-8")
    (package / "high.py").write_text(HIGH.format(package.name), encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # which is by the second

    def result(returned: int) -> tuple[int, int]:
        """Return what a fresh start computes, and how many kernels it found compiled."""
        (package / "low.py").write_text(LOW.format(package.name, returned), encoding="utf-8")
        importlib.invalidate_caches()
        for name in [name for name in sys.modules if name.startswith(package.name)]:
            monkeypatch.delitem(sys.modules, name)
        high = importlib.import_module(f"{package.name}.high").high
        return high(), sum(high.stats.cache_hits.values())

    assert [result(n) for n in (1, 1, 2, 1)] == [(10, 0), (10, 1), (20, 0), (10, 1)]


def test_the_folder_is_for_kernels_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "of others")
    compiling.kernel(lambda: 1)
    assert vars(numba.config)["CACHE_DIR"] == "of others"


def test_there_may_be_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "file"))
    assert compiling._folder() is None
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder = compiling._folder()
    assert folder is not None
    assert folder.parent == tmp_path / "motes" / "numba"
