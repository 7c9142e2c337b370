"""The cores that this machine has for workers, as far as a container may use them."""

from __future__ import annotations

import math
import os
from pathlib import Path

CGROUP = Path("/sys/fs/cgroup")


def cores(cgroup: Path = CGROUP) -> int:
    """Return the number of cores that this process may use: its affinity, and its quota."""
    own = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    quota = _cpu_quota(cgroup)
    return own if quota is None else max(min(own, math.floor(quota)), 1)


def _cpu_quota(cgroup: Path) -> float | None:
    """Return the cores of the container's quota; None without one."""
    match _words(cgroup / "cpu.max"):  # version 2
        case [quota, period] if quota != "max":
            return int(quota) / int(period)
    old = [_words(cgroup / "cpu" / f"cpu.cfs_{name}_us") for name in ("quota", "period")]
    if all(old) and int(old[0][0]) > 0:  # version 1; -1 is no quota
        return int(old[0][0]) / int(old[1][0])
    return None


def _words(path: Path) -> list[str]:
    try:
        return path.read_text().split()
    except OSError:
        return []
