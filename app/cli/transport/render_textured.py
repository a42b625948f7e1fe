"""`lightarc render` of a bake with a material: its texels in the light that the bake finds."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from app.cli.transport.render_output import ON_CPU, off_screen
from engine.brdf.brdf import brdf_from_text
from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.core.steps import Step, drain, part
from engine.exchange.readers.read import open_material
from engine.factor.factor_file import open_reflectance
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.gl.draw import draw_off_screen
from engine.render.direct import radiance
from engine.render.shadowed import combine_shadowed, with_and_without
from engine.scene.scene import Scene
from engine.scene.settings import DEFAULTS as scene_defaults
from engine.transport.baking.parts import parts_in

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from engine.brdf.brdf import Brdf
    from engine.geometry.camera import Camera
    from engine.gl.context import Context
    from engine.gl.draw import OffScreen
    from engine.transport.baking.file import TransportFile
    from engine.transport.relight import Light, RelightTransport

#: Light of texels under a bake, over that without shadows, from which on the bake must be wrong.
MAX_EXCESS = 1.1


def with_texels(
    baked: tuple[NDArray[np.float32], dict[str, Any]],
    scene: Scene,
    arguments: argparse.Namespace,
    show: Callable[[Step], None],
    brdf: Brdf | None = None,
    *,
    reflects: bool = False,
) -> tuple[NDArray[np.float32], dict[str, Any]]:
    """The image of the bake of `scene`, and its record, with the texels of the material where that has any.

    `brdf` was baked, that of the scene where not given; `reflects` tells of light between parts of the model in the
    bake, without which texels are no brighter than without shadows. `frame_s` is then that of all three images that
    texels take.
    """
    if not scene.has_texels:
        return baked
    (image, record), size = baked, (arguments.width, arguments.height)
    frame_s, device, warnings, drawn = record["frame_s"], ON_CPU, list(record["warnings"]), []
    for at, each in enumerate(with_and_without(scene, brdf)):

        def on_device(context: Context, each: Scene = each) -> OffScreen:
            return draw_off_screen(context, each, size, arguments.samples)

        found = off_screen(arguments.renderer, on_device, [])
        if found is None:
            begun, steps = time.perf_counter(), radiance(each, size, samples=arguments.samples)
            drawn.append(drain(part(steps, 0.4 + 0.3 * at, 0.7 + 0.3 * at), show))
            frame_s += time.perf_counter() - begun
        else:
            drawn.append(found[0])
            device = found[1]["gl_renderer"]
            frame_s += found[1]["frame_s"]
            warnings += found[1]["warnings"]
    shown = combine_shadowed(drawn[0], drawn[1], image)
    if not reflects:
        warnings += doubts_of_texels(shown, drawn[0])
    figures = {"frame_s": frame_s, "texels_renderer": device, "sigma": scene.sigma}
    return shown, {**record, **figures, "warnings": list(dict.fromkeys(warnings))}


def doubts_of_texels(shown: NDArray[np.float32], unshadowed: NDArray[np.float32]) -> list[str]:
    """A sentence where texels in the light of a bake are brighter than without any shadow, which shadows forbid."""
    total, most = (float(np.sum(image[..., :3], dtype=np.float64)) for image in (shown, unshadowed))
    if total <= MAX_EXCESS * most:
        return []
    more = percent(total / most - 1.0) if most > 0.0 else "many times"
    return [
        f"the texels are {more} brighter in the light of this bake than without its shadows: it blurs highlights that "
        "the texels spread once more; bake with more terms or a higher order, or choose --mode direct"
    ]


def brdf_of_bake(file: TransportFile, arguments: argparse.Namespace) -> tuple[Brdf | None, list[str]]:
    """The BRDF that an image of the bake is of: --brdf, or the one in the file.

    None where parts have their own, or it is not a model, which a sentence says.
    """
    if arguments.brdf:
        return open_reflectance(arguments.brdf), []
    if "part_names" in file.settings:
        return None, []
    name = str(file.settings.get("brdf", ""))
    try:
        return brdf_from_text(name), []
    except UsageError:
        return None, [f"The bake is of {name or 'a BRDF without a name'}, which is taken to be that of the material"]


def scene_of_bake(
    file: TransportFile, relit: RelightTransport, light: Light, camera: Camera, arguments: argparse.Namespace
) -> Scene:
    """The model and ground of a bake as a scene of the material under the same light."""
    both, first = relit.mesh, relit.transport.ground_vertex
    mesh, ground = both, None
    if first < len(both.positions):
        faces = both.faces[(both.faces < first).all(axis=1)]
        mesh = Mesh(
            both.positions[:first], both.normals[:first], both.uv[:first], faces, both.name, both.health, both.brushing
        )
        square = both.positions[first:]
        ground = Ground(
            height=float(square[0, 1]),
            albedo=relit.transport.ground_albedo,
            extent=float(np.ptp(square[:, 0]) / 2.0 / mesh.radius),
            cells=int(np.sqrt(len(square))) - 1,
        )
    mesh = _with_parts(mesh, file, first)
    material = open_material(arguments.material, parts=True, search=arguments.search)
    return Scene(
        mesh,
        camera,
        open_reflectance(arguments.brdf) if arguments.brdf else material.reflectance,
        material,
        irradiance=light.factor if light.environment is not None else 0.0,
        source=arguments.source,
        lookup=arguments.lookup,
        above=arguments.above,
        repeats=arguments.tile or (scene_defaults.repeats if mesh.part is None else 1.0),
        tiling_mode=arguments.tiling_mode,
        environment=light.environment,
        environment_rotation=light.rotation,
        directions=arguments.directions,
        lamps=light.lamps,
        near_lamps=light.near_lamps,
        ground=ground,
    )


def _with_parts(mesh: Mesh, file: TransportFile, first: int) -> Mesh:
    """The model of a bake with the parts that its file names."""
    parts = parts_in(file, first)
    if parts is None:
        return mesh
    part = np.ascontiguousarray(parts.part[mesh.faces[:, 0]])
    return replace(mesh, part=part, part_names=parts.names, colours=parts.colours)
