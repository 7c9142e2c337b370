"""Kill workers, nodes and drivers of `motes batch` with -9 at random moments, and compare results.

    python benchmarks/cluster_kills.py --kills 50 worker
    python benchmarks/cluster_kills.py --kills 20 driver
    python benchmarks/cluster_kills.py --kills 50 --ray worker
    python benchmarks/cluster_kills.py --kills 20 --ray node
    python benchmarks/cluster_kills.py --kills 20 --ray driver

Batches run until there were so many kills. In the end each job must be done, and its rows must be
those of one undisturbed process, byte by byte. A job that was done before a kill must not have been
done again.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from cluster_common import film, finish, ray_cluster, results, running, stamps, start, table
from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Table

ATTEMPTS = "50"
"""A job may be hit often by chance; none may fail for that."""


class Trial:
    """A batch that is hit until it ends.

    Attributes
    ----------
    kills
        How many there were.
    different
        Results that are missing, or others than in an undisturbed run.
    again
        Jobs that were done twice.
    """

    def __init__(self, jobs: Path, whole: dict[str, bytes], address: str | None) -> None:
        self.jobs, self.whole = jobs, whole
        self.options = [] if address is None else ["--cluster", address]
        self.kills = self.different = self.again = 0

    def run(self, kind: str, most: int, rng: random.Random, seconds: float, cluster: Any) -> None:
        """Run the batch, hit it at random moments, and compare its results."""
        with tempfile.TemporaryDirectory(dir=self.jobs.parent) as folder:
            out = Path(folder) / "out"
            self._undergo(kind, most, rng, seconds, cluster, out)
            found = results(out)
            names = {*found, *self.whole}
            self.different += sum(found.get(name) != self.whole.get(name) for name in names)

    def _undergo(
        self, kind: str, most: int, rng: random.Random, seconds: float, cluster: Any, out: Path
    ) -> None:
        options = [*self.options, "--attempts", ATTEMPTS, "--workers", "2"]
        process, before = start(self.jobs, out, *options), dict[str, int]()
        while True:
            try:
                code = process.wait(rng.uniform(0.2, 1) * seconds)
                break
            except subprocess.TimeoutExpired:
                pass
            if self.kills >= most:
                code = process.wait()
                break
            if kind == "driver":
                process.kill()
                process.wait()
                self._compare(before, stamps(out))
                before = stamps(out)
                process = start(self.jobs, out, *options)
            elif kind == "worker":
                if not (there := running(process.pid)):
                    continue
                with contextlib.suppress(ProcessLookupError):
                    os.kill(rng.choice(there), signal.SIGKILL)
            else:
                node = rng.choice([*cluster.worker_nodes])
                cluster.remove_node(node, allow_graceful=False)
                cluster.add_node(num_cpus=1)
            self.kills += 1
        if code != 0:
            raise RuntimeError((self.jobs.parent / "errors").read_text()[-2000:])
        self._compare(before, stamps(out))

    def _compare(self, before: dict[str, int], after: dict[str, int]) -> None:
        self.again += sum(after.get(name) != moment for name, moment in before.items())


def main() -> int:
    """Print how many kills there were, and what they did."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=["worker", "node", "driver"])
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--ray", action="store_true", help="on a cluster with two nodes")
    parser.add_argument("--jobs", type=int, default=24)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    if options.kind == "node" and not options.ray:
        parser.error("a node is one of a cluster: --ray")
    rng = random.Random(options.seed)
    with contextlib.ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="kills-")))
        films = [film(folder / "film.mp4", options.frames)]
        jobs = table(folder / "jobs.csv", films, options.jobs)
        cluster = stack.enter_context(ray_cluster(2)) if options.ray else None
        finish(jobs, folder / "whole", "--workers", "1")
        trial = Trial(jobs, results(folder / "whole"), cluster and cluster.address)
        seconds = {"worker": 1.0, "node": 6.0, "driver": 10.0 if options.ray else 3.0}
        while trial.kills < options.kills:
            trial.run(options.kind, options.kills, rng, seconds[options.kind], cluster)
    where = "on Ray" if options.ray else "processes of this machine"
    numbers = trial.kills, trial.different, trial.again
    row = Cell(f"{options.kind}, {where}"), *(Cell(f"{each}") for each in numbers)
    head = "killed", "kills", "results lost or different", "jobs done twice"
    print(markdown.table(Table("Batches that are killed", head, [row])))
    return 1 if trial.different or trial.again else 0


if __name__ == "__main__":
    sys.exit(main())
