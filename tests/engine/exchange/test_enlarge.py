"""Larger tiles: they repeat at their border and not within, and keep histogram and brightness."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

import lightarc
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.enlarge import blend_tile, check_repeats, enlarge
from engine.render.direct import radiance
from engine.render.hex_tiling import cells_around
from engine.render.mip_maps import pbr_layers
from engine.scene.material import Material
from tests.engine.exchange.materials import measure_maps, woven_material
from tests.engine.render.test_hex_tiling import SIDE, correlation, far_scene, maps_of, material_of

REPEATS = 4


@pytest.mark.parametrize("period", [2, 3, 4, 7])
def test_cells_repeat_after_the_period_and_not_before(period: int) -> None:
    uv = np.random.default_rng(1).uniform(-3.0, 9.0, (2000, 2))
    weight, shift = cells_around(uv, (64, 48), period)
    for further in ((period, 0), (0, period), (-period, 2 * period)):
        again = cells_around(uv + further, (64, 48), period)
        np.testing.assert_allclose(again[0], weight, atol=1e-9)
        assert np.isclose(again[1], shift).all(axis=(1, 2)).mean() > 0.99  # the others lie on the sides of triangles
    for nearer in ((1, 0), (0, 1)):
        assert np.isclose(cells_around(uv + nearer, (64, 48), period)[1], shift).all(axis=(1, 2)).mean() < 0.01


@pytest.mark.parametrize("kind", ["woven", "hammered", "leather"])
def test_a_tile_has_the_histogram_of_its_maps_and_no_seam(kind: str) -> None:
    layers = pbr_layers(maps_of(kind))[:2]
    tile = drain(blend_tile(layers, REPEATS))
    for before, after in zip(
        np.moveaxis(layers, 3, 1).reshape(-1, SIDE, SIDE),
        np.moveaxis(tile, 3, 1).reshape(-1, 4 * SIDE, 4 * SIDE),
        strict=True,
    ):
        if np.ptp(before) < 1e-6:
            np.testing.assert_allclose(after, before[0, 0], atol=1e-6)
            continue
        assert abs(correlation(after.astype(np.float64).ravel(), REPEATS)) < 0.2
        bins = np.linspace(before.min() - 1e-6, before.max() + 1e-6, 65)
        shares = [np.histogram(np.clip(each, bins[0], bins[-1]), bins)[0] / each.size for each in (before, after)]
        assert np.abs(np.cumsum(shares[0] - shares[1])).mean() < 1e-3
        assert after.mean() == pytest.approx(before.mean(), rel=2e-3)
        for axis in (0, 1):
            within = np.abs(np.diff(after, axis=axis)).mean()
            border = np.abs(np.take(after, 0, axis) - np.take(after, -1, axis)).mean()
            assert border < 1.5 * within


@pytest.mark.parametrize("form", [pytest.param("power", marks=pytest.mark.long), "slices", "planes"])
def test_photographs_are_as_bright_in_a_larger_tile(form: str) -> None:
    material = material_of("hammered", form)
    larger = drain(enlarge(material, 2))
    assert larger.size == (2 * SIDE, 2 * SIDE)
    assert larger.surface is not None
    assert larger.surface.maps.size == larger.size
    for light in ((0.1, 0.2, 0.97), (-0.7, 0.6, 0.35)):
        one, other = (
            drain(radiance(far_scene(each, repeats, "grid", light), (61, 61), samples=2))[..., :3].mean(axis=(0, 1))
            for each, repeats in ((material, 32.0), (larger, 16.0))
        )
        np.testing.assert_allclose(other, one, rtol=0.03)


def test_all_pbr_maps_become_larger() -> None:
    maps = measure_maps()
    larger = drain(enlarge(Material(None, None, pbr=maps), 3)).pbr
    assert larger is not None
    for name in ("base_colour", "normal", "roughness", "metallic", "f0", "height", "occlusion"):
        before, after = getattr(maps, name), getattr(larger, name)
        assert (after is None) == (before is None)
        if before is not None:
            assert after.shape[:2] == (3 * before.shape[0], 3 * before.shape[1])
            assert after.min() >= before.min() - 1e-6 or name == "normal"
            assert after.mean() == pytest.approx(before.mean(), abs=0.1 * max(float(before.std()), 0.02))


def test_an_export_takes_the_larger_tile(tmp_path: Path) -> None:
    record = lightarc.export(woven_material(), tmp_path / "out", "textures", enlarge=2, width_mm=10.0)
    import cv2

    image = cv2.imread(str(next((tmp_path / "out").rglob("*ase*olor*.png"))))
    assert image is not None
    assert image.shape[:2] == (48, 40)
    assert record["targets"][0]["rmse_rel_reference"] is not None


def test_what_does_not_repeat_is_refused() -> None:
    material = woven_material()
    with pytest.raises(UsageError, match="1 × 1 repeats is not within 2 to 16"):
        check_repeats(material, 1)
    large = Material(None, None, pbr=maps_of("leather"))
    check_repeats(large, 16)
    masked = dataclasses.replace(material, mask=np.zeros(material.size, np.bool_))
    with pytest.raises(UsageError, match="an object with a mask does not repeat"):
        check_repeats(masked, 2)
