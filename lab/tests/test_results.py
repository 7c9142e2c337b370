"""The measured tables of the documentation: their commands exist, and write tables of this form."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from motes_lab.cli import experiment
from motes_lab.cli.app import app
from motes_lab.cli.bench import bench
from motes_lab.cli.evaluate import evaluate
from scripts import ROOT, script

PAGES = sorted([*(ROOT / "docs").glob("*.md"), *(ROOT / "lab/docs").glob("*.md")])


results = script("docs/generate/results.py")
BLOCKS = results.blocks(PAGES)


def test_every_command_is_one_of_the_lab_or_a_script(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    known = {experiment.app[name].default_command for name in experiment.app if name[0] != "-"}
    for command in itertools.chain.from_iterable(block.commands for block in BLOCKS):
        if command.removeprefix(results.TESTS).startswith(results.SCRIPT):
            script, *given = results.arguments(command)
            if script == "-m":
                module = ROOT / "tests" / given[0].replace(".", "/")
                assert (module / "__main__.py").exists() or module.with_suffix(".py").exists()
            else:
                assert (ROOT / script).parent == ROOT / "benchmarks", command
                assert (ROOT / script).exists(), command
            continue
        assert command.startswith("motes-lab "), command
        arguments = [*results.arguments(command), "--out", "out"]
        called, _, _ = app.parse_args(arguments, exit_on_error=False, print_error=False)
        assert called in known | {evaluate, bench}, command
        for each in command.split():
            if each.endswith(".toml"):
                assert Path(each).exists(), command
