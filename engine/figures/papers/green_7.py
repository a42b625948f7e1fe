"""Green2006 Figure 7: one Gaussian for each vertex and view against two."""

from __future__ import annotations

from engine.core.steps import Steps
from engine.figures.figure import Figure, Settings, coarse_bust
from engine.figures.papers.gaussian_lobes import Way, compare_ways
from engine.light.environment_file import open_environment

BRDF = "ggx:kd=0.3,alpha=0.2,f0=0.3"

WAYS = (Way("one lobe", {}, 1), Way("two lobes", {}, 2))


def green_7(settings: Settings) -> Steps[Figure]:
    """The two images and the reference."""
    environment = settings.environment or open_environment("studio")
    mesh = settings.mesh or coarse_bust(*((9, 13) if settings.quick else (33, 49)))
    row = yield from compare_ways(mesh, BRDF, environment, settings, WAYS)
    return Figure(
        "green-7",
        "One lobe against two",
        f"{mesh.name} of {len(mesh.positions):,} vertices under {environment.name}, after Green, Kautz, Matusik and "
        "Durand 2006, Figure 7; errors are relative RMSE against the reference",
        (row,),
    )
