"""A cluster of Ray on this machine, for all tests of a process: to start it takes long."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

HEAD = {"num_cpus": 1, "include_dashboard": False, "include_log_monitor": False, "no_monitor": True}
"""Nobody reads the logs of workers, or waits for nodes that a cloud adds."""
QUICK = {
    "health_check_initial_delay_ms": 1000,
    "health_check_period_ms": 1000,
    "memory_monitor_refresh_ms": 0,
    "worker_niceness": 0,
}
"""Nodes that died are noticed after seconds, not after a quarter of a minute. Workers do not wait
for other processes of this machine, and do not end for their memory."""


@pytest.fixture(scope="package")
def cluster() -> Iterator[Any]:
    """Give a cluster of a head, which works as well."""
    pytest.importorskip("ray", reason="a cluster needs ray: pip install 'motes-fleet[ray]'")
    from ray.cluster_utils import Cluster

    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO", "0")
        patch.setenv("RAY_raylet_start_wait_time_s", "600")  # on a busy machine it may take long
        here = str(Path(__file__).parents[1])  # workers find what tests bring, and this motes
        patch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [here, *sys.path])))
        made = Cluster(initialize_head=True, head_node_args=HEAD | {"_system_config": QUICK})
        try:
            yield made
        finally:
            made.shutdown()
