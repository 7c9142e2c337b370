"""One cluster of Ray for all tests of this folder: two nodes with a core each."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="session")
def cluster() -> Iterator[Any]:
    """Give a cluster; its head does not work, so that any working node may die."""
    pytest.importorskip("ray", reason="ray is not installed: pip install 'motes[cluster]'")
    sys.path.insert(0, str(BENCHMARKS))
    from cluster_common import ray_cluster

    os.environ["RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO"] = "0"
    with ray_cluster(2) as started:
        yield started
