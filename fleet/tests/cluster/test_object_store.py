"""Results on S3 behind a proxy that refuses, stalls and loses one request in four."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import batch_jobs
from in_process import work_here
from motes_fleet.cluster import objects
from motes_fleet.cluster.inputs import stamp
from motes_fleet.cluster.store import open_store

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"
FAULTS = "error", "stall", "lost before", "lost after"
pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("ignore")]


@pytest.fixture(scope="module")
def server() -> Iterator[tuple[Any, Any]]:
    """Give a server for S3, and a proxy of which one request in four goes wrong."""
    pytest.importorskip("s3fs", reason="s3fs is not installed: pip install 'motes-fleet[cloud]'")
    with pytest.MonkeyPatch.context() as patch, contextlib.ExitStack() as stack:
        patch.syspath_prepend(BENCHMARKS)
        from cluster_s3 import ACCESS, flaky_s3

        for name, value in ACCESS.items():
            patch.setenv(name, value)
        files, proxy = stack.enter_context(flaky_s3(0.25, stall=0.5))
        patch.setenv("AWS_ENDPOINT_URL", proxy.address)
        patch.setitem(objects.S3["config_kwargs"], "read_timeout", 0.3)
        patch.setattr(objects, "PAUSE", 0.01)
        objects._file_system.cache_clear()
        yield files, proxy
        objects._file_system.cache_clear()


def test_a_store_on_a_bad_network(server: tuple[Any, Any]) -> None:
    """Until each kind of fault has happened."""
    files, proxy = server
    store, names = open_store("s3://films/store"), list[str]()
    while len(names) < 10 or set(proxy.faults) != set(FAULTS):
        assert len(names) < 200, proxy.faults
        name = f"a/{len(names)}"
        store.write(name, name.encode())
        assert files.cat(f"films/store/{name}") == name.encode()
        names.append(name)
    assert store.read([*names, "a/none"]) == {name: name.encode() for name in names}
    assert {f"a/{each}" for each in store.names("a")} == set(names)
    store.write("a/0", b"new\nlines")
    assert list(store.lines("a/0")) == [b"new\n", b"lines"]
    store.remove("a")
    assert not list(store.names("a"))


def test_a_batch_from_s3_to_s3(
    server: tuple[Any, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from motes.cli import main

    files, _ = server
    monkeypatch.chdir(tmp_path)
    work_here(monkeypatch)
    for film in batch_jobs.films(tmp_path, 2):
        files.put_file(str(film), f"films/{film.name}")
    rows = [{"source": f"s3://films/film-{n}.mp4"} for n in (0, 1)]
    table = str(batch_jobs.table(tmp_path / "jobs.csv", rows))
    assert stamp("s3://films/film-0.mp4")
    assert not stamp("s3://films/none.mp4")
    assert main(["batch", table, "-o", "s3://films/out", "--workers", "1"]) == 0
    assert main(["track", "film-1.mp4", "--init", batch_jobs.REGION, "--preset", "nummiaro",
                 "-o", "rows.csv"]) == 0  # fmt: skip
    key = "films/out/rows/job=film-1/rows.csv"
    assert files.cat(key) == Path("rows.csv").read_bytes()
    before = files.info("films/out/jobs/film-1.json")["LastModified"]
    files.put_file(str(tmp_path / "film-1.mp4"), "films/film-0.mp4")
    assert main(["batch", table, "-o", "s3://films/out", "--workers", "1"]) == 0
    assert files.info("films/out/jobs/film-1.json")["LastModified"] == before
    assert files.cat("films/out/rows/job=film-0/rows.csv") == Path("rows.csv").read_bytes()
