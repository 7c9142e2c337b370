"""`python -m motes_lab`, the same program as `motes-lab`."""

from __future__ import annotations

import sys

from motes_lab.start import main

if __name__ == "__main__":
    sys.exit(main())
