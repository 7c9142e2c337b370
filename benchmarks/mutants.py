"""How many small faults the tests of a room notice.

    python benchmarks/mutants.py src/motes/formats --tests "-m '' tests/formats" [--sample 25]

A mutant is one module with one operator, constant, comparison or branch changed. Each is written
into a copy of the sources, on which the tests run until one fails; the modules themselves stay as
they are, whatever ends this program. What no test notices is printed, with its number: `--only
3,17` runs these again, with other tests.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PAIRS = [
    (ast.Lt, ast.LtE), (ast.Gt, ast.GtE), (ast.Eq, ast.NotEq), (ast.Is, ast.IsNot),
    (ast.In, ast.NotIn), (ast.Add, ast.Sub), (ast.Mult, ast.Div), (ast.And, ast.Or),
    (ast.BitAnd, ast.BitOr),
]  # fmt: skip
OTHER: dict[type[ast.AST], type[ast.AST]] = {
    **dict(PAIRS),
    **{other: one for one, other in PAIRS},
    **dict.fromkeys((ast.FloorDiv, ast.Mod, ast.Pow), ast.Mult),
}
PATIENCE = 60.0
"""Seconds beside ten times those of the sound tests; a mutant that takes longer is noticed."""


class Mutant(NamedTuple):
    """A module with one change: where, what was there, what is there, and the text of all."""

    path: Path
    line: int
    before: str
    after: str
    text: str


def change(node: ast.AST) -> bool:
    """Change a node in place; return False where there is nothing to change."""
    match node:
        case ast.Compare() if type(node.ops[0]) in OTHER:
            node.ops[0] = OTHER[type(node.ops[0])]()  # type: ignore[call-overload]
        case ast.BinOp() | ast.BoolOp() if type(node.op) in OTHER:
            node.op = OTHER[type(node.op)]()  # type: ignore[assignment]
        case ast.Constant(value=bool()):
            node.value = not node.value
        case ast.Constant(value=int() | float()):
            node.value += 1  # type: ignore[operator]
        case ast.If() | ast.While() | ast.IfExp():
            node.test = ast.UnaryOp(ast.Not(), node.test)
        case _:
            return False
    return True


def computed(tree: ast.AST) -> Iterator[ast.AST]:
    """Return the nodes of a tree that are computed: no annotations, no imports for them."""
    for name, value in ast.iter_fields(tree):
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or name in ("annotation", "returns"):
                continue
            if isinstance(child, ast.If) and ast.unparse(child.test) == "TYPE_CHECKING":
                continue
            yield child
            yield from computed(child)


def shown(node: ast.AST) -> str:
    """Return the text of a node; of a statement, its condition."""
    return ast.unparse(node.test if isinstance(node, ast.If | ast.While) else node)


def places(path: Path) -> Iterator[tuple[Path, int]]:
    """Return the places in a module that can be changed: numbers of its computed nodes."""
    nodes = [*computed(ast.parse(path.read_text(encoding="utf-8")))]
    return ((path, place) for place, node in enumerate(nodes) if change(node))


def mutant(path: Path, place: int) -> Mutant:
    """Return the module with the change at a place."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    node = [*computed(tree)][place]
    before = shown(node)
    change(node)
    text = ast.unparse(ast.fix_missing_locations(tree))
    return Mutant(path, getattr(node, "lineno", 0), before, shown(node), text)


def noticed(tests: list[str], sources: Path, patience: float | None) -> bool:
    """Run tests on sources until one fails; return whether one did, or had no end."""
    folders = [str(sources), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, folders))}
    command = [sys.executable, "-m", "pytest", "-x", "-p", "no:cacheprovider", *tests]
    with subprocess.Popen(
        command, cwd=ROOT, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as running:
        try:
            return running.wait(patience) != 0
        except subprocess.TimeoutExpired:
            running.kill()
            return True


def main(words: list[str] | None = None) -> int:
    """Count the survivors of a sample, and print them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("room", type=Path, nargs="+", help="modules or folders of them")
    parser.add_argument("--tests", required=True, type=shlex.split, help="words for pytest")
    parser.add_argument("--sample", type=int, default=25, help="number of mutants")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", help="numbers of mutants in the sample, with commas")
    given = parser.parse_args(words)
    rooms = [room.resolve() for room in given.room]
    paths = [path for room in rooms for path in (sorted(room.rglob("*.py")) or [room])]
    every = [place for path in paths for place in places(path)]
    chosen = random.Random(given.seed).sample(every, min(given.sample, len(every)))
    sample = [mutant(*place) for place in chosen]
    numbers = range(len(sample)) if given.only is None else [*map(int, given.only.split(","))]
    source = next(parent for parent in paths[0].parents if parent.name == "src")
    survivors = 0
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(shutil.copytree(source, Path(folder) / "src"))
        start = time.monotonic()
        if noticed(given.tests, copy, None):
            sys.exit("a test fails without any change")
        patience = PATIENCE + 10 * (time.monotonic() - start)
        for number in numbers:
            one = sample[number]
            place = copy / one.path.relative_to(source)
            sound = place.read_text(encoding="utf-8")
            place.write_text(one.text, encoding="utf-8")
            if not noticed(given.tests, copy, patience):
                survivors += 1
                where = f"{one.path.relative_to(source)}:{one.line}"
                print(f"{number}: {where}: {one.before} -> {one.after}", flush=True)
            place.write_text(sound, encoding="utf-8")
    print(f"{len(numbers) - survivors} of {len(numbers)} mutants (of {len(every)}) were noticed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
