"""`motes batch` with films and results on S3, of which one request in ten goes wrong.

    python benchmarks/cluster_s3.py --jobs 100
    python benchmarks/cluster_s3.py --jobs 100 --share 0

moto's server stands for S3, behind `flaky_proxy`. The driver is killed now and then. In the end
each job must be done, with the rows of an undisturbed local run.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cluster_common import film, finish, results, start, table
from flaky_proxy import FAULTS, FlakyProxy
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

ACCESS = {
    "AWS_ACCESS_KEY_ID": "test",
    "AWS_SECRET_ACCESS_KEY": "test",
    "AWS_DEFAULT_REGION": "us-east-1",
}


@contextlib.contextmanager
def flaky_s3(share: float, seed: int = 0, stall: float = 30.0) -> Iterator[tuple[Any, FlakyProxy]]:
    """Give fsspec's file system of a server with the bucket `films`, and a proxy before it."""
    import s3fs
    from moto.server import ThreadedMotoServer

    os.environ.update(ACCESS)
    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    host, port = server.get_host_and_port()
    proxy = FlakyProxy(port, share, seed, stall)
    try:
        files = s3fs.S3FileSystem(
            endpoint_url=f"http://{host}:{port}", use_listings_cache=False, skip_instance_cache=True
        )
        files.mkdir("films")
        yield files, proxy
    finally:
        proxy.close()
        server.stop()


def main() -> int:
    """Print what went wrong, and what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--jobs", type=int, default=60)
    parser.add_argument("--frames", type=int, default=60)
    parser.add_argument("--share", type=float, default=0.1)
    parser.add_argument("--kills", type=int, default=3, help="of the driver")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rng = random.Random(options.seed)
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="s3-")))
        films = [film(folder / f"film-{n}.mp4", options.frames + 10 * n) for n in range(4)]
        finish(table(folder / "local.csv", films, options.jobs), folder / "whole", "--workers", "1")
        files, proxy = stack.enter_context(flaky_s3(options.share, options.seed))
        for each in films:
            files.put_file(str(each), f"films/{each.name}")
        remote = [Path(f"films/{each.name}") for each in films]
        jobs = table(folder / "remote.csv", remote, options.jobs)
        jobs.write_text(jobs.read_text().replace("films/", "s3://films/"))
        where = {"AWS_ENDPOINT_URL": proxy.address}
        kills = 0
        process = start(jobs, "s3://films/out", variables=where)
        while process.poll() is None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(rng.uniform(5, 15) if kills < options.kills else None)
                break
            process.kill()
            process.wait()
            kills += 1
            process = start(jobs, "s3://films/out", variables=where)
        files.get("films/out", str(folder / "out"), recursive=True)
        found, whole = results(folder / "out"), results(folder / "whole")
        wrong = sum(found.get(name) != whole.get(name) for name in {*found, *whole})
    names = {"error": "answered 503", "stall": "stalled"}
    counts = {
        "jobs": options.jobs,
        "kills of the driver": kills,
        "requests": proxy.requests,
        **{names.get(fault, fault): proxy.faults[fault] for fault in FAULTS},
        "results lost or different": wrong,
    }
    row: Row = tuple(Cell(f"{each}") for each in counts.values())
    print(markdown.table(Table("Batches whose requests go wrong", (*counts,), [row])))
    return 1 if wrong or process.returncode else 0


if __name__ == "__main__":
    sys.exit(main())
