"""Where the extra `studio` is not installed, its tests are not collected."""

from __future__ import annotations

from importlib.util import find_spec

needed = ("starlette", "uvicorn", "websockets", "httpx")
collect_ignore_glob = [] if all(map(find_spec, needed)) else ["*.py", "*/*.py"]
