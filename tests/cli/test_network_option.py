"""The option --network of `motes track`."""

from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest

from motes import Config, ConfigError
from motes.cli import main
from motes.cli.load_config import with_network
from motes.sot import Network, presets
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


def pair_with(folder: Path, kind: str) -> str:
    """Return the word for --network, of files that are no pair, or of one without numbers."""
    folder.mkdir()
    backbone, head = save_pair(folder)
    if kind == "not finite":
        model = onnx.load(backbone)
        [weights] = [each for each in model.graph.initializer if len(each.dims) == 4]
        values = np.full(tuple(weights.dims), np.nan, np.float32)
        weights.CopyFrom(onnx.numpy_helper.from_array(values, weights.name))
        Path(backbone).write_bytes(model.SerializeToString())
    return f"{backbone},{head if kind == 'not finite' else backbone}"


@pytest.mark.parametrize(
    ("kind", "code", "words"),
    [
        ("backbones", 2, "no known kind of network. Known are siamese: "),
        ("not finite", 3, "gives no box with a score; its weights are damaged."),
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
