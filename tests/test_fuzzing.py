"""Damaged inputs of every kind: a short run, and all that ever made motes fall."""

from pathlib import Path

import pytest

from fuzzing.campaign import attempt, run
from fuzzing.kinds import KINDS

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
    films = {each for name in BY_NAME if name.startswith("film-") for each in result.counts[name]}
    assert films == {"whole", "part", "stopped", "refused"}
