"""`lightarc render` of a transport file with a material: its texels in the light that the bake finds."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from app.cli.transport.render_output import ON_PROCESSOR, off_screen
from engine.core.errors import UsageError
from engine.core.steps import Step, drain, part
from engine.transport import method as transport

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.geometry.camera import Camera
    from engine.scene.scene import Scene
    from engine.transport.relit import Light, Relit


def check(arguments: argparse.Namespace, method: transport.Method, light: Light) -> None:
    """UsageError for what a picture with texels cannot be of."""
    if not method.lights_texels:
        able = " or ".join(each.name for each in transport.methods_with("lights_texels"))
        raise UsageError(f"--material on a bake is for --mode {able}, and this is one of {method.name}")
    if light.near_lamps:
        raise UsageError("--material on a bake has distant lights only: --lamp in place of --near-lamp")
    if arguments.turntable:
        raise UsageError("--turntable of a bake shows its BRDF alone: leave --material out")


def with_texels(
    picture: NDArray[np.float32],
    relit: Relit,
    unshadowed: Relit,
    light: Light,
    camera: Camera,
    arguments: argparse.Namespace,
    show: Callable[[Step], None],
) -> tuple[NDArray[np.float32], dict[str, Any]]:
    """`picture`, which shows `relit`, with the texels of --material; and how these were drawn, for its record."""
    from engine.gl.draw import draw_off_screen, relit_off_screen
    from engine.render.direct import radiance
    from engine.render.shadowed import shadowed
    from engine.render.transported import picture_of

    scene, size, warnings = _scene(relit, light, camera, arguments), (arguments.width, arguments.height), list[str]()
    before = time.perf_counter()
    found = off_screen(
        arguments.renderer, lambda context: draw_off_screen(context, scene, size, arguments.samples), warnings
    )
    if found is not None:
        texels, device = found[0], found[1]["gl_renderer"]
        warnings = found[1]["warnings"]
        opened = off_screen(
            "gl", lambda context: relit_off_screen(context, unshadowed, camera, size, arguments.samples), warnings
        )
        assert opened is not None
        without = opened[0]
    else:
        device = ON_PROCESSOR
        texels = drain(part(radiance(scene, size, samples=arguments.samples), 0.5, 0.9), show)
        without = drain(part(picture_of(unshadowed, camera, size, arguments.samples), 0.9, 1.0), show).picture
    figures = {"texels_s": time.perf_counter() - before, "texels_renderer": device, "sigma": scene.sigma}
    return shadowed(texels, picture, without), {**figures, "warnings": warnings}


def _scene(relit: Relit, light: Light, camera: Camera, arguments: argparse.Namespace) -> Scene:
    """The model and ground of a bake as a scene of the material under the same light."""
    import numpy as np

    from engine.exchange.readers.read import open_material
    from engine.factor.factor_file import open_reflectance
    from engine.geometry.ground import Ground
    from engine.geometry.mesh import Mesh
    from engine.scene.scene import Scene

    both, first = relit.mesh, relit.transport.ground_vertex
    mesh, ground = both, None
    if first < len(both.positions):
        faces = both.faces[(both.faces < first).all(axis=1)]
        mesh = Mesh(both.positions[:first], both.normals[:first], both.uv[:first], faces, both.name, both.health)
        square = both.positions[first:]
        ground = Ground(
            height=float(square[0, 1]),
            albedo=relit.transport.ground_albedo,
            extent=float(np.ptp(square[:, 0]) / 2.0 / mesh.radius),
            cells=int(np.sqrt(len(square))) - 1,
        )
    material = open_material(arguments.material)
    return Scene(
        mesh,
        camera,
        open_reflectance(arguments.brdf) if arguments.brdf else material.reflectance,
        material,
        irradiance=light.factor if light.environment is not None else 0.0,
        source=arguments.source,
        lookup=arguments.lookup,
        above=arguments.above,
        repeats=arguments.tile,
        environment=light.environment,
        environment_rotation=light.rotation,
        directions=arguments.directions,
        lamps=light.lamps,
        ground=ground,
    )
