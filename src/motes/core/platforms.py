"""What motes asks of the operating system, beyond what Python has for all of them."""

import sys

if sys.platform == "win32":
    from motes.core import windows as system
else:
    from motes.core import posix as system

__all__ = ["system"]
