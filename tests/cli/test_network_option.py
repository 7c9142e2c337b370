"""The option --network of `motes track`."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import onnx
import pytest

from motes.cli import main
from motes.cli.load_config import with_network
from motes.core.config import Config
from motes.core.errors import ConfigError
from motes.core.onnx_session import LARGEST
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
    odd = tmp_path / "a,b.onnx"
    odd.touch()
    assert with_network({}, "any", str(odd)) == {"network": {"files": [str(odd)]}}


@pytest.mark.usefixtures("_a_preset_with_a_network")
@pytest.mark.parametrize(
    ("given", "settings", "words"),
    [
        ("a.onnx,", {}, "give files, with commas between them"),
        ("a.onnx", {"network": {"files": ["b"]}}, "--network and --set network.files contradict"),
    ],
)
def test_what_cannot_be_meant_is_refused(given: str, settings: Any, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        with_network(settings, "any", given)


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


def pair_with(folder: Path, kind: str) -> str:
    """Return the word for --network, of a pair that is damaged in some way."""
    folder.mkdir()
    backbone, head = save_pair(folder)
    bad = folder / "bad.onnx"
    if kind in ("one", "backbones"):
        return head if kind == "one" else f"{backbone},{backbone}"
    if kind == "folder":
        bad.mkdir()
    elif kind == "pipe":
        os.mkfifo(bad)
    elif kind in ("huge", "zeros"):
        with bad.open("wb") as file:
            file.truncate(LARGEST + (kind == "huge"))  # it takes no room on the disk
    elif kind in ("cut", "empty", "text"):
        good = Path(backbone).read_bytes()
        bad.write_bytes({"cut": good[:-10], "empty": b"", "text": b"no network"}[kind])
    else:
        bad.write_bytes(other_model(onnx.load(backbone), kind).SerializeToString())
    return f"{bad},{head}"


def other_model(model: Any, kind: str) -> Any:
    """Return a backbone that is damaged, or another network."""
    [weights] = [each for each in model.graph.initializer if len(each.dims) == 4]
    if kind == "not finite":
        values = np.full(tuple(weights.dims), np.nan, np.float32)
        weights.CopyFrom(onnx.numpy_helper.from_array(values, weights.name))
    elif kind == "outside":
        onnx.external_data_helper.set_external_data(weights, "weights.bin")
        weights.ClearField("raw_data")
    elif kind == "form":
        model.ir_version = 99
    else:
        model.opset_import[0].version = int(kind.removeprefix("opset "))
    return model


@pytest.mark.parametrize(
    ("kind", "code", "words"),
    [
        ("one", 2, "head.onnx (takes input1 float32 1x3x8x8, "),
        ("backbones", 2, "no known kind of network. Known are siamese: "),
        ("folder", 3, "There is no file "),
        pytest.param(
            "pipe",
            3,
            "There is no file ",
            marks=pytest.mark.skipif(os.name == "nt", reason="no pipes"),
        ),
        ("huge", 3, "bad.onnx has 1.0 GB; motes runs networks of up to 1 GB."),
        ("cut", 3, "bad.onnx is cut off or no ONNX file; copy or export it again."),
        ("empty", 3, "bad.onnx is empty; copy or export it again."),
        ("outside", 3, "has its weights in weights.bin, which is not there; copy it beside"),
        ("not finite", 3, "gives no box with a score; its weights are damaged."),
        ("form", 3, "cannot be read as ONNX: Unsupported model IR version: 99, max"),
        ("opset 99", 3, "bad.onnx cannot be read as ONNX: ONNX Runtime only *guarantees*"),
    ],
)
def test_bad_files_end_in_one_line_and_leave_nothing(
    kind: str, code: int, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given, out = pair_with(tmp_path / "given", kind), tmp_path / "out"
    out.mkdir()
    line = ["track", "none.mp4", "--init", "1,1,9,9", "--network", given, "-o", str(out / "a.csv")]
    assert main(line) == code
    said = capsys.readouterr()
    assert words in said.err
    assert not said.out
    assert said.err.count("\n") == 1
    assert not list(out.iterdir())
