"""One pool or the other: the processes of this machine, or the workers of a named cluster."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, contextmanager

from motes_fleet.cluster import pool as pools
from motes_fleet.cluster.local_pool import LocalPool
from motes_fleet.cluster.on_ray import RayPool
from motes_fleet.cluster.ray_connection import connected


@contextmanager
def open_pool(
    cluster: str | None, workers: int, threads: int | None = None
) -> Iterator[pools.Pool]:
    """Give a pool, and close it at the end.

    Parameters
    ----------
    cluster
        The address of a cluster of Ray, or `auto`; None for processes of this machine.
    workers, threads
        Those of a `LocalPool`. On a cluster, its nodes know their cores.

    Raises
    ------
    ConfigError
        If the cluster cannot be reached.
    MissingDependencyError
        If Ray is not installed.
    """
    if cluster is None:
        with closing(LocalPool(workers, threads)) as local:
            yield local
    else:
        with connected(cluster, threads=threads or 1) as ray, closing(RayPool(ray)) as remote:
            yield remote
