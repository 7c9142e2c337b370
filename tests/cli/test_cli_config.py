"""`motes config`: the presets, and their keys with types, values and meanings."""

import re
import tomllib
from collections.abc import Callable

import pytest

from motes.cli import main
from motes.core.config import from_dict
from motes.mot.scene_config import WatchConfig
from motes.sot.presets import DESCRIPTIONS, PRESETS, TrackerConfig, preset

Go = Callable[[str], tuple[int, str, str]]
ENTRY = re.compile(r"^ *([\w.]+) = (.+?)  \[.*\]$", re.M)


@pytest.fixture
def go(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Go:
    """Run a command on a wide terminal; return exit code, standard output, standard error."""
    monkeypatch.setattr("motes.cli.config.MAX_COLUMNS", 10_000)
    monkeypatch.setenv("COLUMNS", "1000")

    def run(line: str) -> tuple[int, str, str]:
        return main(["config", *line.split()]), *capsys.readouterr()

    return run


def test_presets_are_listed_with_their_meanings(go: Go) -> None:
    code, out, _ = go("")
    assert code == 0
    for name, text in DESCRIPTIONS.items():
        assert re.search(rf"^{re.escape(name)} +{re.escape(text)}$", out, re.M)


@pytest.mark.parametrize("name", ["default", "nummiaro", "zhao_pei", "maggio:O-ROH", "mean_shift"])
def test_the_keys_of_a_preset_are_its_configuration(go: Go, name: str) -> None:
    out = go(name)[1]
    used = "\n".join(re.findall(r"^\S.*? = .+?(?=  \[)", out, re.M))
    values = {"type": PRESETS[name].to_dict()["type"], **tomllib.loads(used)}
    assert from_dict(values, TrackerConfig) == PRESETS[name]
    assert f"\n{next(iter(ENTRY.findall(out)))[0]} = " in out


def test_only_a_key_and_those_inside(go: Go) -> None:
    out = go("nummiaro motion")[1]
    assert {path.split(".")[0] for path, _ in ENTRY.findall(out)} == {"motion"}
    assert [path for path, _ in ENTRY.findall(go("nummiaro color.bins")[1])] == ["color.bins"]
    assert [path for path, _ in ENTRY.findall(go("default correlation.learning-rate")[1])]


def test_the_keys_of_watch(go: Go) -> None:
    out = go("--watch")[1]
    used = tomllib.loads("\n".join(re.findall(r"^\S.*? = .+?(?=  \[)", out, re.M)))
    assert from_dict(used, WatchConfig).initiation.min_hits == 3
    assert used["tracker"]["particles"] == preset("nummiaro:adaptive").to_dict()["particles"]
    assert '\ndetector.type = "people": ' in out
    assert "  detector.file (required)  [text]" in out
    assert "tracker.hog" in go("zhao_pei --watch")[1]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("numiaro", "did you mean 'nummiaro'?"),
        ("nummiaro motion.nois", "did you mean motion.noise?"),
        ("nummiaro zzz", "see motes config nummiaro"),
        ("mean_shift --watch", "Objects are followed by particle filters"),
    ],
)
def test_unknown_names(go: Go, line: str, message: str) -> None:
    code, out, error = go(line)
    assert (code, out) == (2, "")
    assert message in error


@pytest.mark.parametrize("columns", [20, 40, 80])
def test_lines_fit_the_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], columns: int
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    for arguments in ([], ["maggio"]):
        assert main(["config", *arguments]) == 0
        assert max(map(len, capsys.readouterr().out.splitlines())) <= columns
