"""What all tests share."""

from __future__ import annotations

import os
import signal
import sys
from collections import defaultdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

from motes.core.interrupts import SIGNALS

# Where the extra `studio` or the client of a browser is not installed, its tests are not collected.
needed = ("starlette", "uvicorn", "websockets", "httpx", "playwright", "axe_playwright_python")
collect_ignore_glob = [] if all(map(find_spec, needed)) else ["studio/tests/*"]

# A busy machine is no failure. The examples are the same each time; `make fuzz` looks for others.
settings.register_profile("motes", deadline=None, derandomize=True, max_examples=25)
settings.load_profile("motes")

# What is ignored stays so in programs that are started, which tests interrupt: SIGINT in background
# jobs of a shell, SIGHUP below nohup. A handler does not; and this one still ignores the signal.
for number in SIGNALS:
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, lambda *_: None)


# What a terminal, a user or a scheduler has set is none of the tests' business.
for name in ("COLUMNS", "LINES", "FORCE_COLOR", "NO_COLOR", "MOTES_DEBUG", "RAY_ADDRESS",
             "PYTHONIOENCODING", "PYTHONDONTWRITEBYTECODE"):  # fmt: skip
    os.environ.pop(name, None)
# Else each worker, and each program that tests start, compiles all modules anew: 13 s of a core.
sys.dont_write_bytecode = False
os.environ |= {"LC_ALL": "C.UTF-8", "TERM": "xterm"}
os.umask(0o022)
# Servers that tests start are on this machine; a proxy does not reach them.
os.environ["no_proxy"] = os.environ["NO_PROXY"] = "*"


TOOK: defaultdict[str, float] = defaultdict(float)
"""Seconds of each test of this run."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Return the cores, and one more where tests wait for a browser."""
    from motes_fleet.cluster.machine import cores

    return cores() + ("not browser" not in config.getoption("markexpr"))


TOGETHER = "fleet/tests/cluster"
"""A folder whose files share a cluster, which takes longer to start than a browser does."""


def shared(nodeid: str) -> str:
    """Return the file of a test, or its folder where files share what is costly."""
    return TOGETHER if nodeid.startswith(TOGETHER) else nodeid.partition("::")[0]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Give a worker that is free all tests that share fixtures, in the order of the items."""
    from xdist.scheduler import LoadFileScheduling  # type: ignore[import-untyped]

    config.option.loadscopereorder = False
    scheduling = LoadFileScheduling(config, log)
    scheduling._split_scope = shared
    return scheduling


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Mark what asks for a browser or a cluster; for workers, what took longest comes first."""
    cache = getattr(config, "cache", None)  # which `-p no:cacheprovider` takes away
    last = cache.get("motes/seconds", {}) if cache else {}
    seconds: defaultdict[str, float] = defaultdict(float)
    for item in items:
        for fixture, mark in (("browser", "browser"), ("cluster", "ray")):
            if fixture in getattr(item, "fixturenames", ()):
                item.add_marker(mark)
        marked = {"slow", "browser", "ray"} & {mark.name for mark in item.iter_markers()}
        seconds[shared(item.nodeid)] += last.get(item.nodeid, 1.0 if marked else 0.02)
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: -seconds[shared(item.nodeid)])


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note how long a test takes, with what it shares."""
    TOOK[report.nodeid] += report.duration


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep it for the next run."""
    cache = getattr(session.config, "cache", None)
    if cache and not hasattr(session.config, "workerinput"):
        cache.set("motes/seconds", cache.get("motes/seconds", {}) | TOOK)


@pytest.fixture(scope="session")
def data() -> Path:
    """Return the folder of real sequences: MOTES_DATA, or ../shared/data beside the repository."""
    default = Path(__file__).resolve().parents[1] / "shared" / "data"
    folder = Path(os.environ.get("MOTES_DATA") or default)
    if not folder.is_dir():
        pytest.skip(f"no real data in {folder}; name its folder with MOTES_DATA")
    return folder


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return an empty folder, which is the current one."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
