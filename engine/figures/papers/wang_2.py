"""Wang2004 Figure 2: terms of an anisotropic BRDF against the model itself, under one lamp.

The light is one direction, so wavelets have no part in it: what differs is the BRDF alone.
"""

from __future__ import annotations

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import world_direction
from engine.core.steps import Step, Steps, part
from engine.figures.figure import Figure, Settings, ShownRow, camera_of, compare_with, error_curve, reference_of
from engine.figures.papers.vertex_images import view_of
from engine.figures.papers.wavelet_rays import without_vectors
from engine.figures.plot import curves
from engine.geometry.shapes import shape
from engine.light.lamps import Lamp, lights_of_all
from engine.scene.scene import Scene
from engine.transport.wavelet.bake import factors_for
from engine.transport.wavelet.lighting import lamp_tuples
from engine.transport.wavelet.transfer import sum_signed_radiance

BRDF = "ashikhmin-shirley:kd=0.3,ks=0.3,nu=10,nv=60"

TERMS = (1, 2, 4, 8, 16)

#: Direction of the lamp, in degrees from above and towards the right, and its irradiance.
THETA_DEG, PHI_DEG, IRRADIANCE = 55.0, -35.0, 3.0


def wang_2(settings: Settings) -> Steps[Figure]:
    """The sweep of terms; the rightmost image is the analytic model."""
    brdf = brdf_from_text(BRDF)
    mesh = settings.mesh or (settings.model if settings.quick else shape("blob"))
    light = world_direction(np.radians(THETA_DEG), np.radians(PHI_DEG))
    camera = camera_of(mesh, settings.size)
    x, y, z = light
    scene = Scene(mesh, camera, brdf, light=(x, y, z), irradiance=IRRADIANCE)
    expected = yield from part(reference_of(scene, settings), 0.0, 0.3)
    lamp = lights_of_all([Lamp((x, y, z), (IRRADIANCE,) * 3)])
    view, everything = view_of(mesh, camera, settings.size), np.arange(len(mesh.positions))
    most = 4 if settings.quick else TERMS[-1]
    factors = yield from part(factors_for(brdf, most), 0.3, 0.5)
    panels = []
    for number, terms in enumerate(term for term in TERMS if term <= most):
        transport = without_vectors(mesh, factors.truncate(terms))
        rows = lamp_tuples(transport, lamp)
        value = sum_signed_radiance(transport, rows, view.local(transport.frames), everything)
        panels.append((f"K = {terms}", {"terms": terms}, view.image(value)))
        yield Step(0.5 + 0.1 * (number + 1), "drawing")
    images = compare_with(panels, expected, "analytic model")
    line = error_curve("", [parameters["terms"] for _, parameters, _ in panels], images)
    label, title = "Relative RMSE of the image in %", "Terms against the analytic model"
    plot = curves([line], "Terms", label, title=title, y_from_zero=True)
    return Figure(
        "wang-2",
        "Terms of the reflectance",
        f"{mesh.name} under one distant lamp, after Wang, Tran and Luebke 2004, Figure 2; K terms; errors are relative "
        "RMSE against the reference",
        (ShownRow(f"{BRDF}, one lamp", images),),
        {"errors": plot},
    )
