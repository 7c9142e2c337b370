"""Runs over damaged inputs: in a process of their own, as one may crash, hang or eat all memory.

Input number n of a kind is a function of the seed, the kind and n, whatever ran before, so that
what fell can be made once more. When the process ends at an input, that one has failed, and
another process does the rest.
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
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from random import Random

from .mutator import mutate

HUNG = 300.0
"""Seconds after which a process that is still at the same input is ended, on a busy machine too."""
MEMORY = 1 << 31
"""Bytes that an input may take."""


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

    def inputs(self, seed: int, done: int) -> Iterator[tuple[int, bytes]]:
        """Yield the inputs of a round by their numbers; the first ones are the seeds themselves."""
        seeds = self.seeds()
        for number in range(done * self.block, (done + 1) * self.block):
            rng = Random(f"{seed} {self.name} {number}")
            yield number, seeds[number] if number < len(seeds) else self.mutate(rng, seeds)


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

    counts: dict[str, Counter[str]]
    failures: list[Failure] = field(default_factory=list)


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
    result, done = Result({kind.name: Counter() for kind in kinds}), 0
    # Here are the files of all processes, so that those of ended ones vanish as well.
    with tempfile.TemporaryDirectory(prefix="fuzz-") as scratch, _Worker(kinds, scratch) as worker:
        while True:
            for which, kind in enumerate(kinds):
                if not more(done):
                    return result
                for number, data in kind.inputs(seed, done):
                    outcome, reason = worker.attempt(which, data)
                    result.counts[kind.name][outcome or "fell"] += 1
                    if reason:
                        result.failures.append(Failure(kind.name, number, data, reason))
                        failed(result.failures[-1])
            done += 1


class _Worker:
    """A process that hands inputs to motes, and another one when that has ended."""

    def __init__(self, kinds: Sequence[Kind], scratch: str) -> None:
        self._kinds, self._scratch = kinds, scratch

    def __enter__(self) -> _Worker:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        given = theirs, self._kinds, self._scratch
        self._process = context.Process(target=_serve, args=given)
        self._process.start()
        theirs.close()
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.join()
        self._pipe.close()

    def attempt(self, which: int, data: bytes) -> tuple[str, str]:
        """Return what `attempt` does, or how the process has ended."""
        self._pipe.send((which, data))
        reason = f"It took more than {HUNG:g} s."
        if wait([self._pipe, self._process.sentinel], HUNG):
            with contextlib.suppress(EOFError, OSError):
                outcome, reason = self._pipe.recv()
                return outcome, reason
            self._process.join()
            reason = f"The process ended with {self._process.exitcode}."
        self.__exit__()
        self.__enter__()
        return "", reason


# In the process


def _serve(pipe: Connection, kinds: Sequence[Kind], scratch: str) -> None:
    """Take inputs as they come."""
    tempfile.tempdir = scratch
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for who started it
    guard()
    with contextlib.suppress(EOFError):
        while True:
            which, data = pipe.recv()
            pipe.send(attempt(kinds[which], data))


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
