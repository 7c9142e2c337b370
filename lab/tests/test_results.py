"""The measured tables of the documentation: their commands exist, and write tables of this form."""

from __future__ import annotations

import itertools
import json
import os
import re
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import IO

import pytest

from motes_lab.cli import experiment
from motes_lab.cli.app import app
from motes_lab.cli.bench import bench
from motes_lab.cli.evaluate import evaluate
from scripts import ROOT, script

PAGES = sorted([*(ROOT / "docs").glob("*.md"), *(ROOT / "lab/docs").glob("*.md")])


results = script("docs/generate/results.py")
BLOCKS = results.blocks(PAGES)
BY_NAME = {block.name: block for block in BLOCKS}
PAGE = """Before.

<!-- results one | 2 min | All -->

    motes-lab experiment ng-delp-figure3 \\
        --seeds 1
    motes-lab evaluate MOT/a --tracker x

| old |
| --- |
| 3 |

Measured on 2026-01-31.

<!-- end one -->

<!-- results other | 1 min | All -->

    motes-lab experiment ng-delp-figure3

<!-- end other -->

After.
"""
WRITTEN = """# Run

### All films

| a | b |
| --- | --- |
| {} | 1 |

A note.

### Other

| c |
| - |
"""


def test_names_are_there_once() -> None:
    assert len(BY_NAME) == len(BLOCKS) > 20
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        here = [block.name for block in BLOCKS if block.page == page]
        assert re.findall(r"<!-- results ([\w-]+)", text) == here


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


def test_every_table_has_rows_and_a_date() -> None:
    for block in BLOCKS:
        lines = [line for line in block.tables.splitlines() if line]
        table = [line for line in lines if line.startswith("|")]
        assert len(table) > 2, block.name
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in table}) == 1, block.name
        assert re.fullmatch(r"Measured on \d{4}-\d\d-\d\d\.", lines[-1]), block.name


COMMAND = re.compile(
    r"motes-lab (?P<lab>[a-z]+)(?: (?P<name>[a-z][a-z0-9-]*))?|benchmarks/(?P<script>\w+\.py)"
    r"|make (?P<target>bench|fuzz|kills)|python -m fuzzing|\b(?:motes track|TRACK)\b"
)
DATE = re.compile(r"\b20\d\d-\d\d-\d\d\b")


def sections(text: str) -> dict[str, str]:
    """Return each heading with the text up to the next one, by its anchor."""
    parts = re.split(r"^#+ (?=.)", text, flags=re.MULTILINE)[1:]
    heads = (re.sub(r"[^\w -]", "", part.partition("\n")[0]) for part in parts)
    return {head.lower().replace(" ", "-"): part for head, part in zip(heads, parts, strict=True)}


SITE = sorted(
    [ROOT / "README.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "lab").glob("docs/**/*.md")]
)
FIGURE = re.compile(r"^[*+-]*\d|\d\.\d|±|\d ?(?:%|ms|µs|s|MB|MiB)\b")
"""A cell that may be measured: it begins with a number, has a decimal one, or one with a unit."""
UNMEASURED = {
    "figure, table or claim": "its numbers are those of other tables; tests compare them",
    "what happens": "exit codes",
    "limit": "limits of the studio",
    "network | files": "files of others",
    "column |": "what a column means",
}
"""How heads of tables begin whose figures nobody has measured."""


def measured_tables(text: str) -> list[str]:
    """Return the tables of a text in which a third of the cells or more may be measured.

    The first column names the rows, and empty cells do not count.
    """
    found = []
    for table in re.findall(r"(?:^ *\|.*\n)+", text, re.MULTILINE):
        rows = [row.strip().strip("|").split("|")[1:] for row in table.splitlines()[2:]]
        cells = [cell.strip() for row in rows for cell in row if cell.strip()]
        if cells and 3 * sum(bool(FIGURE.search(cell)) for cell in cells) >= len(cells):
            found.append(table)
    return found


def made_by_hand(text: str) -> list[str]:
    """Return the measured tables of a page that `make results` does not make."""
    heads = tuple(f"| {head}" for head in UNMEASURED)
    tables = measured_tables(results.BLOCK.sub("", text))
    return [table for table in tables if not table.startswith(heads)]


@pytest.mark.parametrize("page", SITE, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_measured_table_is_made_by_a_command(page: Path) -> None:
    assert not made_by_hand(page.read_text(encoding="utf-8"))


def test_a_measured_table_outside_of_a_block_is_found() -> None:
    table = "| tracker | ms | AUC |\n|---|---|---|\n| default | 4.8 (of 3 runs) | {} |\n"
    assert made_by_hand(f"Measured by hand:\n\n{table.format('0.7 ± 0.1')}")
    assert made_by_hand(f"- In a list:\n\n  {table.format('much')}")
    assert not made_by_hand("| name | what it is |\n|---|---|\n| `Frame` | a picture |\n")
    assert not made_by_hand(PAGE)


def test_tables_that_are_not_measured_are_there() -> None:
    tables = "".join("".join(measured_tables(page.read_text("utf-8"))) for page in SITE)
    for head in UNMEASURED:
        assert f"| {head}" in tables, head


def test_all_tables_are_made_in_one_night() -> None:
    """A command of several tables runs once."""
    assert sum({block.commands: block.minutes for block in BLOCKS}.values()) <= 600


def test_every_command_on_the_lab_s_pages_exists() -> None:
    experiments = {name for name in experiment.app if name[0] != "-"}
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for page in (ROOT / "lab/docs").glob("*.md"):
        for found in COMMAND.finditer(page.read_text(encoding="utf-8")):
            if found["script"]:
                assert (ROOT / "benchmarks" / found["script"]).exists(), found[0]
            elif found["target"]:
                assert f"\n{found['target']}:" in makefile, found[0]
            elif found["lab"]:
                assert found["lab"] in app, found[0]
                if found["lab"] == "experiment" and found["name"]:
                    assert found["name"] in experiments, found[0]


PICTURES = {"picture", "pictures", "drawing", "listing"}


def test_every_verdict_has_a_command_a_number_and_a_date() -> None:
    """Of papers.md; a claim that is a picture needs no number."""
    page = ROOT / "lab/docs/papers.md"
    text = page.read_text(encoding="utf-8")
    tables = re.findall(r"^\| figure, table or claim.*\n\|-.*\n((?:\|.*\n)+)", text, re.MULTILINE)
    rows = [
        [cell.strip() for cell in row.strip("|").split("|")]
        for table in tables
        for row in table.splitlines()
    ]
    assert len(rows) > 50
    for row in rows:
        _, command, paper, ours, verdict = row
        assert verdict, row
        assert not re.search("not measured|earlier version", ours + verdict), row
        if verdict.startswith("the films are not available") or paper in PICTURES:
            continue
        assert command, row
        assert re.search(r"\d", ours + verdict), row
        linked = [
            sections((page.parent / (name or page.name)).read_text(encoding="utf-8"))[anchor]
            for name, anchor in re.findall(r"\]\(([\w./-]*)#([\w-]+)\)", ours + verdict)
        ]
        assert any(DATE.search(each) for each in [*row, *linked]), row


def test_files_in_the_names_of_trackers_have_their_names_on_a_page() -> None:
    tracker = "cv2:nano=BACKBONE,HEAD"
    _, folder, _, given = results.arguments(f"motes-lab evaluate FILMS --tracker {tracker}")
    assert folder == str(results.DATA / "film")
    assert (
        given == f"cv2:nano={results.DATA}/network/backbone.onnx,{results.DATA}/network/head.onnx"
    )
    table = results.Written("All", "| a |", (f"| {given} |",), f"Against {given} alone.")
    assert results.as_text([table], "2026-11-23") == (
        f"| a |\n| {tracker} |\n\nAgainst {tracker} alone.\n\nMeasured on 2026-11-23.\n\n"
    )


@pytest.mark.slow
def test_a_page_has_the_form_that_the_command_writes(data: Path, tmp_path: Path) -> None:
    shortest = min(BLOCKS, key=lambda block: block.minutes)
    assert shortest.minutes <= 0.1
    (found,), date = results.measure(shortest, tmp_path)
    (there,) = results.written(f"### {shortest.title}\n\n{shortest.tables}")
    assert there.head == found.head
    names = [[row.split("|")[1] for row in each.rows] for each in (there, found)]
    assert names[0] == names[1]
    assert there.note.startswith(found.note)
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", date)


def test_numbers_of_claims_are_those_of_the_tables() -> None:
    """The table of claims of papers.md repeats numbers; each is in a measured table or its text."""
    claims, others = list[str](), list[str]()
    for page in PAGES:
        inside = False
        for line in page.read_text(encoding="utf-8").splitlines():
            inside = line.startswith("|") and (
                inside or line.startswith("| figure, table or claim")
            )
            (claims if inside else others).append(line)
    assert len(claims) > 50
    everywhere = "\n".join(others)
    for line in claims:
        for number in re.findall(r"[\d.]+[%°]? ± [\d.]*\d[%°]?|\d\.\d{3,}", line):
            assert number in everywhere, (number, line)


@pytest.fixture
def docs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a page of its own, and have commands write a table instead of running."""
    (tmp_path / "page.md").write_text(PAGE)
    monkeypatch.setattr(results, "DOCS", (tmp_path,))
    monkeypatch.setattr(results, "KEPT", tmp_path / "kept")
    monkeypatch.setattr(results, "DATA", Path("films"))
    return tmp_path / "page.md"


Lines = list[list[str]]


@pytest.fixture
def ran(docs: Path, monkeypatch: pytest.MonkeyPatch) -> Lines:
    """Return the arguments of the commands that were run."""
    lines: Lines = []

    def run(line: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        lines.append(line[3:])
        folder = Path(line[line.index("--out") + 1])
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "it.md").write_text(WRITTEN.format(line[3]))
        return subprocess.CompletedProcess(line, 6 if "fails" in line else 0)

    monkeypatch.setattr(subprocess, "run", run)
    return lines


def test_a_table_is_replaced_by_what_its_commands_write(docs: Path, ran: Lines) -> None:
    assert results.main(["one"]) == 0
    assert [line[: line.index("--out")] for line in ran] == [
        ["experiment", "ng-delp-figure3", "--seeds", "1"],
        ["evaluate", "films/mot/a", "--tracker", "x"],
    ]
    text = docs.read_text()
    before, after = PAGE[: PAGE.index("| old")], PAGE[PAGE.index("<!-- end one") :]
    table = "| a | b |\n| --- | --- |\n| experiment | 1 |\n| evaluate | 1 |\n\nA note.\n\n"
    assert (
        re.sub(r"\d{4}-\d\d-\d\d", "DATE", text) == f"{before}{table}Measured on DATE.\n\n{after}"
    )


def page_after(docs: Path, command: str) -> str:
    """Return the page after a run in which this command makes its table."""
    docs.write_text(re.sub(r"    motes-lab[^<]*?MOT/a --tracker x", f"    {command}", PAGE))
    assert results.main(["one"]) == 0
    return docs.read_text()


def test_a_script_prints_its_tables(docs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def run(line: list[str], stdout: IO[bytes], **_: object) -> subprocess.CompletedProcess[str]:
        assert line[1:] == ["benchmarks/one.py", "films/sot/Book"]
        stdout.write(WRITTEN.format("printed").encode())
        return subprocess.CompletedProcess(line, 0)

    monkeypatch.setattr(subprocess, "run", run)
    assert "| printed | 1 |" in page_after(docs, "python benchmarks/one.py SEQUENCES/Book")


def test_a_module_of_the_tests_prints_its_tables(
    docs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONPATH", "mine")

    def run(
        line: list[str], stdout: IO[bytes], env: dict[str, str], **_: object
    ) -> subprocess.CompletedProcess[str]:
        assert line[1:] == ["-m", "fuzzing", "--rounds", "1"]
        assert env["PYTHONPATH"].split(os.pathsep) == [str(ROOT / "tests"), "mine"]
        stdout.write(WRITTEN.format("printed").encode())
        return subprocess.CompletedProcess(line, 0)

    monkeypatch.setattr(subprocess, "run", run)
    assert "| printed | 1 |" in page_after(docs, "PYTHONPATH=tests python -m fuzzing --rounds 1")


def test_tables_are_listed_with_their_minutes(
    docs: Path, ran: Lines, capfd: pytest.CaptureFixture[str]
) -> None:
    again = PAGE.partition("<!-- results other")[0].replace("one", "same")
    docs.write_text(PAGE + again)
    assert results.main(["--list"]) == 0
    lines = [line.split() for line in capfd.readouterr().out.splitlines()]
    assert lines[:-1] == [["1", "min", "other"], ["2", "min", "one"], ["2", "min", "same"]]
    assert " ".join(lines[-1]).startswith("3 tables, about 3 min")
    assert not ran


def test_what_was_run_is_not_run_again(docs: Path, ran: Lines) -> None:
    assert results.main(["one"]) == 0
    first = docs.read_text()
    assert results.main([]) == 0
    assert len(ran) == 3
    assert docs.read_text().startswith(first[:200])
    (marker, *_) = sorted((docs.parent / "kept").glob("evaluate-*/done.json"))
    told = json.loads(marker.read_text())
    assert told["command"] == "motes-lab evaluate MOT/a --tracker x"
    assert told["minutes"] >= 0
    marker.unlink()
    assert results.main(["one"]) == 0
    assert ran[-1][-1] == "--resume"  # an evaluation goes on with the tracks that it has


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda text: text.replace("--seeds 1", "fails"), "ended with exit code 6"),
        (
            lambda text: text.replace("| All", "| Mean"),
            "No table begins with 'Mean'; there are All",
        ),
    ],
)
def test_a_table_that_cannot_be_made_stays(
    change: Callable[[str], str],
    why: str,
    docs: Path,
    ran: Lines,
    capfd: pytest.CaptureFixture[str],
) -> None:
    docs.write_text(change(PAGE))
    assert results.main(["one"]) == 1
    assert docs.read_text() == change(PAGE)
    assert why in capfd.readouterr().err


def test_an_unknown_name_is_answered_with_the_known_ones(
    docs: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit):
        results.main(["two"])
    assert "there is no table two; known are one, other." in capfd.readouterr().err
