"""Every compiled loop, and nothing else; imports numpy and numba only.

Each cue has its loops in a file of its own name; what several share is in `sampling`, `histograms`,
`gradients` and `bilinear`. Kernels that read pixels release the GIL; all allocate nothing inside
loops and know no Python objects. An ellipse is a row x, y, a, b, theta.
"""

from __future__ import annotations

from motes.kernels import (
    bilinear,
    color,
    color_posterior,
    compiling,
    fourier_ridge,
    gradients,
    histograms,
    hog,
    particles,
    sampling,
    search_window,
    sobel,
    structure_tensor,
)

__all__ = [
    "bilinear",
    "color",
    "color_posterior",
    "compiling",
    "fourier_ridge",
    "gradients",
    "histograms",
    "hog",
    "particles",
    "sampling",
    "search_window",
    "sobel",
    "structure_tensor",
]
