"""The public names: documented, importable, and their examples run."""

import doctest
import importlib
import inspect
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motes
from clips import write_film
from motes import synthetic

API = (Path(__file__).parent.parent / "docs" / "api.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```python\n(.*?)^```$", API, re.DOTALL | re.MULTILINE)
PUBLIC = ("cues", "filtering", "synthetic", "testing")
MODULES = {
    name: importlib.import_module(name)
    for name in ("motes", *(f"motes.{module}" for module in PUBLIC))
}
NAMES = [
    (module, name)
    for module, each in MODULES.items()
    for name in each.__all__
    if not inspect.ismodule(getattr(each, name))
]
VALUES = ("PRESETS", "TrackerConfig")
"""Names of no class or function, which have no docstring of their own."""


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the videos of the examples."""
    folder = tmp_path_factory.mktemp("api")
    states = {
        "video.mp4": ((640, 480), [[320 + i, 230, 20, 30, 0] for i in range(4)]),
        "street.mp4": ((320, 240), [[8 * i - 30, 120, 24, 17, 0] for i in range(45)]),
    }
    for name, (size, rows) in states.items():
        target = synthetic.Target(np.array(rows, np.float64))
        write_film(folder / name, synthetic.Clip(size, (target,)))
    return folder


def test_a_name_is_there_and_says_what_it_is() -> None:
    for module, name in NAMES:
        value = getattr(MODULES[module], name)
        if name not in VALUES:
            assert inspect.isclass(value) or inspect.isfunction(inspect.unwrap(value)), name
            own = value.__doc__ or ""
            assert re.match(r".{15,}[.:]\n|.{15,}\.$", own), name
            assert not re.match(r"\w+\(.*\)$", own), f"{name}: made by dataclass or NamedTuple"


@pytest.mark.parametrize("module", MODULES)
def test_the_documentation_has_all_names(module: str) -> None:
    """The names of `motes` come first, then a section for each of the other modules."""
    main, *others = re.split(r"^## motes\.", API, flags=re.MULTILINE)
    text = next((part for part in others if f"motes.{part}".startswith(f"{module}\n")), main)
    cells = re.findall(r"^\| (`.*?`) \|", text, re.MULTILINE)
    listed = {name for cell in cells for name in re.findall(r"`(\w+)`", cell)} - {"motes"}
    assert listed == {name for owner, name in NAMES if owner == module}
    assert module == "motes" or f"| `{module}` |" in main


PRINTED = (
    r"Track\(frame=0, .*\n\(300\.0, 200\.0, 340\.0, 260\.0\)\n\{\"frame\": 0, ",
    r"Track\(frame=4, .*status=tracking, .* particles \{'color': ",
    r"(\d \d+\.\d+ \('.*\)\n){0,3}$",
    r"32\d\.\d+\n +frame ",
    r"appears None 1\n(.*\n)*crosses middle 1\n",
    r"(Frame\(.*\n){10}$",
)
"""What the examples of the documentation print."""


@pytest.mark.slow
@pytest.mark.parametrize(("block", "printed"), [*zip(BLOCKS, PRINTED, strict=True)], ids=range(6))
def test_an_example_of_the_documentation_runs(
    films: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    block: str,
    printed: str,
) -> None:
    monkeypatch.chdir(films)
    exec(block, {})
    assert re.match(printed, capsys.readouterr().out)


@pytest.mark.parametrize("module", ["motes.cues", "motes.filtering", "motes.synthetic"])
def test_the_example_of_a_module_runs(module: str) -> None:
    result = doctest.testmod(MODULES[module], extraglobs={"motes": motes})
    assert result.attempted >= 2
    assert not result.failed


def test_modules_are_loaded_on_first_use() -> None:
    names: Any = motes
    for module in PUBLIC:
        assert getattr(names, module) is MODULES[f"motes.{module}"]
        assert module in dir(motes)
