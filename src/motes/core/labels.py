"""The names of classes, which every format of files must be able to hold."""

from __future__ import annotations

import re
from functools import lru_cache

from motes.core.errors import ConfigError

_UNFIT = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")
"""Control characters and line breaks, halves of characters, and what is no character of XML."""


@lru_cache(1000)
def check_label(label: str) -> str:
    """Return the name of a class; raise a ConfigError if it is empty or has an unfit character.

    JSON Lines, XML, YAML and CSV cannot hold all characters, or readers take some for line breaks.
    """
    if found := _UNFIT.search(label):
        raise ConfigError(
            f"the class {label[:60]!r} has the character U+{ord(found[0]):04X}, which is none of a "
            f"name; rename it"
        )
    if not label.strip():
        raise ConfigError(f"the class {label!r} has no letters; rename it")
    return label
