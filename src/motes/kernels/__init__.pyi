"""Every compiled loop, and which processors the chosen ones are compiled for."""

from . import (
    bilinear as bilinear,
    color as color,
    color_filter as color_filter,
    color_posterior as color_posterior,
    components as components,
    cuts as cuts,
    fourier as fourier,
    fourier_ridge as fourier_ridge,
    fusion as fusion,
    ghosts as ghosts,
    gradients as gradients,
    histograms as histograms,
    hog as hog,
    illumination as illumination,
    localization as localization,
    mixture as mixture,
    network_input as network_input,
    outlines as outlines,
    particles as particles,
    planes as planes,
    preview as preview,
    ring as ring,
    sampling as sampling,
    search_window as search_window,
    selective_update as selective_update,
    sobel as sobel,
    structure_tensor as structure_tensor,
    sway as sway,
)

INSTRUCTIONS: str
__all__: list[str]
