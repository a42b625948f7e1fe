"""Materials for the tests of exports."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.capture.stack import ImageStack
from engine.core.steps import drain
from engine.exchange.pbr_from_material import cavity, nearest_maps
from engine.exchange.subject import Subject
from engine.scene.material import Material
from engine.shading.directional.planes import fit
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.surface.pbr_maps import ObservedSlopes, PbrMaps

R_MAX = 1000.0


def linear_material(tint: Any, brdf: str, *, height: int = 6, width: int = 5, slices: int = 4) -> Material:
    """S(r) = tint r up to R_MAX, beyond which no BRDF of the tests goes, and sigma 1: tint f cos."""
    share = np.linspace(0.0, R_MAX, slices)[:, None, None, None]
    values = np.broadcast_to(share * np.asarray(tint), (slices, height, width, 3)).astype(np.float32)
    means = values.mean(axis=(1, 2, 3)).astype(np.float64)
    return Material(ShadingMap(values, R_MAX, means), None, brdf=brdf, sigma=1.0, name="linear")


def woven_law(height: int = 24, width: int = 20) -> PowerLawMap:
    """A power law of colours and exponents that differ from texel to texel."""
    rng = np.random.default_rng(7)
    return PowerLawMap(
        scale=rng.uniform(0.05, 0.6, (height, width, 3)).astype(np.float32),
        exponent=rng.uniform(0.4, 2.0, (height, width, 3)).astype(np.float32),
        r_max=0.3,
        rms=0.01,
        rms_per_channel=np.full(3, 0.01),
        error_map=np.zeros((height, width), np.float32),
    )


def woven_material(height: int = 24, width: int = 20) -> Material:
    law = woven_law(height, width)
    return Material(None, law, brdf="phong:exponent=20", elevation_deg=(10.0, 45.0, 80.0), name="A cloth, woven")


def dome_stack(height: int = 8, width: int = 6) -> ImageStack:
    """A flat diffuse surface of two halves, 0.24 and 0.12 times the cosine, under 24 lamps all around."""
    elevation = np.radians(np.repeat((25.0, 50.0, 80.0), 8))
    azimuth = np.tile(np.arange(8) * (0.25 * np.pi), 3)
    level = np.full((height, width, 3), (0.24, 0.18, 0.12), np.float32)
    level[:, width // 2 :] *= 0.5
    radiance = (np.sin(elevation)[:, None, None, None] * level).astype(np.float32)
    return ImageStack(
        radiance=radiance,
        saturated=np.zeros(radiance.shape[:3], np.bool_),
        elevation=elevation,
        azimuth=azimuth,
        mean_radiance=radiance.mean(axis=(1, 2)) @ np.array((0.2126390, 0.7151687, 0.0721923)),
        sources=tuple(f"{place:02d}" for place in range(24)),
        angle_source="lp",
    )


def dome_material(height: int = 8, width: int = 6) -> Material:
    found = drain(fit(dome_stack(height, width), np.arange(24)))
    return Material(None, None, brdf="lambert", name="dome", directional=found)


def woven_subject() -> Subject:
    material = woven_material()
    maps, white = drain(nearest_maps(material))
    return Subject(material, maps, white, cavity(material))


def measure_maps(height: int = 12, width: int = 10) -> PbrMaps:
    """Maps with everything in them, as a dome of lamps gives them."""
    rng = np.random.default_rng(3)
    normal = rng.normal(size=(height, width, 3)) * (0.3, 0.3, 0.0) + (0.0, 0.0, 1.0)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return PbrMaps(
        base_colour=rng.uniform(0.0, 1.0, (height, width, 3)).astype(np.float32),
        normal=normal.astype(np.float32),
        roughness=rng.uniform(0.1, 1.0, (height, width)).astype(np.float32),
        metallic=rng.uniform(0.0, 1.0, (height, width)).astype(np.float32),
        f0=np.full((height, width), 0.06, np.float32),
        height=rng.normal(size=(height, width)).astype(np.float32),
        occlusion=rng.uniform(0.2, 1.0, (height, width)).astype(np.float32),
        observed=ObservedSlopes("both"),
    )


def measure_subject() -> Subject:
    return Subject(woven_material(12, 10), measure_maps(), cavity=cavity(woven_material(12, 10)))
