"""Batches: each job once, whatever dies, and the same rows as the commands write."""

import contextlib
import errno
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import pytest
from PIL import Image

import batch_jobs
from clips import clip, picture
from in_process import InProcess, work_here
from motes import FormatError
from motes.cli import main
from motes_fleet.cluster.driver import BatchEvent, batch
from motes_fleet.cluster.jobs import Job
from motes_fleet.cluster.records import Record, records
from motes_fleet.cluster.state import Options, load_jobs, save, write_table
from motes_fleet.cluster.store import Folder, open_store
from motes_fleet.cluster.work import Plan, work
from motes_fleet.commands import batch_job
from onnx_trackers import save_pair
from waiting import wait_until


def job(name: str, film: Path, **more: object) -> Job:
    return Job(name=name, source=str(film), init=((1, 2, 3, 4),), **more)  # type: ignore[arg-type]


def run(
    out: Path, jobs: list[Job], pool: InProcess, **options: object
) -> tuple[list[str], dict[str, Record]]:
    """Do jobs; return those that were kept, and the records of the others."""
    plan = Plan(out=str(out), make=batch_jobs.make, **options)  # type: ignore[arg-type]
    kept: list[str] = []
    events: list[BatchEvent] = list(
        batch(pool, Folder(out), jobs, plan, lambda record: kept.append(record.name))
    )
    return kept, {each.name: each for each in events if isinstance(each, Record)}


@pytest.fixture
def film(tmp_path: Path) -> Path:
    return batch_jobs.films(tmp_path, 1)[0]


def rows(out: Path, name: str) -> str:
    return (out / "rows" / f"job={name}" / "rows.csv").read_text()


def test_changed_inputs_are_told_by_their_checksums(tmp_path: Path, film: Path) -> None:
    jobs, out = [job("a", film)], tmp_path / "out"
    _, made = run(out, jobs, InProcess())
    checksum = made["a"].inputs[0].sha256
    os.utime(film, (1, 1))  # as a copy of the same film
    assert run(out, jobs, InProcess())[0] == ["a"]
    film.write_bytes(film.read_bytes()[::-1])
    _, made = run(out, jobs, InProcess())
    assert made["a"].status == "done"
    assert made["a"].inputs[0].sha256 != checksum
    assert run(out, [job("a", film, seed=1)], InProcess())[1]["a"].status == "done"
    assert rows(out, "a") == "film-0.mp4 1\n"


def test_a_result_of_an_attempt_that_died_is_found(tmp_path: Path, film: Path) -> None:
    pool, out = InProcess(["a", "a"]), tmp_path / "out"
    _, made = run(out, [job("a", film)], pool)
    assert (pool.done, made["a"].status, made["a"].attempts) == (["a"] * 3, "done", 3)
    ((_, kept),) = records(Folder(out), [job("a", film)])
    assert kept == made["a"]


def test_rows_without_a_record_are_replaced(tmp_path: Path, film: Path) -> None:
    out = tmp_path / "out"
    run(out, [job("a", film)], InProcess())
    (out / "jobs" / "a.json").unlink()
    (out / "rows" / "job=a" / "rows.csv").write_text("of another film\n")
    run(out, [job("a", film)], InProcess())
    assert rows(out, "a") == "film-0.mp4 0\n"


def test_failed_jobs_wait_until_they_are_asked_for(tmp_path: Path, film: Path) -> None:
    jobs, out = [job("fails", film), job("good", film)], tmp_path / "out"
    _, made = run(out, jobs, InProcess())
    assert (made["fails"].status, made["fails"].error) == ("failed", "This film is broken.")
    assert not (out / "rows" / "job=fails").exists()
    assert run(out, jobs, InProcess())[0] == ["fails", "good"]
    kept, made = run(out, jobs, InProcess(), again=True)
    assert (kept, [*made]) == (["good"], ["fails"])
    film.write_bytes(film.read_bytes() + b"mended")
    assert [*run(out, jobs, InProcess())[1]] == ["good", "fails"]


def test_a_file_is_whole_or_absent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store, made = open_store(str(tmp_path / "out")), tmp_path / "made"
    store.write("a/b", b"one")
    made.write_bytes(b"two\nlines")
    store.write("a/c", made)
    assert not made.exists()  # it was renamed, not copied
    assert store.read(["a/b", "a/c", "a/d"]) == {"a/b": b"one", "a/c": b"two\nlines"}
    assert list(store.lines("a/c")) == [b"two\n", b"lines"]
    assert sorted([*store.names("a"), *store.names("none")]) == ["b", "c"]
    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", full)
        with pytest.raises(FormatError, match="make room"):
            store.write("a/b", b"three")
    assert store.read(["a/b"]) == {"a/b": b"one"}
    assert not list((tmp_path / "out" / "_attempts").iterdir())
    store.remove("a")
    assert not list(store.names("a"))


def test_a_full_disk_is_told_with_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = Folder(tmp_path)
    save(store, [], Options(total=0, form="csv", overlay=False))
    monkeypatch.setattr(tempfile, "TemporaryDirectory", full)
    with pytest.raises(FormatError, match=r"^jobs\.\w+ cannot be written: No space .*make room"):
        write_table(store)


def test_a_job_on_a_full_disk_does_not_say_that_it_has_kept_rows(
    tmp_path: Path, film: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("motes.rows.writer.write_all", full)
    plan = Plan(out=str(tmp_path / "out"), make=batch_job.make)
    record = work((job("one", film), plan))
    assert record.error == "Its results cannot be written: No space left on device; make room."
    assert not [*tmp_path.glob("out/_attempts/*")]


def full(*_: object, **__: object) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_worker_that_was_taken_for_dead_changes_nothing(tmp_path: Path, film: Path) -> None:
    """It ends after another one has done its job: each file is whole, before and after."""
    order = job("a", film), Plan(str(tmp_path / "out"), batch_jobs.make)
    first = work(order)
    before = rows(tmp_path / "out", "a")
    second = work(order)
    assert second.inputs == first.inputs
    assert rows(tmp_path / "out", "a") == before
    ((_, kept),) = records(Folder(tmp_path / "out"), [order[0]])
    assert kept == second


def test_two_batches_do_not_share_a_folder(tmp_path: Path) -> None:
    with (
        Folder(tmp_path).used_alone(),
        pytest.raises(FormatError, match="Another motes batch"),
        Folder(tmp_path).used_alone(),
    ):
        pass


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with three films and a table of jobs of every kind."""
    folder = tmp_path_factory.mktemp("inputs")
    batch_jobs.films(folder)
    (folder / "keys.csv").write_text("0,2,2,16,12\n8,absent\n")
    (folder / "more.csv").write_text("5,4,4,16,12\n")
    with contextlib.chdir(folder):
        both = ["track", "film-0.mp4", "--keyframes", "keys.csv", "--preset", "nummiaro"]
        assert main([*both, "-o", "both.csv"]) == 0
    batch_jobs.table(
        folder / "jobs.csv",
        [
            {"source": "film-1.mp4", "seed": 3, "label": "one"},
            {"source": "film-2.mp4", "init": "", "do": "watch", "preset": ""},
            {"source": "film-0.mp4", "init": "", "keyframes": "keys.csv", "name": "both"},
            {
                "source": "film-0.mp4", "init": "", "keyframes": "more.csv", "name": "mended",
                "rows": "both.csv", "do": "refine", "preset": "",
            },
            {"source": "film-2.mp4", "init": "2,2,16,12; 20,9,12,12", "name": "two"},
        ],
    )  # fmt: skip
    return folder


@pytest.fixture
def home(inputs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder, with the inputs."""
    shutil.copytree(inputs, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    work_here(monkeypatch)
    return tmp_path


@pytest.mark.slow
def test_rows_are_those_of_the_commands(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["batch", "jobs.csv", "-o", "out", "--workers", "2"]) == 0
    assert "5 jobs, 5 done, 0 failed, 75 frames" in capsys.readouterr().err
    particles = ["--preset", "nummiaro"]
    box = ["--init", batch_jobs.REGION]
    commands = {
        "film-1": ["track", "film-1.mp4", *box, *particles, "--seed", "3"],
        "film-2": ["watch", "film-2.mp4", "--events", "events.jsonl"],
        "both": ["track", "film-0.mp4", "--keyframes", "keys.csv", *particles],
        "mended": ["refine", "film-0.mp4", "both.csv", "--keyframes", "more.csv"],
        "two": ["track", "film-2.mp4", *box, "--init", "20,9,12,12", *particles],
    }
    for name, command in commands.items():
        main([*command, "-o", f"{name}-again.csv"])
        assert rows(home / "out", name) == Path(f"{name}-again.csv").read_text(), name
    events = home / "out" / "events" / "job=film-2" / "events.jsonl"
    assert events.read_bytes() == Path("events.jsonl").read_bytes()
    frames = {job.name: record and record.frames for job, record in records(
        Folder(home / "out"), load_jobs(Folder(home / "out")))}  # fmt: skip
    assert frames == {"film-1": 15, "film-2": 20, "both": 10, "mended": 10, "two": 20}


@pytest.mark.slow
def test_a_network_is_a_column(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    work_here(monkeypatch)
    films = batch_jobs.films(tmp_path, 2)
    files = ",".join(save_pair(tmp_path))
    row = {"source": films[0], "preset": ""}
    batch_jobs.table(Path("jobs.csv"), [row | {"name": "with", "network": files}, row])
    assert main(["batch", "jobs.csv", "-o", "out", "--workers", "1"]) == 0
    command = ["track", str(films[0]), "--init", batch_jobs.REGION, "--network", files]
    assert main([*command, "-o", "again.csv"]) == 0
    assert rows(tmp_path / "out", "with") == Path("again.csv").read_text()
    assert rows(tmp_path / "out", "with") != rows(tmp_path / "out", "film-0")
    Path("cut.onnx").write_bytes(Path("head.onnx").read_bytes()[:100])
    capsys.readouterr()
    line = ["batch", str(films[1]), "--init", batch_jobs.REGION]
    assert main([*line, "--network", "backbone.onnx,cut.onnx", "-o", "none"]) == 2
    assert "row 1: " in (words := capsys.readouterr().err)
    assert "cut.onnx is cut off" in words
    assert not Path("none").exists()


@pytest.mark.slow
def test_what_was_strange_is_in_the_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("images").mkdir()
    for index in range(3):
        Image.fromarray(picture(index)).save(f"images/{index}.png")
    line = ["batch", "images/", "--init", batch_jobs.REGION, "--preset", "nummiaro"]
    assert main([*line, "--workers", "1", "-o", "out"]) == 0
    ((_, record),) = records(Folder(tmp_path / "out"), load_jobs(Folder(tmp_path / "out")))
    assert record is not None
    assert str(record.error).startswith("The images have no frame rate, 25 a second are assumed")
    assert record.frames == 3


def test_a_box_may_begin_beside_the_picture(home: Path) -> None:
    batch_jobs.table(Path("beside.csv"), [{"source": "film-0.mp4", "init": "-4.0,2,16,12"}])
    assert main(["batch", "beside.csv", "--workers", "1", "-o", "out"]) == 0
    assert float(rows(home / "out", "film-0").splitlines()[1].split(",")[4]) == -4


def test_films_of_a_pattern_share_a_file_of_keyframes(home: Path) -> None:
    Path("all.csv").write_text("film-0,0,2,2,16,12\nfilm-0,7,absent\nfilm-1.mp4,2,2,2,16,12\n")
    line = ["--keyframes", "all.csv", "--preset", "nummiaro", "-o"]
    assert main(["batch", "film-[01].mp4", "--workers", "1", *line, "out"]) == 0
    for name in ("film-0", "film-1"):
        assert main(["track", f"{name}.mp4", *line, "one.csv", "--overwrite"]) == 0
        assert rows(home / "out", name) == Path("one.csv").read_text()
    assert main(["batch", "film-*.mp4", "--workers", "1", *line, "out"]) == 6
    assert "none of" in (home / "out" / "jobs" / "film-2.json").read_text()


@pytest.mark.slow
def test_a_dataset_of_parquet(home: Path) -> None:
    dataset = pytest.importorskip("pyarrow.dataset")
    parquet = pytest.importorskip("pyarrow.parquet")
    assert main(["batch", "jobs.csv", "-o", "out", "--rows", "parquet", "--overlay"]) == 0
    found = dataset.dataset("out/rows", partitioning="hive").to_table()
    names = Counter(found.column("job").to_pylist())
    assert names["film-1"] == 15
    labels = zip(found.column("job").to_pylist(), found.column("label").to_pylist(), strict=True)
    assert {label for job, label in labels if job == "film-1"} == {"one"}
    assert {path.name for path in Path("out/overlays").iterdir()} == {
        "film-1.mp4", "film-2.mp4", "both.mp4", "two.mp4",
    }  # fmt: skip
    table = parquet.read_table("out/jobs.parquet").to_pylist()
    assert [(each["job"], each["status"], each["attempts"]) for each in table] == [
        (name, "done", 1) for name in ("film-1", "film-2", "both", "mended", "two")
    ]
    assert table[0]["label"] == "one"
    assert re.fullmatch("[0-9a-f]{64}", table[0]["checksum"])


def test_problems_come_before_anything_starts(
    home: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    batch_jobs.table(
        Path("bad.csv"),
        [
            {"source": "film-0.mp4", "config": "bad.toml"},
            {"source": "none.mp4"},
            {"source": "film-1.mp4", "preset": "numiaro"},
            {"source": "film-2.mp4", "do": "watch", "init": "", "preset": "", "detector": "-x"},
            {"source": "film-0.mp4", "seed": 7},
            {"name": "a", "source": "film-0.mp4", "do": "watch", "init": "", "places": "bad.toml"},
            {"name": "b", "source": "film-0.mp4", "init": "", "keyframes": "keys.csv"},
        ],
    )
    Path("bad.toml").write_text("particle = 3\n")
    Path("keys.csv").write_text("0,1,2,x,4\n")
    assert main(["batch", "bad.csv", "-o", "out"]) == 2
    error = capsys.readouterr().err
    assert re.search(r"bad\.csv, row 2: \S*bad\.toml: Config has no key 'particle'", error)
    assert "row 3: the source" in error
    assert "row 4: No preset 'numiaro'" in error
    assert "row 5: A detector is" in error
    assert "row 2 has the name 'film-0' too" in error
    assert re.search(r"row 7: \S*bad\.toml: Config has no key 'particle'", error)
    assert re.search(r"row 8: \S*keys\.csv, row 1: '1,2,x,4' is no region", error)
    assert "7 rows of bad.csv cannot be used; nothing was started" in error
    assert not Path("out").exists()


def test_a_table_without_rows_is_refused(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("a.csv").write_text("source,init\n")
    assert main(["batch", "a.csv", "-o", "out"]) == 2
    assert "a.csv has no job; add a row" in capsys.readouterr().err
    assert not Path("out").exists()


def test_files_run_no_code_unasked(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Neither the column of a table, nor a configuration, nor a folder that somebody has made."""
    Path("evil.py").write_text("open('ran', 'a').close()\ndef find(frame): return []\n")
    Path("evil.toml").write_text("detector = {type = 'callable', name = 'evil:find'}\n")
    Path("rig.toml").write_text(
        "[[camera]]\nname = 'a'\nsource = 'film-0.mp4'\ndetector = 'evil:find'\n"
    )
    row = {"source": "film-0.mp4", "do": "watch", "init": "", "preset": ""}
    batch_jobs.table(Path("evil.csv"), [row | {"detector": "evil:find"}])
    batch_jobs.table(Path("config.csv"), [row | {"config": "evil.toml"}])
    for words in (
        "batch evil.csv -o out",
        "batch config.csv -o out",
        "batch config.csv -o out --config evil.toml",
        "watch film-0.mp4 --config evil.toml -o a.csv",
        "watch rig.toml -o a.csv",
    ):
        assert main(words.split()) == 2
        assert "The detector evil:find is code, which would run" in capsys.readouterr().err
    assert not Path("ran").exists()
    assert main(["batch", "evil.csv", "-o", "out", "--own-code", "--workers", "1"]) == 0
    assert Path("ran").exists()
    assert main(["batch", "retry", "out", "--failed"]) == 2
    assert "if you trust it, add --own-code" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "error"),
    [
        ("batch none.csv -o out", "none.csv cannot be read"),
        ("batch none.txt -o out", "fits no film"),
        ("batch jobs.csv -o out --attempts 0", "--attempts is 0"),
        ("batch jobs.csv -o out --time-limit 0", "--time-limit is 0"),
        ("batch jobs.csv -o out --cluster nowhere", "auto or HOST:PORT"),
        ("batch jobs.csv -o out --cluster 127.0.0.1:9", "omit it: then the processes of this"),
        ("batch jobs.csv -o nothing://x/y", "nothing:// is no kind of address"),
        ("batch status none", "There is no batch in none"),
        ("batch retry none --failed", "There is no batch in none"),
    ],
)
def test_mistakes_of_the_command(
    home: Path, capsys: pytest.CaptureFixture[str], words: str, error: str
) -> None:
    pytest.importorskip("ray")
    assert main(words.split()) in (2, 3)
    (line,) = capsys.readouterr().err.splitlines()
    assert error in line


def started(home: Path) -> subprocess.Popen[str]:
    """Start a batch of four jobs, and wait until one of them is done."""
    film = clip(home / "long.mp4", 150, width=128, height=96)
    batch_jobs.table(home / "long.csv", [{"source": film, "name": f"j{n}"} for n in range(4)])
    process = subprocess.Popen(
        [sys.executable, "-m", "motes", "batch", "long.csv", "-o", "long", "--workers", "1"],
        cwd=home,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until(lambda: any((home / "long" / "jobs").glob("*.json")))
    return process


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_a_driver_that_ended_goes_on(
    tmp_path: Path, number: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with contextlib.chdir(tmp_path), started(tmp_path) as process:
        process.send_signal(number)
        _, error = process.communicate()
        if number == signal.SIGTERM:
            assert process.returncode == 143
            assert re.search(r"terminated after \d of 4 jobs, ", error)
            assert "the same command goes on" in error
        before = {each.name: each.stat().st_mtime_ns for each in Path("long/jobs").iterdir()}
        assert len(before) < 4  # it does not wait for the rest
        assert main(["batch", "status", "long"]) == 0
        assert f"4 jobs: {len(before)} done, 0 failed" in capsys.readouterr().out
        work_here(monkeypatch)
        assert main(["batch", "retry", "long"]) == 0
        assert f"{len(before)} done before" in capsys.readouterr().err
        after = {each.name: each.stat().st_mtime_ns for each in Path("long/jobs").iterdir()}
        assert len(after) == 4
        assert {name: after[name] for name in before} == before
        assert not list(Path("long").glob("_attempts/*"))
        one = rows(Path("long"), "j0")
        assert [rows(Path("long"), f"j{n}") for n in range(4)] == [one] * 4
