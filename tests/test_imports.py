"""One way through the house: imports point left, and heavy ones come late."""

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
import pytest

import motes
from clips import write_pictures
from oracles import mosaic
from scripts import script, uncounted

ROOT = Path(motes.__file__).parent
REPOSITORY = Path(__file__).parents[1]
PROGRAMS = ("studio", "fleet", "lab")
DOORS = ("core", "video", "cues", "sot", "mot", "rows", "correction", "formats", "cli")
"""Packages whose names programs may import, beside those of `motes`."""


def modules_in(root: Path) -> dict[str, Path]:
    """Return the modules below the folder of a package, by their dotted names."""
    return {
        ".".join((root.name, *path.relative_to(root).with_suffix("").parts)).removesuffix(
            ".__init__"
        ): path
        for path in sorted(root.rglob("*.py"))
        if path != root / "__init__.py"
    }


MODULES = modules_in(ROOT)


def imported(path: Path) -> set[str]:
    """Return the dotted names of all that a file imports, anywhere in it."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} has a relative import"
            assert node.module is not None
            names.update(f"{node.module}.{alias.name}" for alias in node.names)
    return names


def modules(path: Path) -> set[str]:
    """Return the modules of motes that a file of it imports."""
    found = set()
    for name in imported(path):
        parts = name.split(".")
        known = (".".join(parts[:length]) for length in range(len(parts), 1, -1))
        found |= {next((module for module in known if module in MODULES), "motes")}
    return found - {"motes"}


PACKAGES = sorted({module.split(".")[1] for module in MODULES})


def test_no_package_has_a_circle() -> None:
    """Among packages, `lint-imports` knows that there is none."""
    imports = {module: modules(path) - {module} for module, path in MODULES.items()}
    for name in PACKAGES:
        graph = {each: of for each, of in imports.items() if each.split(".")[1] == name}
        order = [*TopologicalSorter(graph).static_order()]  # which raises where there is a circle
        assert set(graph) <= set(order)


def test_every_package_has_its_layer() -> None:
    tools = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["tool"]
    layers = " | ".join(tools["importlinter"]["contracts"][0]["layers"]).split(" | ")
    assert {f"motes.{name}" for name in PACKAGES} == set(layers)


DOOR = {"motes": {*motes.__all__, "__version__"}, "motes.start": {"INTERRUPTED"}}
DOOR |= {f"motes.{name}": {*importlib.import_module(f"motes.{name}").__all__} for name in DOORS}
DOOR |= {
    f"motes.{name}": {*importlib.import_module(f"motes.{name}").__all__}
    for name in ("filtering", "synthetic", "testing")
}


def test_programs_come_through_the_door() -> None:
    """They import public names alone, as a user's package does; their tests too."""
    folders = [*PROGRAMS, "tests/plugins"]
    files = [path for folder in folders for path in (REPOSITORY / folder).rglob("*.py")]
    assert len(files) > 60
    for path in files:
        for name in imported(path):
            home, _, last = name.rpartition(".")
            if name.split(".")[0] == "motes":
                assert last in DOOR.get(home, ()), f"{path} imports {name}"


def test_the_documentation_lists_the_door() -> None:
    doors = script("docs/generate/doors.py")
    assert doors.table() in doors.PAGE.read_text(encoding="utf-8")
    assert {*doors.DOORS, "cues"} == set(DOORS)


def test_kernels_stand_alone() -> None:
    names = set().union(*(imported(path) for path in (ROOT / "kernels").glob("*.py")))
    others = {name for name in names if not f"{name}.".startswith("motes.kernels.")}
    roots = {name.split(".")[0] for name in others}
    assert roots - sys.stdlib_module_names - {"__future__"} == {"numpy"}


def test_all_distributions_have_one_version() -> None:
    whole, *others = (
        tomllib.loads((REPOSITORY / folder / "pyproject.toml").read_text("utf-8"))["project"]
        for folder in (".", *PROGRAMS)
    )
    assert whole["version"] == motes.__version__
    for program, other in zip(PROGRAMS, others, strict=True):
        assert other["version"] == motes.__version__
        assert f"motes=={motes.__version__}" in other["dependencies"]
        assert whole["optional-dependencies"][program][0].endswith(f"=={motes.__version__}")
    needed = " ".join(whole["dependencies"])
    others_need = ("matplotlib", "opencv", "starlette", "ray", "paho", "motes-")
    assert not [name for name in others_need if name in needed]


def modules_after(code: str) -> set[str]:
    """Return the modules that a fresh interpreter has after some code."""
    script = f"{code}\nimport sys\nprint(*sorted(sys.modules))"
    words = [sys.executable, "-c", script]
    done = subprocess.run(words, env=uncounted(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


@pytest.mark.slow
def test_importing_motes_loads_nothing_heavy() -> None:
    heavy = {"numpy", "av", "scipy", "PIL", "matplotlib", "cv2", "dlib", "rich", "cyclopts"}
    assert not modules_after("import motes") & heavy


@pytest.mark.slow
def test_tracking_needs_no_extra() -> None:
    code = """
import numpy as np
from motes import OpenCVTracker
tracker = OpenCVTracker()
image = np.zeros((20, 20, 3), np.uint8)
tracker.init(image, (5, 5, 6, 6))
tracker.update(image)
"""
    extra = {"cv2", "dlib", "matplotlib", "av", "PIL", "rich", "cyclopts", "motes_lab"}
    assert not {name.split(".")[0] for name in modules_after(code)} & extra


@pytest.mark.slow
def test_track_starts_without_what_it_does_not_need(tmp_path: Path) -> None:
    """Its start is half a second, of which each of these would take a share, and memory."""
    film = tmp_path / "film.mp4"
    shifts = range(12)  # a neighbor is looked for in every fourth frame
    write_pictures(film, (np.roll(mosaic(0, 96, 128), shift, axis=1) for shift in shifts))
    words = ["track", str(film), "--init", "40,30,30,24", "-o", str(tmp_path / "rows.csv")]
    loaded = modules_after(f"from motes.cli import main\nassert main({words!r}) == 0")
    needless = {
        "scipy", "cv2", "matplotlib", "dlib", "pandas", "PIL", "rich", "importlib.metadata",
        "http.client", "http.server", "ssl", "email",
        "numpy.ma", "numpy.testing", "multiprocessing", "onnxruntime", "motes.mot.scene",
        "motes.synthetic",
    }  # fmt: skip
    assert loaded & needless == set()
    assert {"numpy.linalg", "motes.sot.discriminative.tracker"} <= loaded


@pytest.mark.slow
def test_help_starts_without_what_tracks() -> None:
    loaded = modules_after("from motes.cli import main\nassert main(['--help']) == 0")
    assert not loaded & {"numpy", "av", "scipy", "PIL", "starlette", "motes_fleet"}
    assert not any(name.startswith(("motes.sot", "motes.mot", "motes.video")) for name in loaded)


def test_the_door_opens() -> None:
    for home, names in DOOR.items():
        module = importlib.import_module(home)
        assert [name for name in names if not hasattr(module, name)] == []


def test_no_name_is_that_of_two_classes() -> None:
    texts = (path.read_text(encoding="utf-8") for path in MODULES.values())
    names = [name for text in texts for name in re.findall(r"^ *class (\w+)[(:]", text, re.M)]
    assert len(names) > 300
    assert sorted(names) == sorted(set(names))
