"""Runs over damaged inputs: in a process of their own, as one may crash, hang or eat all memory.

Input number n of a kind is a function of the seed, the kind and n, whatever ran before, so that
what fell can be made once more. The inputs are done in blocks; when the process dies in one, the
input that it was at has failed, and another process does the rest of the block.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import resource
import signal
import tempfile
import traceback
import warnings
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from ctypes import c_int64
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from random import Random
from typing import Any

from .mutator import mutate

HUNG = 60.0
"""Seconds after which a process that is still at the same input is ended."""
MEMORY = 1 << 31
"""Bytes that an input may take."""
INPUT = "input"
"""The file that holds the input at which the process is."""


@dataclass(frozen=True)
class Kind:
    """A kind of input.

    Attributes
    ----------
    name
        Also of its folder in the corpus.
    seeds
        Returns valid inputs.
    check
        Hands an input to motes and returns what came of it in a word, such as `read` or `refused`;
        raises whatever must not be.
    block
        So many inputs are done in a round: fewer of what takes long.
    limit
        Seconds of computing that an input may take.
    mutate
        Makes an input from the seeds.
    """

    name: str
    seeds: Callable[[], list[bytes]]
    check: Callable[[bytes], str]
    block: int = 50
    limit: float = 10.0
    mutate: Callable[[Random, Sequence[bytes]], bytes] = mutate

    def input(self, seed: int, number: int, seeds: Sequence[bytes]) -> bytes:
        """Return input `number`, made from these seeds; the first ones are the seeds themselves."""
        if number < len(seeds):
            return seeds[number]
        return self.mutate(Random(f"{seed} {self.name} {number}"), seeds)


@dataclass(frozen=True)
class Failure:
    """An input that was neither read nor refused."""

    kind: str
    number: int
    data: bytes
    reason: str


@dataclass
class Result:
    """What came of a run: outcomes by kind, and what failed."""

    counts: dict[str, Counter[str]] = field(default_factory=dict)
    failures: list[Failure] = field(default_factory=list)

    @property
    def inputs(self) -> int:
        """How many there were."""
        return sum(counter.total() for counter in self.counts.values())


def run(
    kinds: Sequence[Kind],
    seed: int,
    more: Callable[[int], bool],
    failed: Callable[[Failure], None] = lambda failure: None,
) -> Result:
    """Do a block of each kind in turn, round by round, while there are `more` of them.

    `more` is asked before each block with the number of whole rounds so far; `failed` takes each
    failure at once.
    """
    result = Result({kind.name: Counter() for kind in kinds})
    worker: _Worker | None = None
    # Here are the files of all processes, so that those of ended ones vanish as well.
    scratch = tempfile.TemporaryDirectory(prefix="fuzz-")
    try:
        for which, first, count in _blocks(kinds, more):
            parts = deque([(first, count)])
            while parts:
                first, count = parts.popleft()
                worker = worker or _Worker(kinds, seed, scratch.name)
                outcomes, failures, broken = worker.do(which, first, count)
                if broken is not None:
                    number, reason = broken
                    worker = None
                    data = Path(scratch.name, INPUT).read_bytes()
                    failures = [Failure(kinds[which].name, number, data, reason)]
                    # What was good before it is done again, to be counted.
                    rest = [(first, number - first), (number + 1, first + count - number - 1)]
                    parts.extendleft(part for part in reversed(rest) if part[1])
                result.counts[kinds[which].name] += outcomes
                result.counts[kinds[which].name].update({"fell": len(failures)} if failures else {})
                result.failures += failures
                for failure in failures:
                    failed(failure)
    finally:
        if worker is not None:
            worker.end()
        scratch.cleanup()
    return result


def _blocks(kinds: Sequence[Kind], more: Callable[[int], bool]) -> Iterator[tuple[int, int, int]]:
    """Yield kind, first number and count of blocks."""
    done = 0
    while True:
        for which, kind in enumerate(kinds):
            if not more(done):
                return
            yield which, done * kind.block, kind.block
        done += 1


class _Worker:
    """A process that does blocks."""

    def __init__(self, kinds: Sequence[Kind], seed: int, scratch: str) -> None:
        context = multiprocessing.get_context("spawn")
        self._at = context.RawValue(c_int64, -1)
        self._pipe, theirs = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(theirs, self._at, kinds, seed, scratch)
        )
        self._process.start()
        theirs.close()

    def do(
        self, which: int, first: int, count: int
    ) -> tuple[Counter[str], list[Failure], tuple[int, str] | None]:
        """Return the outcomes of a block, and its failures; or at which input it broke, and how."""
        self._at.value = first
        with contextlib.suppress(OSError):
            self._pipe.send((which, first, count))
        before = -1
        while True:
            if wait([self._pipe, self._process.sentinel], HUNG):
                try:
                    outcomes, failures = self._pipe.recv()
                    return outcomes, failures, None
                except (EOFError, OSError):
                    self._process.join()
                    reason = f"The process ended with {self._process.exitcode}."
                    return Counter(), [], (self._at.value, reason)
            elif self._at.value == before:
                self.end()
                return Counter(), [], (before, f"It took more than {HUNG:g} s.")
            before = self._at.value

    def end(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()
        self._pipe.close()


# In the process


def _serve(pipe: Connection, at: Any, kinds: Sequence[Kind], seed: int, scratch: str) -> None:
    """Do blocks as they come."""
    tempfile.tempdir, current = scratch, Path(scratch, INPUT)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who started it
    guard()
    with contextlib.suppress(EOFError):
        while True:
            which, first, count = pipe.recv()
            kind, outcomes, failures = kinds[which], Counter[str](), []
            seeds = kind.seeds()
            for number in range(first, first + count):
                data = kind.input(seed, number, seeds)
                current.write_bytes(data)
                at.value = number
                outcome, reason = attempt(kind, data)
                if reason:
                    failures.append(Failure(kind.name, number, data, reason))
                else:
                    outcomes[outcome] += 1
            pipe.send((outcomes, failures))


def guard() -> None:
    """Make errors of warnings, and of too much memory, in this process."""
    warnings.simplefilter("error")
    if "ASAN_OPTIONS" in os.environ:
        return  # the sanitizer's shadow takes more than there is
    with open("/proc/self/statm") as file:
        used = int(file.read().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, resource.RLIM_INFINITY))


def attempt(kind: Kind, data: bytes) -> tuple[str, str]:
    """Return what came of an input, and the reason if that must not be."""
    signal.signal(signal.SIGVTALRM, _too_slow)
    signal.setitimer(signal.ITIMER_VIRTUAL, kind.limit)
    try:
        return kind.check(data), ""
    except BaseException:
        return "", traceback.format_exc()
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)


class Slow(BaseException):
    """Raised in what takes too long; no `Exception`, so that nobody catches it on the way."""


def _too_slow(*_: object) -> None:
    raise Slow("It takes too long.")
