"""Green, Kautz, Matusik and Durand 2006, Figure 6: lobes with visibility, and prefiltered light without.

Both are one Gaussian for each vertex and view of the 92. Without visibility highlights appear where something else
hides the light that makes them.
"""

from __future__ import annotations

from engine.brdf.brdf import brdf_from_text
from engine.environment_file import open_environment
from engine.figures.figure import Figure, Settings, ShownRow, camera_of, compared, truth_of
from engine.figures.gaussian_lobes import coarse_knot, fitted, nearer_picture, without_shadows
from engine.scene import Scene
from engine.steps import Steps, part
from engine.transport.gaussian_samples import glossy_surface

BRDF = "ggx:kd=0.1,alpha=0.2,f0=0.5"


def green_6(settings: Settings) -> Steps[Figure]:
    """The two pictures and the reference, which has shadows."""
    environment = settings.environment or open_environment("studio")
    mesh = settings.mesh or coarse_knot(*((8, 24) if settings.quick else (4, 6)))
    brdf, camera = brdf_from_text(BRDF), camera_of(mesh, settings.size)
    truth = yield from part(truth_of(Scene(mesh, camera, brdf, environment=environment), settings), 0.0, 0.1)
    surface = glossy_surface(mesh, brdf)
    panels = []
    for number, words in enumerate(("with visibility", "prefiltering without visibility")):
        start, stop = 0.1 + 0.45 * number, 0.55 + 0.45 * number
        seen = without_shadows(surface) if number else surface
        own = yield from part(fitted(seen, 1, settings.directions), start, stop - 0.05)
        picture, knobs = yield from part(
            nearer_picture(own, environment, camera, settings.size, truth), stop - 0.05, stop
        )
        panels.append((words, {"lobes": 1, "visibility": not number, **knobs}, picture))
    return Figure(
        "green-6",
        "Visibility in lobes",
        f"{mesh.name} of {len(mesh.positions):,} vertices under {environment.name}, after Green, Kautz, Matusik and "
        "Durand 2006, Figure 6; errors are relative RMSE against the reference",
        (ShownRow(BRDF, compared(panels, truth, "reference")),),
    )
