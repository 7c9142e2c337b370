"""Trained networks of the studio are tried in a process of their own, which they may end."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import pytest

from motes.core.errors import FormatError
from motes.studio import networks
from motes.studio.networks import Networks
from motes.studio.safety import Limits
from onnx_trackers import save_pair

pytestmark = pytest.mark.slow


def killed(*_: Any, **__: Any) -> None:
    """End the process as a crafted file may."""
    os.kill(os.getpid(), signal.SIGSEGV)


def stuck(*_: Any, **__: Any) -> None:
    """Never end."""
    while True:
        time.sleep(60)


def take(folder: Path, limits: Limits) -> list[str]:
    """Send a good network."""
    paths = [Path(path) for path in save_pair(folder)]
    data = [path.read_bytes() for path in paths]

    async def parts() -> AsyncIterator[bytes]:
        yield b"".join(data)

    taken = Networks(folder / "kept", limits).take(
        [path.name for path in paths], [len(each) for each in data], parts()
    )
    return asyncio.run(taken)


def test_a_good_network_is_kept(tmp_path: Path) -> None:
    files = take(tmp_path, Limits())
    assert [Path(file).name for file in files] == ["backbone.onnx", "head.onnx"]
    assert Networks(tmp_path / "kept", Limits()).listed() == [files]


@pytest.mark.skipif(os.name == "nt", reason="Windows ends processes in another way")
@pytest.mark.parametrize(
    ("opens", "silence", "words"),
    [(killed, 60.0, r"has ended its worker \(SIGSEGV"), (stuck, 0.5, r"busy for 0\.5 s")],
)
def test_a_network_that_ends_its_process_is_refused(
    opens: Callable[..., None],
    silence: float,
    words: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(networks, "open_network", opens)
    with pytest.raises(FormatError, match=words):
        take(tmp_path, Limits(silence=silence))
    assert Networks(tmp_path / "kept", Limits()).listed() == []
