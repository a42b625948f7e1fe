"""The small image of a material in a list of files."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from engine.bundle.bundle import BELOW_WHITE, SIDE, swatch
from engine.core.colour import srgb_decode
from engine.images.png import read_png
from engine.scene.material import Material, material_of_maps
from tests.engine.exchange.materials import dome_material, linear_material, measure_maps, woven_material


def test_it_has_the_hue_of_the_material_and_fills_the_range() -> None:
    """A uniform material is its own tint, scaled so that its brightest channel is white."""
    tint = np.array((0.2, 0.1, 0.05))
    codes = read_png(swatch(linear_material(tint, "lambert")), "swatch.png").samples
    np.testing.assert_allclose(srgb_decode(codes[3, 3] / 255.0), tint / tint.max(), atol=0.01)
    assert BELOW_WHITE < 1.0


def test_every_form_of_a_material_has_one() -> None:
    for material in (woven_material(24, 20), dome_material(8, 6)):
        codes = read_png(swatch(material), "swatch.png").samples
        assert codes.max() > 200
    halves = codes[:, :3].mean() / codes[:, 3:].mean()
    assert halves > 1.2  # the left half of the dome's sample is twice as bright
    with pytest.raises(ValueError, match="without maps"):
        swatch(Material(None, None, brdf="lambert"))


def test_maps_that_are_small_enough_are_shown_whole() -> None:
    law = woven_material(24, 20).power_law
    assert law is not None
    assert read_png(swatch(Material(None, law, brdf="lambert")), "swatch.png").samples.shape[:2] == law.error_map.shape
    maps = measure_maps()
    assert read_png(swatch(material_of_maps(maps, "maps")), "swatch.png").samples.shape[:2] == maps.size


def test_large_maps_are_thinned() -> None:
    law = woven_material(6, 5).power_law
    assert law is not None
    scale, exponent = (np.tile(values, (1, 200, 1)) for values in (law.scale, law.exponent))
    wide = dataclasses.replace(law, scale=scale, exponent=exponent, error_map=np.tile(law.error_map, (1, 200)))
    codes = read_png(swatch(Material(None, wide, brdf="lambert")), "swatch.png").samples
    assert SIDE // 2 < codes.shape[1] <= SIDE
