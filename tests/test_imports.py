"""One way through the house: imports point left, and heavy ones come late."""

from __future__ import annotations

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import motes

ROOM = Path(motes.__file__).parent
ORDER = [
    "errors",
    "files",
    "config",
    "interrupts",
    "ahead",
    "geometry",
    "frame",
    "state",
    "track",
    "kernels",
    "sampling",
    "motion",
    "cues",
    "likelihood",
    "resampling",
    "fusion",
    "estimate",
    "presence",
    "adaptation",
    "budget",
    "info",
    "particle_filter",
    "meanshift",
    "search",
    "trust",
    "look",
    "discriminative",
    "presets",
    "target",
    "detection",
    "steady",
    "ghosts",
    "background",
    "lookalike",
    "tracker",
    "trackers",
    "pairs",
    "association",
    "overlaps",
    "assignment",
    "objects",
    "births",
    "mistaken",
    "scene_config",
    "scene",
    "watching",
    "ground",
    "counting",
    "pace",
    "decoder",
    "animation",
    "reconnect",
    "video",
    "live",
    "processes",
    "handover",
    "rig",
    "writer",
    "formats",
    "overlay",
    "journal",
    "annotations",
    "documents",
    "scene_overlay",
    "scenery",
    "synthetic",
    "charts",
    "figures",
    "evaluate",
    "experiments",
    "cli",
]
"""A module, or a package taken as one, may import those before it."""
MODULES = sorted(path for path in ROOM.rglob("*.py") if path != ROOM / "__init__.py")


def place(path: Path) -> str:
    return path.relative_to(ROOM).with_suffix("").parts[0]


def imported(path: Path) -> set[str]:
    """Return the dotted names of all modules that a file imports, anywhere in it."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path.name} has a relative import"
            assert node.module is not None
            if node.module in {"motes", "motes.kernels"}:
                names.update(f"{node.module}.{alias.name}" for alias in node.names)
            else:
                names.add(node.module)
    return names


def rooms(path: Path) -> set[str]:
    """Return which parts of motes a file imports."""
    found = set()
    for name in imported(path):
        parts = name.split(".")
        if parts[0] == "motes" and parts[-1] != "__version__":
            found.add(motes._HOMES.get(parts[1], parts[1]))
    return found


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(ROOM)))
def test_imports_point_left(path: Path) -> None:
    own = place(path)
    assert own in ORDER, f"give {own} its place in the order"
    for other in rooms(path) - {own}:
        assert ORDER.index(other) < ORDER.index(own), f"{own} imports {other}"


def test_the_walk_finds_imports() -> None:
    """The test before this one would also pass if it found nothing."""
    assert rooms(ROOM / "tracker.py") >= {"config", "frame", "meanshift", "presets", "target"}
    assert "kernels" in rooms(ROOM / "cues" / "color.py")


def test_kernels_stand_alone() -> None:
    names = set().union(*(imported(path) for path in (ROOM / "kernels").glob("*.py")))
    others = {name for name in names if not f"{name}.".startswith("motes.kernels.")}
    roots = {name.split(".")[0] for name in others}
    assert roots - sys.stdlib_module_names - {"__future__"} == {"numpy", "numba"}


def test_kernels_point_one_way_among_themselves() -> None:
    files = [path for path in (ROOM / "kernels").glob("*.py") if path.stem != "__init__"]
    graph = {f"motes.kernels.{path.stem}": imported(path) for path in files}
    order = [*TopologicalSorter(graph).static_order()]  # which raises where there is a circle
    assert order.index("motes.kernels.compiling") < order.index("motes.kernels.color")


def test_kernels_are_the_only_ones_compiled() -> None:
    for path in MODULES:
        if place(path) != "kernels" and path.name != "doctor.py":
            assert "numba" not in {name.split(".")[0] for name in imported(path)}, path


def test_public_names() -> None:
    order = sorted(motes.__all__, key=lambda n: (not n.isupper(), not n[0].isupper(), n))
    assert order == motes.__all__
    assert set(motes.__all__) == set(motes._HOMES)
    assert len(set(motes.__all__)) == len(motes.__all__)
    for name in motes.__all__:
        value = getattr(motes, name)
        assert value is getattr(sys.modules[f"motes.{motes._HOMES[name]}"], name)
    assert set(motes.__all__) < set(dir(motes))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        motes.nothing  # noqa: B018


def test_type_checkers_see_the_same_names() -> None:
    tree = ast.parse((ROOM / "__init__.py").read_text(encoding="utf-8"))
    seen = {
        alias.name: node.module
        for block in tree.body
        if isinstance(block, ast.If)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    assert seen == {name: f"motes.{home}" for name, home in motes._HOMES.items()}


def loaded_after(code: str) -> set[str]:
    """Return the top-level modules that a fresh interpreter has after some code."""
    script = f"{code}\nimport sys\nprint(*sorted(sys.modules))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {name.split(".")[0] for name in done.stdout.split()}


def test_importing_motes_loads_nothing_heavy() -> None:
    heavy = {
        "numpy",
        "numba",
        "av",
        "scipy",
        "PIL",
        "matplotlib",
        "cv2",
        "dlib",
        "rich",
        "cyclopts",
    }
    assert not loaded_after("import motes") & heavy


def test_tracking_needs_no_extra() -> None:
    code = """
import numpy as np
from motes import OpenCVTracker
tracker = OpenCVTracker()
image = np.zeros((20, 20, 3), np.uint8)
tracker.init(image, (5, 5, 6, 6))
tracker.update(image)
"""
    extra = {"cv2", "dlib", "matplotlib", "av", "scipy", "PIL", "rich", "cyclopts"}
    of_numba = loaded_after("import numba")  # which asks scipy for its version, if that is there
    assert not (loaded_after(code) - of_numba) & extra
