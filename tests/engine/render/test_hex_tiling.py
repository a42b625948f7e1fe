"""Maps in hexagonal cells: no period, the histogram and the moments of the maps, from near and from afar."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE, srgb_decode, srgb_encode
from engine.core.directions import surface_direction
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.shapes import shape
from engine.images.decode import read_image
from engine.render.direct import radiance
from engine.render.hex_tiling import cells_around, grid_tiles, hash_cells, hex_tiles, values_at
from engine.render.pbr import Texels, texels_at
from engine.render.reference import reference
from engine.scene.material import Material
from engine.scene.scene import Scene, make_scene
from engine.shading.directional.planes import fit
from engine.shading.power_law import fit as fit_power_law
from engine.shading.shading_map import ShadingMap, build
from engine.simulate.height_fields import sample
from engine.surface.pbr_maps import PbrMaps
from tests.engine.render.test_pbr import bumpy, scene_of, square

SIDE = 64


def maps_of(kind: str) -> PbrMaps:
    """A sample of the simulator as maps."""
    made = sample(kind, SIDE)
    plane = (SIDE, SIDE)
    down, right = (0.5 * (np.roll(made.height, -1, axis) - np.roll(made.height, 1, axis)) for axis in (0, 1))
    normal = np.dstack([-right, down, np.ones(plane)])
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    albedo, roughness = (np.asarray(each, np.float64) for each in (made.albedo, made.roughness))
    metallic = (made.height > np.median(made.height)).astype(np.float32)
    f0 = np.full(plane, 0.04, np.float32)
    base = np.broadcast_to(albedo, (*plane, 3)) if albedo.ndim == 3 else np.repeat(albedo[..., None], 3, axis=2)
    rough = np.broadcast_to(np.clip(roughness, 0.1, 1.0), plane).astype(np.float32)
    return PbrMaps(np.clip(base, 0.0, 1.0).astype(np.float32), normal.astype(np.float32), rough, metallic, f0)


def tiled(maps: PbrMaps, repeats: int, detail: float, *, hexes: bool = True) -> Texels:
    """Texels of so many repeats at the mip level `detail`, one for each texel of full size."""
    across = (np.arange(repeats * SIDE) + 0.5) / SIDE
    uv = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2)
    return texels_at(hex_tiles(maps) if hexes else grid_tiles(maps), uv, np.full(len(uv), detail), maps)


def correlation(values: NDArray[np.float64], repeats: int) -> float:
    """Autocorrelation at one repeat to the right."""
    image = values.reshape(repeats * SIDE, -1) - values.mean()
    return float((image[:, :-SIDE] * image[:, SIDE:]).mean() / image.var())


@pytest.mark.parametrize("kind", ["woven", pytest.param("hammered", marks=pytest.mark.long), "leather"])
def test_nothing_repeats_and_the_histogram_stays(kind: str) -> None:
    maps = maps_of(kind)
    plain, found = (tiled(maps, 8, 0.0, hexes=hexes) for hexes in (False, True))
    for before, after in (
        (plain.base_colour[:, 1], found.base_colour[:, 1]),
        (plain.roughness, found.roughness),
        (plain.normal[:, 0], found.normal[:, 0]),
    ):
        if np.ptp(before) < 1e-6:
            continue
        assert correlation(before, 8) > 0.99
        assert abs(correlation(after, 8)) < 0.1
        bins = np.linspace(before.min() - 1e-6, before.max() + 1e-6, 65)
        shares = [np.histogram(np.clip(each, bins[0], bins[-1]), bins)[0] / len(each) for each in (before, after)]
        assert np.abs(np.cumsum(shares[0] - shares[1])).mean() < 0.02
        assert after.std() == pytest.approx(before.std(), rel=0.04)
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=1), 1.0, atol=1e-6)


@pytest.mark.parametrize("detail", [*(pytest.param(level, marks=pytest.mark.long) for level in (0.0, 4.0)), 1.5, 6.0])
def test_moments_are_those_of_the_maps_at_every_level(detail: float) -> None:
    """Means of all maps, also of metal that is there or not, and the variance of slopes between and within points."""
    maps = maps_of("hammered")
    plain, found = (tiled(maps, 8, detail, hexes=hexes) for hexes in (False, True))
    for name in ("base_colour", "roughness", "metallic", "f0"):
        before, after = getattr(plain, name).mean(axis=0), getattr(found, name).mean(axis=0)
        np.testing.assert_allclose(after, before, rtol=0.03, atol=1e-6, err_msg=name)
    total = [
        each.spread[:, :2].mean(axis=0) + (each.normal[:, :2] / each.normal[:, 2:]).var(axis=0)
        for each in (plain, found)
    ]
    np.testing.assert_allclose(total[1], total[0], rtol=0.08)


def test_cells_are_shifted_by_whole_texels_and_join_smoothly() -> None:
    random = np.random.default_rng(1)
    uv = random.uniform(-5.0, 5.0, (1000, 2))
    weight, shift = cells_around(uv, (20, 50))
    np.testing.assert_allclose(weight.sum(axis=1), 1.0)
    np.testing.assert_allclose(shift * [50, 20], np.rint(shift * [50, 20]), atol=1e-9)
    vertex = np.stack(np.meshgrid(np.arange(-40, 40), np.arange(-40, 40)), axis=-1).reshape(-1, 2)
    hashed = np.asarray(hash_cells(vertex))
    assert abs(np.asarray(np.corrcoef(hashed.T))[0, 1]) < 0.03
    np.testing.assert_allclose(np.sort(hashed[:, 0])[::640], np.linspace(0.0, 0.9, 10), atol=0.03)
    maps = bumpy(SIDE)
    line = np.stack([np.linspace(0.0, 2.0, 60_000), np.full(60_000, 0.37)], axis=1)
    along = texels_at(hex_tiles(maps), line, np.zeros(len(line)), maps).normal
    assert np.abs(np.diff(along, axis=0)).max() < 0.01


@pytest.mark.parametrize("repeats", [pytest.param(16.0, marks=pytest.mark.long), 96.0])
def test_relief_in_cells_is_as_bright_as_the_reference(repeats: float) -> None:
    eye = Camera((0.0, 0.0, 1e4), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), np.degrees(2e-4))
    scene = dataclasses.replace(
        scene_of(bumpy(), square(), light=(0.6, 0.2, 0.77), repeats=repeats, tiling_mode="hex"), camera=eye
    )
    traced = float(drain(reference(scene, (40, 40), samples=24)).image[..., 0].mean())
    found = drain(radiance(scene, (48, 48), samples=4))[..., 0].mean()
    assert found == pytest.approx(traced, rel=0.05)
    plain = drain(radiance(dataclasses.replace(scene, tiling_mode="grid"), (48, 48), samples=4))[..., 0].mean()
    assert plain == pytest.approx(traced, rel=0.06)
    assert found == pytest.approx(plain, rel=0.02)


def test_opengl_blends_cells_as_the_cpu_does(gl: Any) -> None:
    from engine.gl.direct import DirectRenderer

    renderer = DirectRenderer(gl)
    try:
        for repeats in (1.5, 20.0):
            scene = scene_of(maps_of("woven"), shape("sphere"), repeats=repeats, light=(0.4, 0.3, 0.86))
            plain = renderer.radiance(scene, (48, 48))
            scene = dataclasses.replace(scene, tiling_mode="hex")
            ours, theirs = drain(radiance(scene, (48, 48))), renderer.radiance(scene, (48, 48))
            assert np.abs(plain - theirs).mean() > 5e-3 * ours.mean()
            assert np.abs(ours - theirs).mean() < 1e-3 * ours.mean()
            assert np.quantile(np.abs(ours - theirs), 0.999) < 5e-3 * ours.max()
    finally:
        renderer.release()


LAMPS = 24


@cache
def stack_of(kind: str) -> ImageStack:
    """Photographs of the same sample under lamps from all sides, with a highlight."""
    maps = maps_of(kind)
    place = np.arange(LAMPS)
    light = surface_direction(np.arccos(np.linspace(0.98, 0.15, LAMPS)), place * 2.4)
    facing = np.maximum(np.einsum("hwi,ni->nhw", maps.normal, light), 0.02)
    half_way = light + np.array([0.0, 0.0, 1.0])
    half_way /= np.linalg.norm(half_way, axis=1, keepdims=True)
    glossy = 0.3 * np.maximum(np.einsum("hwi,ni->nhw", maps.normal, half_way), 0.0) ** 40
    radiance = facing[..., None] * maps.base_colour / 1.5 + glossy[..., None]
    radiance = srgb_decode(np.rint(255.0 * srgb_encode(np.minimum(radiance, 1.0))) / 255.0).astype(np.float32)
    return ImageStack(
        radiance=radiance,
        saturated=np.zeros(radiance.shape[:3], np.bool_),
        elevation=np.asarray(np.arcsin(light[:, 2])),
        azimuth=np.asarray(np.arctan2(light[:, 1], light[:, 0])),
        mean_radiance=radiance.mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE,
        sources=tuple(map(str, place)),
        angle_source="lp",
    )


@cache
def material_of(kind: str, form: str) -> Material:
    """A sample as slices, as a power law, or as planes of a directional map."""
    stack, used = stack_of(kind), np.arange(LAMPS)
    brdf = "phong:kd=0.5,ks=0.1,exponent=20"
    if form == "planes":
        return Material(None, None, brdf=brdf, directional=drain(fit(stack, used)))
    slices = drain(build(stack, 6))
    if form == "slices":
        return Material(slices, None, brdf=brdf, elevation_deg=tuple(np.degrees(stack.elevation)))
    return Material(None, drain(fit_power_law(slices)), brdf=brdf, elevation_deg=tuple(np.degrees(stack.elevation)))


def test_other_modes_are_refused() -> None:
    with pytest.raises(UsageError, match="unknown tiling mode 'round'; choose from grid, hex"):
        scene_of(bumpy(), square(), tiling_mode="round")


@pytest.mark.parametrize("name", ["stacks/pinkney_flat3/im1.jpg", "stacks/ring_rti64/0030.jpg"])
def test_photographs_repeat_nothing_and_keep_their_histogram(name: str, shared_data: Callable[[str], Path]) -> None:
    pixels = read_image(shared_data(name)).pixels[10 : 10 + SIDE, 10 : 10 + SIDE]
    slices = np.stack([np.zeros_like(pixels), pixels]).astype(np.float32)
    shading = ShadingMap(slices, float(pixels.mean()), slices.mean(axis=(1, 2, 3), dtype=np.float64))
    across = (np.arange(8 * SIDE) + 0.5) / SIDE
    uv = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2)
    for detail in (0.0, 2.5):
        where = np.full(len(uv), detail)
        grid, cells = (values_at(maps, 1, uv, where)[:, 1] for maps in (grid_tiles(shading), hex_tiles(shading)))
        assert abs(correlation(cells, 8)) < 0.1
        bins = np.linspace(grid.min() - 1e-6, grid.max() + 1e-6, 65)
        shares = [np.histogram(np.clip(each, bins[0], bins[-1]), bins)[0] / len(each) for each in (grid, cells)]
        assert np.abs(np.cumsum(shares[0] - shares[1])).mean() < 0.02


FORMS = ("slices", "power", "planes")

#: Every kind and every form once; the other pairs take --long.
ORDINARY = (("woven", "power"), ("hammered", "planes"), ("leather", "slices"))


def far_scene(material: Material, repeats: float, mode: Any, light: tuple[float, float, float]) -> Scene:
    """A square that fills the image, seen from straight above."""
    eye = Camera((0.0, 0.0, 1e4), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), np.degrees(2e-4))
    return make_scene(square(), eye, material=material, light=light, repeats=repeats, tiling_mode=mode)


@pytest.mark.parametrize(
    ("kind", "form"),
    [
        pytest.param(kind, form, marks=[] if (kind, form) in ORDINARY else [pytest.mark.long])
        for kind in ("woven", "hammered", "leather")
        for form in FORMS
    ],
)
def test_photographs_are_as_bright_from_afar_as_in_the_reference(kind: str, form: str) -> None:
    """In a grid and in cells, under high and low light, at 1 to 128 repeats over the image."""
    material = material_of(kind, form)
    for light in ((0.1, 0.2, 0.97), (-0.7, 0.6, 0.35)):
        near = far_scene(material, 1.0, "grid", light)
        traced = drain(reference(near, (64, 64), samples=16)).image[..., :3].mean(axis=(0, 1))
        for mode in ("grid", "hex"):
            for repeats in (8.0, 32.0, 128.0):
                scene = far_scene(material, repeats, mode, light)
                found = drain(radiance(scene, (61, 61), samples=3 if repeats < 16.0 else 1))[..., :3].mean(axis=(0, 1))
                np.testing.assert_allclose(found, traced, rtol=0.03, err_msg=f"{light} {mode} {repeats}")


@pytest.mark.parametrize("form", FORMS)
def test_opengl_blends_photographs_as_the_cpu_does(gl: Any, form: str) -> None:
    from engine.gl.direct import DirectRenderer

    renderer = DirectRenderer(gl)
    try:
        for repeats in (1.5, 20.0):
            scene = make_scene(
                shape("sphere"), Camera((0.0, 0.0, 3.0)), material=material_of("hammered", form), repeats=repeats
            )
            plain = renderer.radiance(scene, (48, 48))
            assert np.abs(plain - drain(radiance(scene, (48, 48)))).mean() < 1e-3 * plain.mean()
            scene = dataclasses.replace(scene, tiling_mode="hex")
            ours, theirs = drain(radiance(scene, (48, 48))), renderer.radiance(scene, (48, 48))
            assert np.abs(plain - theirs).mean() > 5e-3 * ours.mean()
            assert np.abs(ours - theirs).mean() < 2e-3 * ours.mean()
            assert np.quantile(np.abs(ours - theirs), 0.999) < 0.02 * ours.max()
    finally:
        renderer.release()
