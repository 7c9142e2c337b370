"""The connection to a cluster of Ray: its address, and one line if it cannot be reached."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from motes import ConfigError
from motes.core import optional, thread_limits

CURRENT = Path("/tmp/ray/ray_current_cluster")
"""The file in which `ray start` notes the address of the cluster on this machine."""
PATIENCE = 5.0
"""Seconds for an address to answer. Ray itself would try for more than a minute."""


@contextlib.contextmanager
def connected(address: str, *, threads: int = 1) -> Iterator[Any]:
    """Connect to a cluster, and give the module `ray`; disconnect at the end.

    Parameters
    ----------
    address
        `auto` for the cluster that this machine belongs to, or HOST:PORT of its head.
    threads
        Threads that libraries may start in a worker.

    Raises
    ------
    ConfigError
        If the cluster cannot be reached.
    MissingDependencyError
        If Ray is not installed.
    """
    need = "--cluster needs Ray (without it, the processes of this machine are used)"
    ray, goal = optional("ray", need, "motes-fleet[ray]"), _answering(address)
    # Standard output is for rows. Ray prints there what it repeats, and has no option for it.
    ray._private.worker.print_to_stdstream = _no_print
    before = signal.getsignal(signal.SIGTERM)
    try:
        ray.init(
            address=goal,
            log_to_driver=False,
            logging_level="ERROR",
            namespace="motes",
            runtime_env={"env_vars": thread_limits(threads)},
        )
    except (OSError, RuntimeError, ValueError, SystemExit, ray.exceptions.RayError) as error:
        raise _unreachable(address, " ".join(str(error).split())) from None
    finally:
        # Ray ends the program at SIGTERM; a run of motes ends in its own order.
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, before)
    try:
        yield ray
    finally:
        ray.shutdown()


def _no_print(*_: object, **__: object) -> None:
    """Print nothing."""


def _answering(address: str) -> str:
    """Return the address for Ray, once something listens there."""
    goal = address
    if address == "auto":
        noted = CURRENT.read_text().strip() if CURRENT.exists() else ""
        goal = os.environ.get("RAY_ADDRESS") or noted
        if not goal:
            raise _unreachable(address, "no cluster runs on this machine (ray start --head)")
    try:
        parts = urlsplit(goal if "://" in goal else f"ray://{goal}")
        host, port = parts.hostname, parts.port
    except ValueError:
        host = port = None
    if not host or port is None:
        raise ConfigError(f"--cluster takes auto or HOST:PORT; got {address!r}.")
    try:
        socket.create_connection((host, port), PATIENCE).close()
    except OSError as error:
        raise _unreachable(address, f"{goal}: {error.strerror or error}") from None
    return goal


def _unreachable(address: str, why: str) -> ConfigError:
    return ConfigError(
        f"The cluster {address} cannot be reached ({why}). Start it, correct --cluster, or omit "
        f"it: then the processes of this machine are used."
    )
