"""What users get for options that make no sense, on odd terminals, and without standard streams."""

import errno
import subprocess
import sys
from pathlib import Path

import pytest

from clips import write_film
from commands import Tell
from motes import synthetic
from motes.cli import main
from motes.cli.exit_codes import NO_MEMORY
from motes.cli.explain import explain

MOTES = f"{sys.executable} -m motes"
HUGE = "99999999999999999999"


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a film of two frames."""
    path = tmp_path_factory.mktemp("film") / "film.mkv"
    write_film(path, synthetic.still((160, 120), target=(30, 40), frames=2))
    return path


@pytest.fixture
def go(film: Path, here: Path, capfd: pytest.CaptureFixture[str]) -> Tell:
    """Run a command in a folder with a film."""
    Path("film.mkv").symlink_to(film)
    return Tell(capfd)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("track -- -dash.mkv --init 1,2,9,9", "--init is an option; write it before --."),
        ("watch -- --end 5", "--end is an option; write it before --."),
        ("watch film.mkv -- --end 5", "--end is an option; write it before --."),
        ("track --end 3 -- -dash.mkv -o=r.csv", "-o is an option; write it before --."),
        ("track -- -dash.mkv --reverse", "Unknown option: --reverse. Did you mean --resume?"),
        ("track film.mkv --reverse", "Unknown option: --reverse. Did you mean --resume?"),
        ("track film.mkv --video seen.mp4", "--overlay draws a film of tracks, -o writes rows"),
        ("watch film.mkv --save seen.mp4", "There is no option --save; --overlay draws a film"),
        ("track film.mkv --out-video=seen.mp4", "There is no option --out-video; --overlay"),
        ("convert rows.csv - --to mot", "- is no file; for standard input"),
        ("check film.mkv rows.csv -o -", "-o does not take -; see motes check --help"),
        ("track film.mkv --start", "--start needs a value; see motes track --help"),
        ("track film.mkv --particles", "a key of the configuration; write --set particles="),
        ("refine film.mkv rows.csv --scale 85", "motes convert ROWS OTHER --scale … adds"),
        ("watch film.mkv --detector.history=2", "write --set detector.history=VALUE."),
        ("track film.mkv --set particles", "--set takes KEY=VALUE, as in motion.noise.size=0.1"),
        ("track film.mkv --set a.b=1 --set a=2", "--set gives a twice, or keys inside it too"),
        ("track film.mkv --preset numiaro --set motion.nois=1", "did you mean 'nummiaro'?"),
        (
            "track film.mkv --preset nummiaro --set motion=random_walk",
            "motion.type: this key is missing before 'random_walk'; known are random_walk, ",
        ),
        ("track film.mkv --set motion.noise.size=1", "no key 'motion'; preset nummiaro has it."),
        ("watch film.mkv --set detectr.history=3", "did you mean 'detector'?"),
        ("batch film.mkv film.mkv --do watch -o r", "film.mkv; quote a pattern, as 'img/*.png'"),
        ("batch film.mkv other --do watch -o r", "takes other; a name with spaces needs quotes"),
        ("watch -", "for standard input give /dev/stdin, for output /dev/stdout."),
    ],
)
def test_unknown_options_are_named(line: str, said: str, go: Tell) -> None:
    error = go.says(line, 2, said)
    assert error.count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [
        f"track film.mkv --init 60,40,30,40 -o r.csv --end {HUGE}",
        "track film.mkv --init 60,40,30,40 -o r.csv --preset nummiaro --set particles=1000000000",
        "track film.mkv --init 60,40,30,40 -o r.csv --config huge.toml",
        "watch film.mkv -o r.csv --set detector.history=2147483648",
        f"demo --frames {HUGE}",
    ],
)
def test_numbers_that_are_too_large(go: Tell, line: str) -> None:
    Path("huge.toml").write_text(f"particles = {HUGE}\n")
    code, error = go(line)
    assert (code, error.count("\n")) == (2, 1), error
    assert "defect" not in error


@pytest.mark.slow
def test_a_missing_package_is_named() -> None:
    """As of a Python in which motes is found, but was not installed."""
    code = "import sys; sys.modules['cyclopts'] = None; from motes.cli import main; exit(main())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr.count("\n")) == (1, 1), done.stderr
    assert done.stderr.startswith("motes: error: The installation is not whole: ")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("line", "code", "lines"),
    [
        ("--help >&-", 5, 1),  # there is nowhere to write it
        ("track --no-such 2>&-", 2, 0),  # and nothing in its place on standard output
        ("--version <&-", 0, 0),
    ],
)
def test_closed_streams(line: str, code: int, lines: int) -> None:
    found = subprocess.run(f"{MOTES} {line}", shell=True, capture_output=True, text=True)
    assert (found.returncode, found.stderr.count("\n")) == (code, lines), found.stderr
    assert "no option" not in found.stdout


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        RuntimeError("can't start new thread"),
        OSError(errno.ENOMEM, "Cannot allocate memory"),
        ImportError("x.so: failed to map segment from shared object"),
    ],
)
def test_a_lack_of_memory_is_no_defect(error: Exception) -> None:
    assert explain(error, "motes") == (NO_MEMORY, 2)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has users otherwise")
def test_who_has_no_home_is_told_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As in a container, of a user whom the system does not know."""
    monkeypatch.setattr("pwd.getpwuid", {}.__getitem__)
    for name in ("HOME", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    said = "You have no home folder here; name one in the environment variable HOME."
    assert main(["network", "list"]) == 2
    assert capsys.readouterr().err == f"motes: error: {said}\n"
    assert main(["doctor"]) == 0
    assert f"not downloaded (optional): {said}" in capsys.readouterr().out
    if sys.platform != "darwin":
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        assert main(["network", "list"]) == 0


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limit")
@pytest.mark.parametrize(
    ("limit", "message"),
    [
        ("-v 600000", "Memory is limited to 600000 KB of addresses"),
        ("-n 9", "9 open files are allowed"),
    ],
)
def test_a_limit_that_libraries_cannot_bear_is_named(
    tmp_path: Path, limit: str, message: str
) -> None:
    line = f"ulimit {limit}; exec {MOTES} track film.mkv --init 1,2,30,40"
    done = subprocess.run(line, shell=True, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr.startswith(f"motes: error: {message}")
    assert done.stderr.count("\n") == 1


def test_a_lack_of_file_descriptors_says_what_to_do() -> None:
    message, code = explain(OSError(errno.EMFILE, "Too many open files", "rows.csv"), "motes")
    assert "raise the limit (ulimit -n)" in message
    assert code == 2
