"""Green, Kautz, Matusik and Durand 2006, Figure 7: one Gaussian for each vertex and view against two."""

from __future__ import annotations

from engine.brdf.brdf import brdf_from_text
from engine.environment_file import open_environment
from engine.figures.figure import Figure, Settings, ShownRow, camera_of, coarse_bust, compared, truth_of
from engine.figures.gaussian_lobes import fitted, nearer_picture
from engine.scene import Scene
from engine.steps import Steps, part
from engine.transport.gaussian_samples import glossy_surface

BRDF = "ggx:kd=0.3,alpha=0.2,f0=0.3"

#: Share of the work that is done after each of the two fits: the second takes about twice as long.
SHARES = (0.1, 0.4, 1.0)


def green_7(settings: Settings) -> Steps[Figure]:
    """The two pictures and the reference."""
    environment = settings.environment or open_environment("studio")
    mesh = settings.mesh or coarse_bust(*((9, 13) if settings.quick else (33, 49)))
    brdf, camera = brdf_from_text(BRDF), camera_of(mesh, settings.size)
    truth = yield from part(truth_of(Scene(mesh, camera, brdf, environment=environment), settings), 0.0, 0.1)
    surface = glossy_surface(mesh, brdf)
    panels = []
    for number, words in enumerate(("one lobe", "two lobes")):
        start, stop = SHARES[number], SHARES[number + 1]
        own = yield from part(fitted(surface, number + 1, settings.directions), start, stop - 0.05)
        picture, knobs = yield from part(
            nearer_picture(own, environment, camera, settings.size, truth), stop - 0.05, stop
        )
        flips = own.fit.health.figures.get("flipped_pairs", 0.0)
        panels.append((words, {"lobes": number + 1, **knobs, "flipped_pairs": flips}, picture))
    return Figure(
        "green-7",
        "One lobe against two",
        f"{mesh.name} of {len(mesh.positions):,} vertices under {environment.name}, after Green, Kautz, Matusik and "
        "Durand 2006, Figure 7; errors are relative RMSE against the reference",
        (ShownRow(BRDF, compared(panels, truth, "reference")),),
    )
