"""Every compiled loop, and nothing else: C++ in `*.hpp`, one file for each cue or step.

Each cue has its loops in a file of its own name; what several share is in `sampling`, `histograms`,
`gradients` and `bilinear`. A `*.pyi` file beside it has what Python may call; `__init__.pyi` lists
them. Kernels that read pixels release the GIL; arrays must have the declared type and lie in C
order. An ellipse is a row x, y, a, b, theta. What `setup.py` builds of them is chosen here by the
processor; results are the same bits.
"""

from __future__ import annotations

import importlib
from typing import Any


def _extension() -> Any:
    """Return the extension for this processor."""
    try:
        baseline = importlib.import_module("motes.kernels._baseline")
        return importlib.import_module("motes.kernels._avx2") if baseline.has_avx2() else baseline
    except ImportError as error:
        raise ImportError(
            f"motes' kernels are not compiled ({error}): run `pip install --editable .` where its "
            "sources are, or `pip install motes` anew"
        ) from error


_compiled = {name: each for name, each in vars(_extension()).items() if not name.startswith("_")}
globals().update(_compiled)
__all__ = [*_compiled]
