"""The option for the number of processes."""

from typing import Annotated

from cyclopts import Parameter

from motes import ConfigError
from motes.cli import RUN
from motes_fleet.cluster.machine import cores

Workers = Annotated[
    int | None, Parameter(group=RUN, help="Number of processes; by default one for each core.")
]


def worker_count(workers: int | None) -> int:
    """Return the number of processes; raise a ConfigError if --workers is below 1."""
    if workers is not None and workers < 1:
        raise ConfigError(f"--workers is {workers}; give 1 or more.")
    return workers or cores()
