"""`python -m motes`, the same program as `motes`."""

from __future__ import annotations

import sys

from motes.start import main

if __name__ == "__main__":
    sys.exit(main())
