"""`motes network`: networks from a server on this machine, and --network with their names."""

import errno
import hashlib
import os
import sys
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from io import StringIO
from pathlib import Path
from threading import Thread

import numpy as np
import pytest

from clips import write_pictures
from motes.cli import main
from motes.core import files
from motes.sot.network import published
from motes.sot.network.network import Network
from motes.sot.network.published import PublishedFile, PublishedNetwork, folder_of
from onnx_trackers import save_pair
from oracles import mosaic


class Quiet(SimpleHTTPRequestHandler):
    """Serves the files of a folder."""

    def log_message(self, *_: object) -> None:
        """Say nothing."""


class Terminal(StringIO):
    """A terminal at which an answer has been typed."""

    def isatty(self) -> bool:
        """Return that it is one."""
        return True


@pytest.fixture
def served(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Publish a network on a server, as the only one; yield the folder of its files."""
    folder = tmp_path / "served"
    folder.mkdir()
    paths = [Path(path) for path in save_pair(folder)]
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(sys, "platform", "linux")
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(folder))) as server:
        thread = Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        found = tuple(
            PublishedFile(
                f"http://127.0.0.1:{server.server_port}/{path.name}",
                path.stat().st_size,
                hashlib.sha256(path.read_bytes()).hexdigest(),
            )
            for path in paths
        )
        network = PublishedNetwork("A pair", "http://127.0.0.1/", "as you like", found)
        monkeypatch.setattr(published, "PUBLISHED", {"pair": network})
        monkeypatch.setattr("motes.cli.network.PUBLISHED", {"pair": network})
        yield folder
        server.shutdown()
        thread.join()


def kept() -> list[str]:
    """Return the names of all that is in the folder of networks."""
    folder = folder_of("pair").parent
    return sorted(os.listdir(folder)) if folder.exists() else []


def test_a_network_is_downloaded_and_used(
    served: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    film, rows = tmp_path / "film.mp4", tmp_path / "rows.csv"
    write_pictures(film, (np.roll(mosaic(0, 96, 128), shift, axis=1) for shift in range(4)))
    words = ["track", str(film), "--init", "40,30,30,24", "-o", str(rows), "--network", "pair"]
    assert main(words) == 3
    assert "not on this computer; get it with: motes network get pair\n" in capsys.readouterr().err
    assert main(["network", "list"]) == 0
    assert "not here" in capsys.readouterr().out

    assert main(["network", "get", "pair", "--yes"]) == 0
    out, error = capsys.readouterr()
    assert "A pair" in out
    assert "license: as you like" in out
    assert "use it with --network pair." in error
    assert kept() == ["pair"]
    for path in served.iterdir():
        assert (folder_of("pair") / path.name).read_bytes() == path.read_bytes()

    assert main(words) == 0
    assert main(["network", "list"]) == 0
    assert f"here, in {folder_of('pair')}" in capsys.readouterr().out
    assert main(["network", "get", "pair"]) == 0
    assert "here already" in capsys.readouterr().err
    assert main(["doctor"]) == 0
    assert f"pair            {folder_of('pair')}\n" in capsys.readouterr().out
    assert Network.named("pair").files == ("pair",)
    assert Network(files=("pair",)).open() == "siamese"


def test_a_file_of_that_name_goes_before(
    served: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pair").touch()
    assert published.paths_of(("pair",)) == ("pair",)
    assert published.paths_of(("pair", "other")) == ("pair", "other")


@pytest.mark.parametrize(("answer", "got"), [("y", True), ("Yes", True), ("n", False), ("", False)])
@pytest.mark.usefixtures("served")
def test_it_asks(answer: str, got: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", Terminal(f"{answer}\n" if answer else ""))
    assert main(["network", "get", "pair"]) == 0
    assert kept() == ["pair"] * got


@pytest.mark.usefixtures("served")
def test_where_nobody_can_be_asked(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "stdin", StringIO("y\n"))
    assert main(["network", "get", "pair"]) == 2
    assert capsys.readouterr().err.endswith("add --yes.\n")
    assert main(["network", "get", "pear", "--yes"]) == 2
    assert "no network 'pear' to get; known are pair." in capsys.readouterr().err
    assert kept() == []


def test_what_goes_wrong_leaves_nothing(
    served: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The second file is missing; the disk is full; Ctrl-C."""

    def ended(code: int, words: str) -> None:
        assert main(["network", "get", "pair", "--yes"]) == code
        error = capsys.readouterr().err
        assert words in error
        assert error.count("\n") == (1 if words else 0)
        assert kept() == []

    second = served / published.PUBLISHED["pair"].files[1].name
    content = second.read_bytes()
    second.unlink()
    ended(3, f"refuses {second.name}: 404")
    second.write_bytes(content)

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as context:
        context.setattr(files, "write_all", full)
        ended(5, "cannot be written: No space left on device; make room")

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as context:
        context.setattr(files, "write_all", interrupted)
        ended(130, "")
    with monkeypatch.context() as context:
        context.setattr("motes.core.download._read", interrupted)
        ended(130, "")
    assert main(["network", "get", "pair", "--yes"]) == 0
    assert kept() == ["pair"]


@pytest.mark.usefixtures("served")
def test_damaged_files_are_found_and_replaced(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["network", "get", "pair", "--yes"]) == 0
    next(folder_of("pair").iterdir()).write_bytes(b"damaged")
    assert main(["doctor"]) == 1
    assert "are damaged; motes network get pair" in capsys.readouterr().out
    assert main(["network", "get", "pair", "--yes"]) == 0
    assert main(["doctor"]) == 0
    assert kept() == ["pair"]


@pytest.mark.parametrize(
    ("system", "variables", "folder"),
    [
        ("linux", {"XDG_CACHE_HOME": "/c"}, "/c"),
        ("linux", {}, "/home/me/.cache"),
        ("darwin", {"XDG_CACHE_HOME": "/c"}, "/home/me/Library/Caches"),
        ("win32", {"LOCALAPPDATA": "/d"}, "/d"),
        ("win32", {}, "/home/me/AppData/Local"),
    ],
)
def test_the_folder_is_where_the_system_has_caches(
    system: str, variables: dict[str, str], folder: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(published.sys, "platform", system)  # type: ignore[attr-defined]
    monkeypatch.setattr(Path, "home", lambda: Path("/home/me"))
    for name in ("XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    assert folder_of("pair") == Path(folder, "motes", "networks", "pair")
