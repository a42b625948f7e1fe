"""Small materials and scenes that the tests of both renderers share."""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.core.colour import luminance
from engine.geometry.camera import Camera, frame
from engine.geometry.shapes import shape
from engine.scene.material import Material
from engine.scene.scene import Scene
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap


def weave(size: int = 64, slices: int = 8, threads: int = 8) -> Material:
    """A coloured weave that is an exact power law, so both of its forms are one function at the slices."""
    y, x = np.mgrid[:size, :size] / size
    height = 0.5 + 0.5 * np.sin(2 * np.pi * threads * x) * np.sin(2 * np.pi * threads * y)
    exponent = np.repeat((1.6 - height)[..., None], 3, axis=-1)
    scale = (0.3 + 0.7 * height)[..., None] * (0.3, 0.45, 0.8)
    share = np.linspace(0.0, 1.0, slices)[:, None, None, None]
    images = np.where(share > 0, scale * share**exponent, 0.0).astype(np.float32)
    means = luminance(images).mean(axis=(1, 2), dtype=np.float64)
    r_max = float(means[-1])
    zeros = np.zeros((size, size), np.float32)
    power_law = PowerLawMap(scale.astype("f4"), exponent.astype("f4"), r_max, 0.0, np.zeros(3), zeros)
    elevation_deg = tuple(float(angle) for angle in range(10, 100, 10))
    return Material(ShadingMap(images, r_max, means), power_law, elevation_deg=elevation_deg)


def scene(
    model: str = "sphere", material: Material | None = None, brdf: str = "phong:exponent=20", **options: Any
) -> Scene:
    mesh = shape(model)
    return Scene(mesh, frame(mesh.positions, 4 / 3), brdf_from_text(brdf), material, **options)


def head_on(material: Material | None = None, brdf: str = "lambert:albedo=0.5", **options: Any) -> Scene:
    """The plane seen from its normal, lit from its normal, larger than the image."""
    camera = Camera((0.0, 0.0, 2.0), fov_deg=20.0)
    return Scene(shape("plane"), camera, brdf_from_text(brdf), material, light=(0.0, 0.0, 1.0), **options)
