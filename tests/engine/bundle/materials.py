"""A material of one power law, and the radiance that it shows."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.bundle.portable import resolve_sigma
from engine.core.colour import luminance
from engine.scene.material import Material
from engine.shading.power_law import PowerLawMap

SCALE, EXPONENT, R_MAX = (0.8, 0.4, 0.2), (0.5, 1.0, 2.5), 0.6


def make_material(height: int = 8, width: int = 8, **changes: Any) -> Material:
    law = PowerLawMap(
        scale=np.full((height, width, 3), SCALE, np.float32),
        exponent=np.full((height, width, 3), EXPONENT, np.float32),
        r_max=R_MAX,
        rms=0.01,
        rms_per_channel=np.full(3, 0.01),
        error_map=np.zeros((height, width), np.float32),
    )
    return dataclasses.replace(Material(None, law, elevation_deg=(10.0, 40.0, 70.0), name="woven"), **changes)


def compute_expected_radiance(material: Material, wi: Any, wo: Any) -> Any:
    r = resolve_sigma(material) * luminance(brdf_from_text(material.brdf).f(wi, wo)) * np.maximum(wi[..., 2], 0)
    return np.array(SCALE) * np.minimum(r / R_MAX, 1.0)[..., None] ** np.array(EXPONENT)
