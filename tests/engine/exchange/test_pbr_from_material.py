"""The maps nearest to a material: exact where the material is one of theirs, and never worse than others elsewhere."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange import loss, pbr_from_material
from engine.exchange.pbr_from_material import ROUGHEST_METAL, ROUGHNESSES, Family, cavity, nearest_maps
from engine.scene.material import Material
from engine.shading.mixed import keep_tiles
from engine.shading.power_law import fit
from engine.surface.pbr_maps import PbrMaps
from tests.engine.shading.test_mixed import make_patched_map

from .materials import R_MAX, dome_material, dome_stack, linear_material, woven_law, woven_material

FINE = ROUGHNESSES[8]


@pytest.mark.parametrize("metallic", [0.0, 1.0])
def test_a_material_that_is_metallic_roughness_is_found(metallic: float) -> None:
    """S(r) = π r with the model itself: base colour, roughness and metallic come back."""
    brdf = f"metallic-roughness:base_color=0.5,metallic={metallic},roughness={FINE}"
    maps, _ = drain(nearest_maps(linear_material((np.pi, np.pi, np.pi), brdf), white=1.0))
    assert maps.metallic == pytest.approx(metallic)
    assert maps.roughness == pytest.approx(FINE)
    assert maps.base_colour == pytest.approx(0.5, abs=1e-5)
    assert maps.observed.kind == "none"
    assert (maps.normal == (0.0, 0.0, 1.0)).all()


def test_a_diffuse_material_has_its_albedo() -> None:
    """Without a highlight to speak of, base colour is nearly π S / cos: 0.96 of it is not reflected by the surface."""
    colour = np.pi * np.array((1.0, 0.5, 0.25))
    maps, _ = drain(nearest_maps(linear_material(colour, "lambert:albedo=0.6"), white=1.0))
    assert maps.metallic.max() == 0.0
    ratio = maps.base_colour[0, 0] / maps.base_colour[0, 0, 0]
    assert ratio == pytest.approx((1.0, 0.5, 0.25), abs=0.06)
    assert 0.45 < maps.base_colour[0, 0, 0] < 0.65


def test_no_other_maps_are_nearer() -> None:
    """Any change of the maps makes images under light from all sides worse: the minimum is one."""
    material = woven_material()
    maps, white = drain(nearest_maps(material))
    view, lights = loss.sphere(24, 20, 48), loss.environment_lights("overcast")
    wanted = loss.material_shown(material)(view, lights)

    def total(changed: PbrMaps) -> float:
        return float(np.sum((loss.maps_shown(changed, np.pi * white)(view, lights) - wanted) ** 2))

    least = total(maps)
    for changed in (
        dataclasses.replace(maps, base_colour=np.clip(1.25 * maps.base_colour, 0.0, 1.0)),
        dataclasses.replace(maps, base_colour=(0.8 * maps.base_colour)),
        dataclasses.replace(maps, roughness=np.clip(maps.roughness + 0.2, 0.0, 1.0)),
        dataclasses.replace(maps, base_colour=np.ascontiguousarray(maps.base_colour[::-1])),
    ):
        assert total(changed) > least


def test_the_best_of_all_choices_is_found() -> None:
    """Base colour, roughness and error of texels of noise are those of least squares over the pairs themselves."""
    draw = np.random.default_rng(1)
    layers, pairs = draw.uniform(0.0, 1.0, (4, 3, 200, 3)), 30
    hats, a, b = draw.uniform(size=(4, pairs)), draw.uniform(size=(5, pairs)), draw.uniform(size=(5, pairs)) - 0.5
    products = np.stack([(a * a).sum(1), (a * b).sum(1), (b * b).sum(1)])
    family = Family(0.0, np.linspace(0.1, 0.5, 5), hats @ a.T, hats @ b.T, products)
    base, roughness, error = family.fit(layers)

    shown = np.tensordot(layers, hats, axes=(0, 0))
    along_a = np.einsum("kijcm,km->kijc", shown - b[:, None, None, None], a)
    best = np.clip(along_a / products[0, :, None, None, None], 0.0, 1.0)
    drawn = best[..., None] * a[:, None, None, None] + b[:, None, None, None]
    errors = np.sum((drawn - shown) ** 2, axis=(3, 4)) - np.sum(shown**2, axis=(2, 3))
    chosen = errors.argmin(axis=0)
    np.testing.assert_array_equal(roughness, family.roughness[chosen])
    np.testing.assert_allclose(error, errors.min(axis=0), atol=1e-9)
    np.testing.assert_allclose(base, np.take_along_axis(best, chosen[None, ..., None], 0)[0], atol=1e-12)


def test_slices_and_power_law_agree_where_they_are_one() -> None:
    """An exponent of 1 is linear in r, as two slices are."""
    slices = linear_material((0.5, 0.25, 0.125), "phong:exponent=20", slices=2)
    law = dataclasses.replace(
        woven_law(6, 5),
        scale=np.broadcast_to(np.array((0.5, 0.25, 0.125)) * R_MAX, (6, 5, 3)).astype(np.float32),
        exponent=np.ones((6, 5, 3), np.float32),
        r_max=R_MAX,
    )
    one, _ = drain(nearest_maps(slices, white=1.0))
    bare = dataclasses.replace(slices, shading_map=None, power_law=law)
    other, _ = drain(nearest_maps(bare, white=1.0))
    np.testing.assert_allclose(one.base_colour, other.base_colour, atol=1e-6)
    np.testing.assert_array_equal(one.roughness, other.roughness)


def test_a_directional_map_has_the_albedo_of_its_photographs() -> None:
    """A texel of k cos beside a white card of cos has the albedo k, with the highlight of f0 = 0.04."""
    material = dome_material()
    maps, white = drain(nearest_maps(material))
    assert maps.size == (8, 6)
    assert white == 1.0
    wanted = np.array((0.24, 0.18, 0.12))
    np.testing.assert_allclose(maps.base_colour[:, :3].mean(axis=(0, 1)), wanted, atol=0.02)
    np.testing.assert_allclose(maps.base_colour[:, 3:].mean(axis=(0, 1)), 0.5 * wanted, atol=0.02)
    assert drain(loss.photograph_error(loss.material_shown(material), dome_stack())) < 0.03
    assert drain(loss.photograph_error(loss.maps_shown(maps, np.pi), dome_stack())) < 0.15


@pytest.mark.parametrize("kind", ["slices", "power law", "kept tiles", "planes"])
def test_maps_are_the_same_in_tiles_of_any_size(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if kind == "planes":
        material = dome_material(37, 45)
    else:
        slices = make_patched_map()
        law = drain(fit(slices))
        form = drain(keep_tiles(law, slices, 0.02, 16)) if kind == "kept tiles" else law
        assert (form.kept is not None) == (kind == "kept tiles")
        plain = dataclasses.replace(woven_material(37, 45), shading_map=None, power_law=form)
        material = dataclasses.replace(plain, shading_map=slices, power_law=None) if kind == "slices" else plain
    whole, _ = drain(nearest_maps(material))
    for tile in (1, 17 * 7, 17 * 100):
        monkeypatch.setattr(pbr_from_material, "TILE", tile)
        in_tiles, _ = drain(nearest_maps(material))
        np.testing.assert_array_equal(in_tiles.base_colour, whole.base_colour)
        np.testing.assert_array_equal(in_tiles.roughness, whole.roughness)


def test_cavity_is_the_integral_that_it_stands_for() -> None:
    law = dataclasses.replace(woven_law(3, 2), exponent=np.full((3, 2, 3), 2.5, np.float32))
    material = dataclasses.replace(woven_material(3, 2), power_law=law)
    cosine = (np.arange(100_000) + 0.5) / 100_000
    shown = 2.0 * np.pi * np.mean(cosine**2.5) / np.pi
    found = cavity(material)
    assert found is not None
    assert found == pytest.approx(shown, rel=1e-4)


def test_a_white_card_is_as_bright_as_the_brightest_texels() -> None:
    law = woven_law()
    bright = dataclasses.replace(law, scale=10.0 * law.scale)
    maps, white = drain(nearest_maps(dataclasses.replace(woven_material(), power_law=bright)))
    assert white == pytest.approx(float(np.quantile(bright.scale, 0.999)), rel=0.05)
    tenth, _ = drain(nearest_maps(woven_material(), white=0.1 * white))
    np.testing.assert_allclose(maps.base_colour, tenth.base_colour, rtol=1e-4)
    assert (maps.roughness == tenth.roughness).all()


def test_no_maps_are_a_rough_metal_which_others_draw_brighter() -> None:
    """Programs that add light between facets agree with the maps where these are no rough metal."""
    rough = "metallic-roughness:base_color=0.5,metallic=1,roughness=0.9"
    maps, _ = drain(nearest_maps(linear_material((np.pi, np.pi, np.pi), rough), white=1.0))
    assert not (maps.metallic * (maps.roughness > ROUGHEST_METAL)).any()


def test_a_material_without_maps_is_refused() -> None:
    with pytest.raises(UsageError, match="neither"):
        drain(nearest_maps(Material(None, None)))
