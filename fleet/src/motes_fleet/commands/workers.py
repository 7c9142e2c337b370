"""The options for where jobs run: processes of this machine, or a cluster."""

from typing import Annotated

from cyclopts import Group, Parameter

from motes import ConfigError
from motes.cli import Whole, check_counts

RUN = Group("Run", sort_key=2)
Workers = Annotated[
    Whole | None, Parameter(group=RUN, help="Number of processes; by default one for each core.")
]
Cluster = Annotated[
    str | None,
    Parameter(
        group=RUN,
        help="Run on a cluster of Ray instead of the processes of this machine: auto for the one "
        "that this machine belongs to, or HOST:PORT of its head.",
    ),
]


def check_run(workers: int | None, time_limit: float, **counts: int) -> None:
    """Check the numbers of a run of jobs; raise a ConfigError for one that makes no sense."""
    check_counts(workers=1 if workers is None else workers, **counts)
    if not 0 < time_limit < float("inf"):
        raise ConfigError(f"--time-limit is {time_limit:g}; give a number of seconds.")
