"""Wang2004 Figure 3: coefficients kept for each vertex against the sharpness of shadows on a ground.

Without a map of the user's the light is a small bright disc in a dim sky, which casts a shadow that is sharp at the
foot of the model and soft further away. It stays in the map: as a lamp beside it, it would need no coefficients.
"""

from __future__ import annotations

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import world_direction
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, part
from engine.figures.figure import Figure, Settings, ShownRow, compare_with, error_curve, reference_of
from engine.figures.papers.vertex_images import view_of
from engine.figures.papers.wavelet_rays import Kept, bake_together
from engine.figures.plot import curves
from engine.geometry.camera import Camera, frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap, texel_directions
from engine.scene.scene import Scene
from engine.transport.wavelet.bake import factors_for
from engine.transport.wavelet.lighting import lighting_of
from engine.transport.wavelet.transfer import relight_transport, sum_signed_radiance

BRDF = "lambert:albedo=0.5"

#: Coefficients kept, of 24,576; the paper's are about 0.1 to 1.6 %.
COEFFICIENTS = (24, 48, 96, 200, 400)

#: The disc of the light: where it is in degrees, its angular radius, and its radiance in a sky of 1.
THETA_DEG, PHI_DEG, RADIUS_DEG, BRIGHT = 50.0, -60.0, 6.0, 250.0


def wang_3(settings: Settings) -> Steps[Figure]:
    """The sweep of coefficients, of model and ground."""
    environment = settings.environment or disc_sky()
    ground = Ground(extent=2.5, cells=12 if settings.quick else 96)
    mesh, brdf = settings.model, brdf_from_text(BRDF)
    camera = _camera(mesh, settings)
    scene = Scene(mesh, camera, brdf, environment=environment, ground=ground)
    expected = yield from part(reference_of(scene, settings), 0.0, 0.15)
    factors = yield from part(factors_for(brdf, 1), 0.15, 0.2)
    sweep = COEFFICIENTS[:3] if settings.quick else COEFFICIENTS
    kept = [Kept(factors, coefficients) for coefficients in sweep]
    surface, first = scene.surface, len(mesh.positions)
    baked = yield from part(bake_together(surface, first, ground.albedo, settings.edge, kept), 0.2, 0.95)
    light = lighting_of(environment, settings.edge, split=False).light
    view = view_of(surface, camera, settings.size)
    panels, everything = [], np.arange(len(surface.positions))
    for transport, coefficients in zip(baked, sweep, strict=True):
        rows = relight_transport(transport, light)
        value = sum_signed_radiance(transport, rows, view.local(transport.frames), everything)
        share = 100.0 * coefficients / (6 * settings.edge**2)
        parameters = {"coefficients": coefficients, "cube": settings.edge, "share_percent": share}
        panels.append((f"N = {coefficients} ({percent(share / 100.0, 3)})", parameters, view.image(value)))
        yield Step(0.95 + 0.05 * len(panels) / len(sweep), "drawing")
    images = compare_with(panels, expected, "reference")
    plot = curves(
        [error_curve("", sweep, images)],
        "Coefficients kept for each vertex",
        "Relative RMSE of the image in %",
        title="Coefficients against the sharpness of shadows",
        log_x=True,
        y_from_zero=True,
    )
    return Figure(
        "wang-3",
        "Coefficients against the sharpness of shadows",
        f"{mesh.name} of {first:,} vertices on a ground of {len(surface.positions) - first:,} under "
        f"{environment.name}, after Wang, Tran and Luebke 2004, Figure 3; "
        "errors are relative RMSE against the reference",
        (ShownRow(f"{BRDF} on a ground", images),),
        {"errors": plot},
    )


def disc_sky() -> EnvironmentMap:
    """A dim sky with one small disc in it."""
    towards = texel_directions(256, 512) @ world_direction(np.radians(THETA_DEG), np.radians(PHI_DEG))
    inside = towards > np.cos(np.radians(RADIUS_DEG))
    radiance = np.where(inside[..., None], BRIGHT, (0.8, 0.95, 1.2))
    return EnvironmentMap(radiance.astype(np.float32), f"a disc of {RADIUS_DEG:g}° radius in a dim sky")


def _camera(mesh: Mesh, settings: Settings) -> Camera:
    """From above, with the shadow in the image."""
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    radius = float(np.linalg.norm(high - low)) / 2.0
    foot = np.array([(low[0] + high[0]) / 2.0, low[1], (low[2] + high[2]) / 2.0])
    beside = foot + radius * np.array([(1.7, 0.0, -0.6), (1.2, 0.0, 0.6), (-0.5, 0.0, 0.7)])
    direction = world_direction(np.radians(55.0), np.radians(20.0))
    return frame(np.concatenate([mesh.positions, beside]), settings.size[0] / settings.size[1], direction=direction)
