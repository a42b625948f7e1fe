"""Every figure of the papers: the function that computes it, and what it shows."""

from __future__ import annotations

#: Name of a figure, the function that makes it, and what it shows.
FIGURES = {
    "shading-map-1": ("engine.figures.papers.shading_maps:shading_map_table", "errors of the power law"),
    "shading-map-6": ("engine.figures.papers.shading_maps:shading_map_lookups", "four look-ups of a shading map"),
    "kautz-6": ("engine.figures.papers.kautz_6:kautz_6", "order of spherical harmonics against glossiness"),
    "kautz-7": ("engine.figures.papers.kautz_7:kautz_7", "an anisotropic BRDF brushed in several directions"),
    "wang-2": ("engine.figures.papers.wang_2:wang_2", "terms of a factored BRDF against the analytic model"),
    "wang-3": ("engine.figures.papers.wang_3:wang_3", "wavelet coefficients against the sharpness of shadows"),
    "wang-4": ("engine.figures.papers.wang_4:wang_4", "BRDFs as sums of products, with their RMS curves"),
    "wang-5": ("engine.figures.papers.wang_2:wang_5", "one term over several maps of the hemisphere"),
    "green-5": ("engine.figures.papers.green_5:green_5", "Gaussians, wavelets and spherical harmonics of equal size"),
    "green-6": ("engine.figures.papers.green_6:green_6", "lobes with visibility and prefiltered light without"),
    "green-7": ("engine.figures.papers.green_7:green_7", "one lobe against two"),
}
