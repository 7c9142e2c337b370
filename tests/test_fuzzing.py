"""Damaged inputs of every kind: a short run, and all that ever made motes fall."""

from __future__ import annotations

import os
from collections import Counter
from functools import partial
from pathlib import Path
from random import Random

import pytest

from fuzzing.__main__ import table
from fuzzing.campaign import Failure, Kind, Result, attempt, run
from fuzzing.kinds import KINDS
from fuzzing.mutator import CHANGES, MOST, Change
from motes_lab.report import markdown

CORPUS = Path(__file__).parent / "fuzzing" / "corpus"
BY_NAME = {kind.name: kind for kind in KINDS}


@pytest.mark.parametrize(
    "path", sorted(CORPUS.glob("*/*")), ids=lambda path: f"{path.parent.name}-{path.name}"
)
def test_what_once_fell_falls_no_more(path: Path) -> None:
    outcome, reason = attempt(BY_NAME[path.parent.name], path.read_bytes())
    assert not reason
    assert outcome


@pytest.mark.slow
def test_a_short_run() -> None:
    result = run(KINDS, seed=0, more=lambda rounds: rounds < 1)
    assert [failure.reason for failure in result.failures] == []
    assert set(result.counts) == set(BY_NAME)
    for name, counter in result.counts.items():
        assert counter.total() == BY_NAME[name].block
        # A kind that reads nothing, or refuses nothing, tests nothing.
        assert len(counter) > 1 or counter.total() < 50


# The run itself


def _check(data: bytes) -> str:
    match data:
        case b"crash":
            os.abort()
        case b"loop":
            while True:
                pass
        case b"greedy":
            return str(len(bytes(1 << 40)))
        case b"wrong":
            raise ValueError("This is wrong.")
    return data.decode()


@pytest.mark.slow
def test_what_falls_is_found_and_the_rest_is_done() -> None:
    reasons = {
        b"crash": "The process ended with -6.",
        b"loop": "It takes too long.",
        b"greedy": "MemoryError",
        b"wrong": "ValueError: This is wrong.",
    }
    seeds = [b"read", b"wrong", b"crash", b"read", b"loop", b"greedy", b"refused"]
    kind = Kind("toy", partial(list, seeds), _check, block=len(seeds), limit=0.2)
    told: list[Failure] = []
    result = run([kind], 0, lambda rounds: rounds < 1, told.append)
    assert result.counts == {"toy": {"read": 2, "fell": 4, "refused": 1}}
    fallen = {each.data: each for each in result.failures}
    assert {data: each.number for data, each in fallen.items()} == {
        data: seeds.index(data) for data in reasons
    }
    for data, reason in reasons.items():
        assert reason in fallen[data].reason
    assert told == result.failures


def test_the_table_counts_what_came_of_all_inputs() -> None:
    counts = {"toy": Counter(read=1200, fell=1), "other": Counter(refused=3)}
    lines = markdown.table(table(Result(counts=counts))).splitlines()
    assert lines[2:] == [
        "| input | inputs | read | refused | fell |",
        "| --- | --- | --- | --- | --- |",
        "| toy | 1,201 | 1,200 | 0 | 1 |",
        "| other | 3 | 0 | 3 | 0 |",
        "| all | 1,204 | 1,200 | 3 | 1 |",
    ]


def test_the_same_seed_gives_the_same_inputs() -> None:
    kind = BY_NAME["zones"]
    seeds = kind.seeds()
    inputs = [kind.input(3, number, seeds) for number in range(50)]
    assert [kind.input(3, number, seeds) for number in range(50)] == inputs
    assert inputs[: len(seeds)] == seeds
    assert len(set(inputs)) > 40
    assert [kind.input(4, number, seeds) for number in range(50)] != inputs


@pytest.mark.parametrize("change", dict.fromkeys(CHANGES), ids=lambda change: change.__name__)
@pytest.mark.parametrize("seed", [b"", b"a = 1\nb = [2, 3]\n"])
def test_every_change_takes_what_there_is(change: Change, seed: bytes) -> None:
    changed = {change(Random(number), seed, [seed]) for number in range(20)}
    assert changed != {seed} or not seed
    assert max(map(len, changed)) < 2 * MOST
