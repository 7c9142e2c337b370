"""Commands that other packages bring, and what is said where they are not installed."""

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from PIL import Image

from motes.cli import app, main
from motes.core import registry


@pytest.fixture(autouse=True)
def _commands_are_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let each test begin with the commands of motes alone, and end as it began."""
    own = {name: each for name, each in app.app._commands.items() if name not in app.PROGRAMS}
    monkeypatch.setattr(app.app, "_commands", own)


def install(monkeypatch: pytest.MonkeyPatch, **places: str) -> None:
    """Let these commands be all that packages add."""
    points = tuple(EntryPoint(name, place, "motes.commands") for name, place in places.items())
    monkeypatch.setattr(
        registry, "_entry_points", lambda group: points if group == "motes.commands" else ()
    )


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("studio", "motes-studio; install it with: pip install 'motes[studio]'."),
        ("batch films", "motes batch needs motes-fleet; install it with: pip install"),
        ("watch rig.toml", "A file of several cameras needs motes-fleet;"),
        ("watch a.mp4 --events mqtt://a/b", "--events ADDRESS needs motes-fleet;"),
        ("track FILM --init 20,10,20,20 --figures f", "--figures needs motes-lab; install it with"),
        ("wave", 'Unknown command "wave".'),
    ],
)
def test_what_is_missing_is_said(
    line: str,
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    install(monkeypatch)
    Image.new("RGB", (80, 60)).save(tmp_path / "a.png")
    assert main(line.replace("FILM", str(tmp_path)).split()) == 2
    assert said in capsys.readouterr().err


def test_a_command_of_another_package(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install(monkeypatch, wave="motes_fleet.commands.batch:app")
    assert main(["wave", "--help"]) == 0
    assert "retry" in capsys.readouterr().out
    assert main(["--help"]) == 0
    assert "wave" in capsys.readouterr().out


def test_one_that_is_broken_fails_alone(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    install(monkeypatch, wave="motes_nothing:app")
    assert main(["--help"]) == 0
    assert "wave" not in capsys.readouterr().out
    assert main(["wave"]) == 2
    assert "cannot be loaded: ModuleNotFoundError" in capsys.readouterr().err
    assert main(["track", "--help"]) == 0
