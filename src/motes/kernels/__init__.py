"""Every compiled loop, and nothing else: C++ in `*.hpp`, one file for each cue or step.

Each cue has its loops in a file of its own name; what several share is in `sampling`, `histograms`,
`gradients` and `bilinear`. A `*.pyi` file beside it has what Python may call. Kernels that read
pixels release the GIL; arrays must have the declared type and lie in C order. An ellipse is a row
x, y, a, b, theta. What `setup.py` builds of them is chosen here by the processor; results are the
same bits.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any


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


INSTRUCTIONS: str
"""Which processors the chosen kernels are compiled for."""

if TYPE_CHECKING:
    from motes.kernels import (
        bilinear,
        color,
        color_filter,
        color_posterior,
        components,
        cuts,
        fourier,
        fourier_ridge,
        fusion,
        ghosts,
        gradients,
        histograms,
        hog,
        illumination,
        localization,
        mixture,
        network_input,
        outlines,
        particles,
        planes,
        preview,
        ring,
        sampling,
        search_window,
        selective_update,
        sobel,
        structure_tensor,
        sway,
    )
else:
    _compiled = _extension()
    INSTRUCTIONS = _compiled.INSTRUCTIONS
    bilinear = _compiled.bilinear
    color = _compiled.color
    color_filter = _compiled.color_filter
    color_posterior = _compiled.color_posterior
    components = _compiled.components
    cuts = _compiled.cuts
    fourier = _compiled.fourier
    fourier_ridge = _compiled.fourier_ridge
    fusion = _compiled.fusion
    ghosts = _compiled.ghosts
    gradients = _compiled.gradients
    histograms = _compiled.histograms
    hog = _compiled.hog
    illumination = _compiled.illumination
    localization = _compiled.localization
    mixture = _compiled.mixture
    network_input = _compiled.network_input
    outlines = _compiled.outlines
    particles = _compiled.particles
    planes = _compiled.planes
    preview = _compiled.preview
    ring = _compiled.ring
    sampling = _compiled.sampling
    search_window = _compiled.search_window
    selective_update = _compiled.selective_update
    sobel = _compiled.sobel
    structure_tensor = _compiled.structure_tensor
    sway = _compiled.sway

__all__ = [
    "INSTRUCTIONS",
    "bilinear",
    "color",
    "color_filter",
    "color_posterior",
    "components",
    "cuts",
    "fourier",
    "fourier_ridge",
    "fusion",
    "ghosts",
    "gradients",
    "histograms",
    "hog",
    "illumination",
    "localization",
    "mixture",
    "network_input",
    "outlines",
    "particles",
    "planes",
    "preview",
    "ring",
    "sampling",
    "search_window",
    "selective_update",
    "sobel",
    "structure_tensor",
    "sway",
]
