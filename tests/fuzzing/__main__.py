"""Hand damaged inputs to motes, for a while or for some rounds, and keep those that make it fall.

PYTHONPATH=tests python -m fuzzing --seconds 60 --seed 0
PYTHONPATH=tests python -m fuzzing --again fuzz/trackers-123 --kind trackers
"""

import argparse
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable
from fnmatch import fnmatchcase
from pathlib import Path

from motes_lab.report import markdown
from motes_lab.report.tables import Cell, Row, Table

from .campaign import Failure, Kind, Result, attempt, guard, run
from .kinds import KINDS


def main() -> int:
    """Run as the options say; return 1 if anything fell."""
    parser = argparse.ArgumentParser(prog="python -m fuzzing", description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="how long")
    parser.add_argument("--rounds", type=int, help="instead: a block of each kind in each")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--kind", action="append", help="only these, as in 'film-*'; again for each"
    )
    parser.add_argument("--out", type=Path, default=Path("fuzz"), help="folder for what falls")
    parser.add_argument("--again", type=Path, help="repeat one input, with --kind")
    options = parser.parse_args()
    patterns = options.kind or ["*"]
    kinds = [kind for kind in KINDS if any(fnmatchcase(kind.name, each) for each in patterns)]
    if not kinds or (options.again and len(kinds) != 1):
        parser.error(f"--kind is one of {', '.join(kind.name for kind in KINDS)}")
    if options.again:
        return repeat(kinds[0], options.again)

    def save(failure: Failure) -> None:
        options.out.mkdir(parents=True, exist_ok=True)
        path = options.out / f"{failure.kind}-{options.seed}-{failure.number}"
        path.write_bytes(failure.data)
        last = failure.reason.strip().splitlines()[-1]
        print(f"{path}: {last[:300]}\n  PYTHONPATH=tests {sys.executable} -m fuzzing "
              f"--kind {failure.kind} --again {path}", flush=True)  # fmt: skip

    result = run(kinds, options.seed, _until(options.rounds, options.seconds), save)
    print(markdown.table(table(result)))
    return 1 if result.failures else 0


def table(result: Result) -> Table:
    """Return how often each came of the inputs of the kinds that begin alike, as `film-a`."""
    groups = defaultdict[str, Counter[str]](Counter)
    for name, counts in result.counts.items():
        groups[name.partition("-")[0]] += counts
    every = sum(groups.values(), Counter[str]())
    outcomes = [*sorted({*every} - {"fell"}), "fell"]

    def row(name: str, counts: Counter[str]) -> Row:
        numbers = counts.total(), *(counts[each] for each in outcomes)
        return Cell(name), *(Cell(f"{each:,}") for each in numbers)

    rows = [row(name, counts) for name, counts in groups.items()]
    return Table("Damaged inputs", ("input", "inputs", *outcomes), rows, (row("all", every),))


def _until(rounds: int | None, seconds: float) -> Callable[[int], bool]:
    """Return whether there is more to do, after so many rounds."""
    if rounds is not None:
        return lambda done: done < rounds
    end = time.monotonic() + seconds
    return lambda done: time.monotonic() < end


def repeat(kind: Kind, path: Path) -> int:
    """Hand one input to motes, and tell what comes of it."""
    guard()
    outcome, reason = attempt(kind, path.read_bytes())
    print(reason or outcome)
    return 1 if reason else 0


if __name__ == "__main__":
    sys.exit(main())
