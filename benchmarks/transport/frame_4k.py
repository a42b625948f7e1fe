"""A frame of 3840 × 2160 pixels in every mode, through the GL code of the window, and the memory of the device for it.

All show one mesh, the torus knot of 49,985 vertices, at the finest quality of the window: 2 × 2 samples in a pixel.
Maps, transport and light are noise of the sizes that captures and bakes have: what is in them changes no time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks.measure import Measure, best_of
from benchmarks.transport.frame import woven
from benchmarks.transport.transported import BRDF, gaussians, spherical_harmonics, wavelets
from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.gl.context import create_context, device_bytes, renderer_name
from engine.gl.scene_renderer import SceneRenderer
from engine.light.environment_file import open_environment
from engine.scene.material import Material
from engine.scene.scene import Scene, Source
from engine.shading.directional.interpolation import Kernel
from engine.shading.directional.planes import DirectionalMap
from engine.surface.pbr_maps import PbrMaps
from engine.transport.relight import RelightTransport

SIZE, SAMPLES = (3840, 2160), 2

#: Edge of all maps in texels; lamps and planes of a directional map.
EDGE, LAMPS, PLANES = 512, 64, 15


def _directional_map() -> Material:
    draw = np.random.default_rng(0)
    planes = draw.integers(0, 256, (PLANES, EDGE, EDGE), np.uint8)
    vectors = np.linalg.qr(draw.standard_normal((3 * LAMPS, PLANES)))[0]
    lights = draw.standard_normal((LAMPS, 3))
    lights = normalize(np.column_stack([lights[:, :2], np.abs(lights[:, 2]) + 0.2]))
    low, step, mean = np.full(PLANES, -50.0), np.full(PLANES, 0.4), np.full(3 * LAMPS, 100.0)
    found = DirectionalMap(planes, low, step, mean, vectors, lights, Kernel(0.6, 0.03), 0.5, 0.0, 0.0, 0.0)
    return Material(None, None, directional=found)


def _pbr_maps() -> Material:
    draw = np.random.default_rng(0)
    slopes = 0.3 * draw.standard_normal((EDGE, EDGE, 2))
    normal = normalize(np.concatenate([slopes, np.ones((EDGE, EDGE, 1))], axis=-1))
    colour = draw.random((EDGE, EDGE, 3), np.float32)
    roughness, metallic, f0 = draw.random((3, EDGE, EDGE), np.float32)
    return Material(None, None, pbr=PbrMaps(colour, normal.astype(np.float32), roughness, metallic, f0))


def _woven() -> Material:
    return woven(EDGE)


def _frame(
    name: str,
    material: Callable[[], Material] | None = None,
    source: Source = "slices",
    relit: Callable[[], RelightTransport] | None = None,
) -> Measure:
    """Seconds under one lamp, beside the plain Phong model; `sky_s` are those under 64 directions, where they cost."""
    mesh = shape("torus-knot")
    camera = frame(mesh.positions, SIZE[0] / SIZE[1])
    plain = Scene(mesh, camera, brdf_from_text("phong:exponent=20"))
    baked = relit() if relit is not None else None
    scene = Scene(baked.mesh if baked else mesh, camera, brdf_from_text(BRDF), relit=baked)
    if material is not None:
        scene = replace(scene, material=material(), source=source)
    limit_s, _, _ = _draw(plain)
    time_s, memory, device = _draw(scene)
    more: dict[str, Any] = {"device_mb": round(memory / 1e6, 1), "device": device}
    if baked is None or material is not None:
        more["sky_s"], _, _ = _draw(replace(scene, environment=open_environment("studio"), directions=64))
    return Measure(name, time_s, limit_s, "the same frame of the plain Phong model under one lamp", more)


def _draw(scene: Scene) -> tuple[float, int, str]:
    """Seconds of a frame of `scene`, the bytes that it holds, image included, and the name of the device."""
    with create_context() as context:
        renderer, target = SceneRenderer(context), context.framebuffer([context.renderbuffer(SIZE)])

        def draw() -> None:
            renderer.draw(scene, target, SIZE, samples=SAMPLES)
            context.finish()

        time_s = best_of(draw)
        found = time_s, device_bytes(context), renderer_name(context)
        renderer.release()
        target.release()
    context.release()
    return found


brdf = partial(_frame, "gl-4k-brdf")
power_law = partial(_frame, "gl-4k-power-law", _woven, "power-law")
shading_map = partial(_frame, "gl-4k-shading-map", _woven)
directional_map = partial(_frame, "gl-4k-directional-map", _directional_map)
pbr_maps = partial(_frame, "gl-4k-pbr-maps", _pbr_maps)
sh = partial(_frame, "gl-4k-sh", relit=spherical_harmonics)
wavelet = partial(_frame, "gl-4k-wavelet", relit=wavelets)
gaussian = partial(_frame, "gl-4k-gaussian", relit=gaussians)
sh_texels = partial(_frame, "gl-4k-sh-texels", _woven, relit=spherical_harmonics)
wavelet_texels = partial(_frame, "gl-4k-wavelet-texels", _woven, relit=wavelets)
gaussian_texels = partial(_frame, "gl-4k-gaussian-texels", _woven, relit=gaussians)
