"""Previews of the maps of a surface."""

from __future__ import annotations

import numpy as np

from engine.surface.write import preview


def test_the_preview_of_a_specular_is_in_srgb_codes() -> None:
    """0.04 of a dielectric is code 56 by the formula of sRGB, and not the 10 of a linear one."""
    assert preview("specular", np.array([[0.0, 0.04, 1.0]], np.float32)).tolist() == [[0, 56, 255]]
    assert preview("roughness", np.array([[0.0, 0.4, 1.0]], np.float32)).tolist() == [[0, 102, 255]]
