"""Text and JSON from files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec

from motes.core.errors import FormatError


def read_text(path: Path) -> str:
    """Return the text of a file; raise an OSError or a FormatError if it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise FormatError(f"{path.name} is not text; save it as UTF-8") from None


def read_json(path: Path, kind: Any) -> Any:
    """Return the content of a JSON file as a type of msgspec; raise as `read_text` does."""
    try:
        return msgspec.json.decode(read_text(path), type=kind)
    except (msgspec.MsgspecError, RecursionError) as error:
        raise FormatError(f"{path.name}: {error}") from None
