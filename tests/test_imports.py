"""One way through the house: imports point left, and heavy ones come late."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import motes
import motes_lab
from motes.video.writer import VideoWriter
from oracles import mosaic

ROOT = Path(motes.__file__).parent
LAB = Path(motes_lab.__file__).parent
ORDER = [
    {"core", "kernels"},
    {"video"},
    {"cues"},
    {"sot"},
    {"mot", "testing"},
    {"synthetic"},
    {"rows"},
    {"output"},
    {"correction"},
    {"formats"},
    {"cluster"},
    {"services"},
    {"studio"},
    {"cli"},
    {"start"},
    {"filtering", "__main__"},
]
"""The packages, and last the program and the modules of public names.

A package may import from the groups before its own; core and kernels do not know each other."""


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


def module_of(name: str) -> str | None:
    """Return the module of motes that holds a dotted name; None for what is of others."""
    parts = name.split(".")
    if parts[0] != "motes" or name == "motes.__version__":
        return None
    if len(parts) == 2 and parts[1] in motes._HOMES:
        return f"motes.{motes._HOMES[parts[1]]}"
    known = (".".join(parts[:length]) for length in range(len(parts), 1, -1))
    return next(module for module in known if module in MODULES)


def modules(path: Path) -> set[str]:
    """Return the modules of motes that a file imports."""
    return {module for name in imported(path) if (module := module_of(name))}


def package(module: str) -> str:
    return module.split(".")[1]


def rank(module: str) -> int:
    return next(i for i, group in enumerate(ORDER) if package(module) in group)


@pytest.mark.parametrize("module", MODULES)
def test_imports_point_left(module: str) -> None:
    for other in modules(MODULES[module]):
        if package(other) != package(module):
            assert rank(other) < rank(module), f"{module} imports {other}"


@pytest.mark.parametrize("name", sorted(set().union(*ORDER)))
def test_a_package_has_no_circle(name: str) -> None:
    graph = {
        module: modules(path) - {module}
        for module, path in MODULES.items()
        if package(module) == name
    }
    order = [*TopologicalSorter(graph).static_order()]  # which raises where there is a circle
    assert set(graph) <= set(order)


def test_all_packages_have_their_place() -> None:
    assert {package(module) for module in MODULES} == set().union(*ORDER)


def test_the_library_never_imports_the_lab() -> None:
    for path in (*MODULES.values(), ROOT / "__init__.py"):
        roots = {name.split(".")[0] for name in imported(path)}
        assert "motes_lab" not in roots, path


def test_the_lab_has_no_circle() -> None:
    """Its imports are of itself, of motes, and of what the two distributions depend on."""
    own = modules_in(LAB)

    def module_in_lab(name: str) -> str | None:
        parts = name.split(".")
        known = (".".join(parts[:length]) for length in range(len(parts), 1, -1))
        return next((module for module in known if module in own), None)

    graph = {
        module: {other for name in imported(path) if (other := module_in_lab(name))} - {module}
        for module, path in own.items()
    }
    assert graph["motes_lab.cli.evaluate"] >= {"motes_lab.runner", "motes_lab.datasets.sot"}
    assert set(graph) <= set(TopologicalSorter(graph).static_order())
    for path in own.values():
        for name in imported(path):
            assert module_of(name) is None or module_of(name) in MODULES


def test_all_packages_have_a_place_in_the_order() -> None:
    assert {package(module) for module in MODULES} - {"__main__", ""} <= set().union(*ORDER)


def test_the_walk_finds_imports() -> None:
    """The tests before this one would also pass if it found nothing."""
    found = modules(MODULES["motes.sot.tracker"])
    assert found >= {"motes.core.config", "motes.core.frame", "motes.sot.presets"}
    assert "motes.kernels" in {module[:13] for module in modules(MODULES["motes.cues.color"])}


def test_kernels_stand_alone() -> None:
    names = set().union(*(imported(path) for path in (ROOT / "kernels").glob("*.py")))
    others = {name for name in names if not f"{name}.".startswith("motes.kernels.")}
    roots = {name.split(".")[0] for name in others}
    assert roots - sys.stdlib_module_names - {"__future__"} == {"numpy"}


def test_both_distributions_have_one_version() -> None:
    whole, lab = (
        tomllib.loads((ROOT.parents[1] / path).read_text(encoding="utf-8"))["project"]
        for path in ("pyproject.toml", "lab/pyproject.toml")
    )
    assert whole["version"] == lab["version"] == motes.__version__
    assert f"motes=={motes.__version__}" in lab["dependencies"]
    assert whole["optional-dependencies"]["lab"][0].endswith(f"=={motes.__version__}")
    needed = " ".join(whole["dependencies"])
    assert not [name for name in ("matplotlib", "opencv", "trackers", "lab") if name in needed]


def test_public_names() -> None:
    assert sorted(motes.__all__) == motes.__all__
    assert set(motes.__all__) == set(motes._HOMES)
    assert len(set(motes.__all__)) == len(motes.__all__)
    for name in motes.__all__:
        value = getattr(motes, name)
        assert value is getattr(sys.modules[f"motes.{motes._HOMES[name]}"], name)
    assert set(motes.__all__) < set(dir(motes))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        motes.nothing  # noqa: B018


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse((ROOT / "__init__.py").read_text(encoding="utf-8"))
    seen = {
        alias.asname: node.module  # `name as name`, which exports it
        for block in tree.body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
        if alias.asname == alias.name
    }
    homes = {name: f"motes.{home}" for name, home in motes._HOMES.items()}
    assert seen == homes | dict.fromkeys(motes._MODULES, "motes")


def modules_after(code: str) -> set[str]:
    """Return the modules that a fresh interpreter has after some code."""
    script = f"{code}\nimport sys\nprint(*sorted(sys.modules))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


def loaded_after(code: str) -> set[str]:
    """Return the top-level modules that a fresh interpreter has after some code."""
    return {name.split(".")[0] for name in modules_after(code)}


def test_importing_motes_loads_nothing_heavy() -> None:
    heavy = {"numpy", "av", "scipy", "PIL", "matplotlib", "cv2", "dlib", "rich", "cyclopts"}
    assert not loaded_after("import motes") & heavy


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
    assert not loaded_after(code) & extra


def test_a_run_loads_only_what_it_needs(tmp_path: Path) -> None:
    """Each of these takes a tenth of a second or more, and memory."""
    for name in ("a.png", "b.png"):
        Image.fromarray(mosaic(0, 40, 60)).save(tmp_path / name)
    code = """
import sys
from motes.cli import main
assert main(["track", {!r}, "--init", "20,10,16,12", "--preset", "nummiaro", "-o", {!r}]) == 0
""".format(str(tmp_path), str(tmp_path / "rows.csv"))
    loaded = loaded_after(code)
    assert not loaded & {"numba", "scipy", "cv2", "matplotlib", "dlib", "pandas"}
    assert "numpy" in loaded


def test_track_starts_without_what_it_does_not_need(tmp_path: Path) -> None:
    """Its start is half a second, of which each of these would take a share, and memory."""
    film = tmp_path / "film.mp4"
    with VideoWriter(film, 25) as writer:
        for shift in range(4):
            writer.write(np.roll(mosaic(0, 96, 128), shift, axis=1))
    words = ["track", str(film), "--init", "40,30,30,24", "-o", str(tmp_path / "rows.csv")]
    loaded = modules_after(f"from motes.cli import main\nassert main({words!r}) == 0")
    needless = {
        "scipy", "PIL", "rich", "http.client", "http.server", "ssl", "email", "importlib.metadata",
        "numpy.ma", "numpy.testing", "onnxruntime", "motes.mot.scene",
        "motes.output.live_picture", "motes.synthetic",
    }  # fmt: skip
    assert loaded & needless == set()
    assert {"numpy.linalg", "motes.sot.discriminative.tracker"} <= loaded


def test_help_starts_without_what_tracks() -> None:
    loaded = modules_after("from motes.cli import main\nassert main(['--help']) == 0")
    assert not loaded & {"numpy", "av", "scipy", "PIL", "email", "importlib.metadata"}
    assert not any(name.startswith(("motes.sot", "motes.mot", "motes.video")) for name in loaded)


def test_no_name_is_that_of_two_classes() -> None:
    names = [
        node.name
        for path in MODULES.values()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef)
    ]
    assert sorted(names) == sorted(set(names))
