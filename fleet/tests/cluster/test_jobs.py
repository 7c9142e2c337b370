"""Tables of jobs: every form, and every mistake with its row."""

import json
import re
import tracemalloc
from collections.abc import Mapping
from pathlib import Path

import pytest

import batch_jobs
from motes import MotesError
from motes_fleet.cluster.jobs import Job, read_job
from motes_fleet.cluster.table import JobTable

ROW = {"source": "film.mp4", "init": "1,2,3,4"}


def job_of(row: Mapping[str, object]) -> Job:
    """Return the job of a row with which nothing is wrong."""
    job, wrong = read_job(row, "film")
    assert job is not None
    assert wrong == []
    return job


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ({"sede": 1}, "no column 'sede'; did you mean 'seed'"),
        ({"source": ""}, "has no source"),
        ({"seed": "x"}, "^column seed: got 'x'; it takes integer.$"),
        ({"do": "trck", "end": "2.5"}, 'refine", "track" or "watch". column end: got \'2.5\'; it'),
        ({"init": "1,2,0,4"}, "no area"),
        ({"label": "a\u2028b"}, "U.2028"),
        ({"init": ""}, "one of init, keyframes and detect"),
        ({"do": "watch"}, "watch takes no init"),
        ({"do": "refine", "init": ""}, "rows and keyframes"),
        ({"rows": "r.csv"}, "track takes no rows"),
        ({"init": "", "keyframes": "k.csv", "stride": 2}, "stride"),
        ({"source": "rtsp://camera/1"}, "is live"),
    ],
)
def test_mistakes_in_a_row(row: dict[str, object], words: str) -> None:
    _, wrong = read_job(ROW | row, "film")
    assert re.search(words, " ".join(wrong))


@pytest.mark.parametrize("value", ["a.onnx, b.onnx", ["a.onnx", "b.onnx"]])
def test_the_files_of_a_network_are_inputs(value: object) -> None:
    job = job_of(ROW | {"network": value})
    assert [Path(path).name for path in job.network] == ["a.onnx", "b.onnx"]
    assert all(Path(path).is_absolute() for path in job.network)
    assert [path for _, path in job.files] == [job.source, *job.network]
    moved = job.with_files(lambda path: f"copies/{Path(path).name}")
    assert (moved.source, moved.network) == ("copies/film.mp4", ("copies/a.onnx", "copies/b.onnx"))
    assert job.digest() != job_of(ROW).digest()


def test_every_form_of_a_table(tmp_path: Path) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    film, _ = batch_jobs.films(tmp_path, 2)
    rows = [{"source": str(film), "init": "1,2,3,4", "seed": n, "name": f"j{n}"} for n in (1, 2)]
    batch_jobs.table(tmp_path / "a.csv", [row | {"preset": ""} for row in rows])
    (tmp_path / "b.jsonl").write_text("".join(json.dumps(row) + "\n\n" for row in rows))
    parquet.write_table(pyarrow.Table.from_pylist(rows), tmp_path / "c.parquet")
    text = "".join(
        "[[job]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in row.items())
        for row in rows
    )
    (tmp_path / "d.toml").write_text(text)
    expected = [job_of(row) for row in rows]
    for name in ("a.csv", "b.jsonl", "c.parquet", "d.toml"):
        table = JobTable(str(tmp_path / name))
        assert list(table.jobs()) == expected, name
        assert table.problems(lambda _: None) == (2, 0, [])
    films = JobTable(str(tmp_path / "film-*.mp4"), {"do": "watch"})
    assert [job.name for job in films.jobs()] == ["film-0", "film-1"]


NESTED = "[" * 100_000 + "]" * 100_000


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.toml", "[[jobs]]\n", "has [[job]] only"),
        ("a.jsonl", "[1]\n", "line 1 is no object"),
        ("a.csv", None, "cannot be read"),
        ("a.csv", "source,init\na.mp4,1,2,3,4\n", "row 2 has more fields than the first"),
        ("a.csv", "source;init\na.mp4;1,2,3,4\n", "has semicolons between its columns"),
        ("a.parquet", "no", ""),
        ("a.toml", f"[[job]]\nsource = {NESTED}\n", "is nested too deeply"),
        ("a.jsonl", f'{{"source": {NESTED}}}\n', "is nested too deeply"),
        ("a.toml", f"[[job]]\n{'a.' * 100_000}b = 1\n", "has a key of more than"),
    ],
    ids=range(9),
)
def test_what_is_no_table(tmp_path: Path, name: str, text: str | None, words: str) -> None:
    if text is not None:
        (tmp_path / name).write_text(text)
    with pytest.raises(MotesError) as caught:
        list(JobTable(str(tmp_path / name)).jobs())
    assert name in str(caught.value)
    assert words in str(caught.value)


@pytest.mark.slow
def test_long_tables_are_not_held(tmp_path: Path) -> None:
    path = tmp_path / "jobs.jsonl"
    row = json.dumps(ROW | {"name": "x"})
    path.write_text((row + "\n") * 2_000)
    tracemalloc.start()
    assert sum(1 for _ in JobTable(str(path)).jobs()) == 2_000
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 1e6
    assert isinstance(next(JobTable(str(path)).jobs()), Job)


def test_a_published_network_is_its_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """So they reach other machines as any file does; one that is not here is said."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    _, (wrong,) = read_job(ROW | {"network": "nanotrack"}, "film")
    assert "motes network get nanotrack" in wrong
