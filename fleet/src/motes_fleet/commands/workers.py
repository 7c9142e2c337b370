"""The options for where jobs run: processes of this machine, or a cluster."""

from typing import Annotated

from cyclopts import Group, Parameter

from motes import ConfigError
from motes_fleet.cluster.machine import cores

RUN = Group("Run", sort_key=2)
Workers = Annotated[
    int | None, Parameter(group=RUN, help="Number of processes; by default one for each core.")
]
Cluster = Annotated[
    str | None,
    Parameter(
        group=RUN,
        help="Run on a cluster of Ray instead of the processes of this machine: auto for the one "
        "that this machine belongs to, or HOST:PORT of its head.",
    ),
]


def worker_count(workers: int | None) -> int:
    """Return the number of processes; raise a ConfigError if --workers is below 1."""
    if workers is not None and workers < 1:
        raise ConfigError(f"--workers is {workers}; give 1 or more.")
    return workers or cores()
