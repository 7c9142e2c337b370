"""The option --network of `motes track`."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from motes.cli import main
from motes.cli.network_option import with_network
from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.sot import presets
from motes.sot.network.network import Network
from onnx_trackers import save_pair


class Joined(Config, frozen=True):
    """A preset that takes a network."""

    network: Network | None = None


@pytest.fixture
def _a_preset_with_a_network(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(presets, "preset", lambda name: Joined())


@pytest.mark.usefixtures("_a_preset_with_a_network")
def test_it_sets_the_files_of_the_network(tmp_path: Path) -> None:
    assert with_network({}, "any", None) == {}
    assert with_network({}, "any", "a.onnx,b.onnx") == {"network": {"files": ["a.onnx", "b.onnx"]}}
    settings = {"network": {"threads": 2}, "points": 9}
    joined = with_network(settings, "any", "a.onnx")
    assert joined == {"network": {"threads": 2, "files": ["a.onnx"]}, "points": 9}
    assert settings["network"] == {"threads": 2}
    assert with_network({}, "any", "a.onnx", 3)["network"] == {"files": ["a.onnx"], "threads": 3}
    assert with_network(settings | {"network": {}}, "any", None, 3)["network"] == {"threads": 3}
    odd = tmp_path / "a,b.onnx"
    odd.touch()
    assert with_network({}, "any", str(odd)) == {"network": {"files": [str(odd)]}}


@pytest.mark.usefixtures("_a_preset_with_a_network")
@pytest.mark.parametrize(
    ("given", "settings", "words"),
    [
        ("a.onnx,", {}, "give files with commas between them"),
        ("a.onnx", {"network": {"files": ["b"]}}, "--network and --network.files contradict"),
        ("a.onnx", {"network": {"threads": 1}}, "--threads and --network.threads contradict"),
    ],
)
def test_what_cannot_be_meant_is_refused(given: str, settings: Any, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        with_network(settings, "any", given, threads=2)


def test_threads_are_those_of_a_network(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["track", "none.mp4", "--init", "1,1,9,9", "--threads", "2"]
    assert main(words) != 0
    assert "A network needs its ONNX files" in capsys.readouterr().err
    assert main([*words, "--preset", "nummiaro"]) != 0
    assert "Preset nummiaro takes no network; omit --threads" in capsys.readouterr().err
    words = ["track", "--dump-config", *words[2:], "--network", ",".join(save_pair(tmp_path))]
    assert main(words) == 0
    assert "threads = 2" in capsys.readouterr().out


def test_a_preset_without_a_network_refuses_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "rows.csv"
    words = ["track", "none.mp4", "--preset", "nummiaro", "--network", "a.onnx", "-o", str(out)]
    assert main(words) != 0
    assert "Preset nummiaro takes no network" in capsys.readouterr().err
    assert not out.exists()


def test_files_are_opened_before_the_film(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    config = SimpleNamespace(network=Network(("none.onnx",)))
    monkeypatch.setattr("motes.cli.track.tracker_config", lambda *_: config)
    out = tmp_path / "rows.csv"
    assert main(["track", "none.mp4", "--init", "1,1,9,9", "-o", str(out)]) != 0
    assert "There is no file none.onnx" in capsys.readouterr().err
    assert not out.exists()
