"""Green2006 Figure 6: lobes with visibility, and prefiltered light without.

Both are one Gaussian for each vertex and view of the 92. Without visibility highlights appear where something else
hides the light that makes them.
"""

from __future__ import annotations

from engine.core.steps import Steps
from engine.figures.figure import Figure, Settings
from engine.figures.papers.gaussian_lobes import Way, coarse_knot, compare_ways
from engine.light.environment_file import open_environment

BRDF = "ggx:kd=0.1,alpha=0.2,f0=0.5"

WAYS = (
    Way("with visibility", {"visibility": True}),
    Way("prefiltering without visibility", {"visibility": False}, shadows=False),
)


def green_6(settings: Settings) -> Steps[Figure]:
    """The two images and the reference, which has shadows."""
    environment = settings.environment or open_environment("studio")
    mesh = settings.mesh or coarse_knot(*((8, 24) if settings.quick else (4, 6)))
    row = yield from compare_ways(mesh, BRDF, environment, settings, WAYS)
    return Figure(
        "green-6",
        "Visibility in lobes",
        f"{mesh.name} of {len(mesh.positions):,} vertices under {environment.name}, after Green, Kautz, Matusik and "
        "Durand 2006, Figure 6; errors are relative RMSE against the reference",
        (row,),
    )
