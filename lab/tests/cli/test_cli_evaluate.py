"""`motes-lab evaluate`: what users get, how it fails, and what is left when it is interrupted."""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import arena
from arena import Go, at_home, evaluating, table, tracks
from in_process import work_here
from motes_lab.cli import main
from motes_lab.scores import COLUMNS
from waiting import wait_until

PROGRAM = [sys.executable, "-m", "motes_lab"]


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Return the current folder for all tests: two sequences, some trackers."""
    folder = tmp_path_factory.mktemp("home")
    clip = arena.still()
    for name in ("a", "b"):
        arena.write_sequence(folder / "data" / name, clip)
    arena.write_sequence(folder / "worse" / "a", clip)
    arena.write_sequence(folder / "worse" / "short", clip)
    (folder / "worse" / "short" / "img" / "0007.png").unlink()
    (folder / "empty").mkdir()
    (folder / "mine.py").write_text(arena.TRACKERS)
    (folder / "my.toml").write_text("particles = 30\n")
    with at_home(folder, "mine"), pytest.MonkeyPatch.context() as patch:
        work_here(patch)
        yield folder


@pytest.fixture
def go(home: Path, capfd: pytest.CaptureFixture[str]) -> Go:
    return evaluating(capfd)


WHOLE = "--tracker my.toml --tracker mine:Seeded --seeds 2 --protocol ope --protocol pixel"


@pytest.fixture(scope="module")
def whole(home: Path) -> str:
    """Return the folder of a run that nothing disturbed."""
    assert main(["evaluate", "data", *WHOLE.split(), "--out", "whole", "--workers", "1"]) == 0
    return "whole"


@pytest.mark.slow
def test_results(whole: str) -> None:
    rows = table(whole)
    assert tuple(rows[0]) == COLUMNS
    names = [tuple(row[name] for name in COLUMNS[:5]) for row in rows]
    assert names == [
        (tracker, sequence, protocol, start, seed)
        for tracker in ("my.toml", "mine:Seeded")
        for sequence in ("a", "b")
        for protocol, start in (("ope", ""), ("pixel", "+1"), ("pixel", "-1"), ("pixel", "0"))
        for seed in ("0", "1")
    ]
    for row in rows:
        assert row["error"] == ""
        assert row["frames"] == "20"
        assert float(row["auc"]) > 0.5
    assert {len(path) for path in tracks(Path(whole)).values()} == {arena.FRAMES + 1}
    assert "mine:Seeded" in Path(whole, "summary.md").read_text()


@pytest.mark.slow
def test_resuming_adds_what_is_missing(whole: str, go: Go) -> None:
    shutil.copytree(whole, "more")
    gone = Path("more/tracks/mine%3ASeeded/b/ope-1.csv")
    gone.unlink()
    kept = Path("more/tracks/my.toml/a/ope-0.csv").read_bytes()
    line = f"data {WHOLE} --tracker mine:Still --out more --resume --workers 2"
    assert go(line.replace("--seeds 2", "--seeds 3"))[0] == 0
    assert len(table("more")) == 24 + 24 + 8
    assert Path("more/tracks/my.toml/a/ope-0.csv").read_bytes() == kept
    found = tracks(Path("more"))
    assert {name: found[name] for name in tracks(Path(whole))} == tracks(Path(whole))


@pytest.mark.slow
def test_what_fails_is_named_and_the_rest_is_done(go: Go) -> None:
    code, out, error = go(
        "worse --tracker mine:Still --tracker mine:Raises --tracker mine:Stil --tracker cv2:mill "
        "--out failing --workers 1"
    )
    assert code == 6
    assert error.splitlines() == [
        "motes: sequence short: " + error.splitlines()[0].partition("short: ")[2],
        "motes: tracker mine:Stil: It cannot be imported: AttributeError: module 'mine' has no "
        "attribute 'Stil'; correct it.",
        "motes: tracker cv2:mill: There is no tracker of this name; did you mean cv2:mil?",
        "motes: mine:Raises on a, ope, seed 0: At frame 7: ValueError: no more of this",
        "motes: 2 passes, 1 failed; wrote failing/summary.md.",
    ]
    assert "0007" in error.splitlines()[0]
    good, bad = table("failing")
    assert good["tracker"] == "mine:Still"
    assert good["error"] == ""
    assert (bad["tracker"], bad["auc"]) == ("mine:Raises", "")
    assert bad["error"] == "At frame 7: ValueError: no more of this"
    assert "0 of 1" in out
    assert "no more of this" in Path("failing", "summary.md").read_text()


@pytest.mark.parametrize(
    ("line", "code", "error"),
    [
        ("nowhere", 3, "There is no file or folder nowhere"),
        ("empty", 3, "no sequence in empty"),
        ("worse --sequence short", 3, "No sequence of worse can be used. sequence short: "),
        ("data --tracker nix --tracker zzz", 2, "no tracker to run. tracker nix: .* tracker zzz: "),
        ("data --sequence c*", 2, r"--sequence c\* fits none of a, b"),
        ("data --first-pixel 2", 2, "--first-pixel takes 0, 1 or GLOB=0"),
        ("data --first-pixel c=0", 2, "'c' fits no sequence"),
        ("data --protocol vot", 2, "vot"),
        ("data --seeds 0", 2, "--seeds is 0"),
        ("data --workers 0", 2, "--workers is 0"),
        ("data --time-limit 0", 2, "--time-limit is 0"),
        ("data --time-limit nan", 2, "--time-limit is nan"),
        ("data --resume --overwrite", 2, "contradict"),
        ("data --out data/a/groundtruth_rect.txt", 5, "cannot be written"),
    ],
)
def test_refusals(line: str, code: int, error: str, go: Go) -> None:
    found, out, message = go(line if "--out" in line else f"{line} --out refused")
    assert (found, out) == (code, "")
    assert re.search(error, message), message
    assert message.count("\n") == 1
    assert not Path("refused").exists()


@contextlib.contextmanager
def started(line: str, home: Path) -> Iterator[subprocess.Popen[str]]:
    """Start a program, and wait until it has done one pass and is in the middle of another."""
    processes, out = home / "processes", home / line.split()[-1]
    processes.unlink(missing_ok=True)
    with subprocess.Popen(
        [*PROGRAM, "evaluate", *line.split()],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            wait_until(lambda: processes.exists() and len(tracks(out)) > 0)
            yield process
        finally:
            process.kill()
    wait_until(lambda: arena.all_gone(processes))  # though nobody told them


@pytest.mark.slow
def test_a_signal_leaves_a_report_of_what_is_done(home: Path) -> None:
    number, word = signal.SIGTERM, "terminated"
    line = f"data --tracker mine:Still --tracker mine:Hangs --workers 2 --out {word}"
    with started(line, home) as process:
        os.killpg(process.pid, number)  # as a terminal does
        out, error = process.communicate()
    assert process.returncode == 128 + number
    assert re.fullmatch(
        rf"motes: {word} after \d pass(es)?, 0 failed; wrote {word}/summary\.md\. "
        r"Go on with --resume\.\n",
        error,
    )
    assert "mine:Still" in out
    rows = table(word)
    assert len(rows) == len(tracks(home / word)) in (1, 2)
    assert {(row["tracker"], row["error"]) for row in rows} == {("mine:Still", "")}
    assert "mine:Still" in Path(word, "summary.md").read_text()


def test_ctrl_c_before_anything_is_done(go: Go, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("motes_lab.runner.run", interrupt)
    code, out, error = go("data --tracker mine:Still --out nothing")
    assert (code, out) == (130, "")
    assert error == (
        "motes: interrupted after 0 passes, 0 failed; wrote nothing/summary.md. Go on with "
        "--resume.\n"
    )
    assert table("nothing") == []


@pytest.mark.slow
def test_a_killed_run_is_resumed(go: Go, home: Path) -> None:
    line = "data --tracker mine:Still --tracker mine:Waits --workers 2 --out"
    with started(f"{line} killed", home) as process:
        process.kill()
    before = {path: path.read_bytes() for path in Path("killed").glob("tracks/*/*/*.csv")}
    assert 0 < len(before) < 4
    Path("released").touch()
    assert go(f"{line} killed --resume")[0] == 0
    assert go(f"{line} undisturbed")[0] == 0
    assert {path: path.read_bytes() for path in before} == before
    assert tracks(Path("killed")) == tracks(Path("undisturbed"))
    assert len(tracks(Path("killed"))) == 4
