"""Small captures under lamps all around, which the tests of directional maps share."""

from __future__ import annotations

from functools import cache

import numpy as np

from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE, srgb_decode, srgb_encode
from engine.core.steps import drain
from engine.scene.material import Material
from engine.shading.directional.planes import fit


def dome(count: int = 12, height: int = 7, width: int = 9, seed: int = 1) -> ImageStack:
    """Rough texels under lamps all around, as codes of 8 bits."""
    rng = np.random.default_rng(seed)
    azimuth = np.arange(count) * 2.4
    elevation = np.sort(rng.uniform(0.2, 1.4, count))
    light = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], 1)
    normal = rng.normal(size=(height, width, 3)) * 0.4 + (0.0, 0.0, 1.0)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    shaded = np.maximum(np.einsum("hwi,ni->nhw", normal, light), 0.02) ** 1.5
    radiance = shaded[..., None] * rng.uniform(0.2, 0.9, (height, width, 3))
    radiance = srgb_decode(np.rint(255.0 * srgb_encode(radiance)) / 255.0).astype(np.float32)
    return ImageStack(
        radiance=radiance,
        saturated=np.zeros(radiance.shape[:3], np.bool_),
        elevation=elevation,
        azimuth=np.asarray(azimuth, np.float64),
        mean_radiance=radiance.mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE,
        sources=tuple(map(str, range(count))),
        angle_source="lp",
    )


@cache
def dome_material(brdf: str = "lambert:albedo=0.5") -> Material:
    """The directional map of `dome`, with a BRDF."""
    stack = dome()
    count = len(stack.sources)
    return Material(None, None, brdf=brdf, directional=drain(fit(stack, np.arange(count))), name="dome")
