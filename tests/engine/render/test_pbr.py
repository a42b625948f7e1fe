"""PBR maps in images: what they must agree with, a case solved by hand, and OpenGL beside the CPU."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import OpenPbr
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.geometry.camera import Camera, frame
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap
from engine.light.lamps import Lamp
from engine.light.near_lamps import near_lamp_from_text
from engine.render.direct import radiance
from engine.render.reference import reference
from engine.scene.material import material_of_maps
from engine.scene.scene import Scene
from engine.surface.pbr_maps import PbrMaps

Maps = NDArray[np.float32]


def maps_like(brdf: MetallicRoughness, size: int = 4, tilt: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> PbrMaps:
    """The same BRDF and normal at all texels."""
    return PbrMaps(
        base_colour=np.tile(np.array(brdf.base_color, np.float32), (size, size, 1)),
        normal=np.tile(normalize(np.array(tilt)).astype(np.float32), (size, size, 1)),
        roughness=np.full((size, size), brdf.roughness, np.float32),
        metallic=np.full((size, size), brdf.metallic, np.float32),
        f0=np.full((size, size), 0.04, np.float32),
    )


def square() -> Mesh:
    """Two units a side in the plane z = 0, texture coordinates from 0 to 1."""
    corners = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)])
    uv = (0.5 + 0.5 * corners[:, :2]).astype(np.float32)
    faces = np.array([(0, 1, 2), (0, 2, 3)], np.int32)
    return Mesh(corners, np.tile(np.array([0, 0, 1], np.float32), (4, 1)), uv, faces, "square")


def scene_of(maps: PbrMaps, mesh: Mesh, **options: Any) -> Scene:
    material = material_of_maps(maps, "maps")
    return Scene(mesh, frame(mesh.positions, 1.0), material.reflectance, material, **options)


def vary() -> PbrMaps:
    random, size = np.random.default_rng(2), 16
    normal = normalize(np.dstack([random.uniform(-0.4, 0.4, (size, size, 2)), np.ones((size, size))]))
    return PbrMaps(
        base_colour=random.random((size, size, 3)).astype(np.float32),
        normal=normal.astype(np.float32),
        roughness=random.uniform(0.2, 1.0, (size, size)).astype(np.float32),
        metallic=random.random((size, size)).astype(np.float32),
        f0=random.uniform(0.02, 0.08, (size, size)).astype(np.float32),
    )


BRDF = MetallicRoughness((0.7, 0.4, 0.1), 0.3, 0.4)


def test_even_maps_are_one_brdf() -> None:
    """In direct light to rounding, on the CPU; and in the reference, within its own noise."""
    scene = scene_of(maps_like(BRDF), shape("sphere"), lamps=(Lamp((0.0, 1.0, 0.2), (1.0, 2.0, 3.0)),))
    plain = dataclasses.replace(scene, material=None, brdf=BRDF)
    ours, theirs = (drain(radiance(each, (24, 24), samples=1)) for each in (scene, plain))
    np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-6)
    # point lights alone have no noise but that of the place within a pixel, which both share
    ours, theirs = (drain(reference(each, (16, 16), samples=4)).image for each in (scene, plain))
    np.testing.assert_allclose(ours, theirs, rtol=1e-4, atol=1e-5)


def test_even_maps_under_layers_are_one_model() -> None:
    """Coat, fuzz and film over even maps, against the model of the same text."""
    text = "coat_weight=0.7,coat_roughness=0.3,fuzz_weight=0.4,thin_film_weight=0.5,base_diffuse_roughness=0.3"
    layers = brdf_from_text(f"openpbr:{text}")
    assert isinstance(layers, OpenPbr)
    maps = dataclasses.replace(maps_like(BRDF), layers=layers)
    scene = scene_of(maps, shape("sphere"), lamps=(Lamp((0.0, 1.0, 0.2), (1.0, 2.0, 3.0)),))
    model = f"openpbr:base_color=0.7/0.4/0.1,base_metalness=0.3,specular_roughness=0.4,specular_ior=1.5,{text}"
    plain = dataclasses.replace(scene, material=None, brdf=brdf_from_text(model))
    assert np.allclose(scene.brdf.f((0.1, 0.2, 0.9), (0.3, 0.0, 0.9)), plain.brdf.f((0.1, 0.2, 0.9), (0.3, 0.0, 0.9)))
    ours, theirs = (drain(radiance(each, (24, 24), samples=1)) for each in (scene, plain))
    np.testing.assert_allclose(ours, theirs, rtol=1e-4, atol=1e-5)
    ours, theirs = (drain(reference(each, (16, 16), samples=4)).image for each in (scene, plain))
    np.testing.assert_allclose(ours, theirs, rtol=1e-3, atol=1e-4)


def test_even_maps_under_layers_of_gltf_are_one_model() -> None:
    """In direct light and in the reference; a coat over bent normals is as smooth as the surface."""
    brdf = dataclasses.replace(BRDF, coat_weight=0.7, coat_roughness=0.3, multiple_scattering=1.0)
    brdf = dataclasses.replace(brdf, sheen_color=(0.7, 0.5, 0.3), sheen_roughness=0.4)
    maps = dataclasses.replace(maps_like(brdf), layers=brdf, multiple_scattering=True)
    scene = scene_of(maps, shape("sphere"), lamps=(Lamp((0.0, 1.0, 0.2), (1.0, 2.0, 3.0)),))
    plain = dataclasses.replace(scene, material=None, brdf=brdf)
    ours, theirs = (drain(radiance(each, (16, 16), samples=1)) for each in (scene, plain))
    np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-6)
    ours, theirs = (drain(reference(each, (16, 16), samples=4)).image for each in (scene, plain))
    np.testing.assert_allclose(ours, theirs, rtol=1e-4, atol=1e-5)
    black = dataclasses.replace(brdf, base_color=(0.0, 0.0, 0.0), metallic=1.0, sheen_color=(0.0, 0.0, 0.0))
    values = []
    for tilt in ((0.0, 0.0, 1.0), (0.6, 0.0, 0.8)):
        bent = dataclasses.replace(maps_like(black, tilt=tilt), layers=black)
        values.append(drain(radiance(scene_of(bent, shape("sphere")), (16, 16), samples=1)))
    assert values[0][..., :3].max() > 0.1
    # what is left of the base is Schlick's term of its facets at grazing angles
    assert np.quantile(np.abs(values[0] - values[1])[values[0][..., 3] > 0.0], 0.5) < 1e-3


@pytest.mark.parametrize(("tilt", "light"), [((0.6, 0.0, 0.8), (0.6, 0.0, 0.8)), ((0.0, 0.6, 0.8), (0.0, 0.6, 0.8))])
def test_normals_bend_towards_the_right_and_upwards(
    tilt: tuple[float, float, float], light: tuple[float, float, float]
) -> None:
    """By hand: a diffuse texel whose normal (0.6, 0, 0.8) faces the lamp shows the most that any normal can.

    With metallic 0, black f0 would be needed for pure Lambert; f = (1 − F) c / π + F L. Seen from straight above,
    cos θo = 0.8 in the bent frame, cos θi = 1, h = (wi + wo) / |…|, so both terms follow from the text of glTF.
    """
    brdf = MetallicRoughness((0.5, 0.5, 0.5), 0.0, 1.0)
    maps = maps_like(brdf, tilt=tilt)
    eye = Camera((0.0, 0.0, 1e4), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 0.01)
    scene = dataclasses.replace(scene_of(maps, square(), light=light), camera=eye)
    found = drain(radiance(scene, (1, 1), samples=1))[0, 0, 0]
    half_wo = np.sqrt((1.0 + 0.8) / 2.0)  # h·wi, half the angle between wi and wo, whose cosine is 0.8
    fresnel = 0.04 + 0.96 * (1.0 - half_wo) ** 5
    # alpha 1: D = 1/π, and G / (4 n·l n·v) = 1 / ((1 + 1)(0.8 + √(1 + 0 · 0.64))) with √ = 1
    by_hand = (1.0 - fresnel) * 0.5 / np.pi + fresnel / np.pi / (2.0 * (0.8 + 1.0))
    assert found == pytest.approx(by_hand, rel=1e-4)


def test_rows_run_down_and_columns_to_the_right() -> None:
    base = np.zeros((2, 2, 3), np.float32)
    base[0, 1] = 1.0  # the upper right texel alone
    maps = dataclasses.replace(maps_like(MetallicRoughness((0.0, 0.0, 0.0), 1.0, 1.0), 2), base_colour=base)
    scene = scene_of(maps, square(), light=(0.0, 0.0, 1.0), repeats=1.0)
    image = drain(radiance(scene, (32, 32), samples=1))[..., 0]
    rows, columns = np.unravel_index(int(image.argmax()), image.shape)
    assert rows < 16
    assert columns > 16


def test_reference_agrees_with_direct_light_where_nothing_casts_a_shadow() -> None:
    """A flat square under one lamp; the images differ by what pixels average of fine texels."""
    maps = dataclasses.replace(vary(), normal=maps_like(BRDF, 16).normal)
    scene = scene_of(maps, square(), repeats=1.0)
    direct = drain(radiance(scene, (24, 24), samples=4))[4:-4, 4:-4, :3]
    traced = drain(reference(scene, (24, 24), samples=64)).image[4:-4, 4:-4, :3]
    assert np.abs(direct - traced).mean() < 0.03 * direct.mean()


def test_opengl_shows_what_the_cpu_shows(gl: Any) -> None:
    from engine.gl.direct import DirectRenderer

    renderer = DirectRenderer(gl)
    try:
        under = brdf_from_text("openpbr:coat_weight=0.7,coat_roughness=0.2,fuzz_weight=0.3,specular_color=1/0.7/0.5")
        brushed = brdf_from_text("openpbr:specular_roughness_anisotropy=0.6,thin_film_weight=1")
        coat = dataclasses.replace(BRDF, coat_weight=0.7, coat_roughness=0.3)
        sheen = dataclasses.replace(BRDF, sheen_color=(0.7, 0.5, 0.3), sheen_roughness=0.3)
        both = dataclasses.replace(coat, sheen_color=(0.7, 0.5, 0.3), sheen_roughness=0.6)
        cases = (
            (False, None),
            (True, None),
            (False, under),
            (False, brushed),
            (False, coat),
            (False, sheen),
            (True, both),
        )
        for again, layers in cases:
            assert layers is None or isinstance(layers, OpenPbr | MetallicRoughness)
            maps = dataclasses.replace(vary(), multiple_scattering=again, layers=layers)
            scene = scene_of(maps, shape("cloth"), lamps=(Lamp((-0.5, 0.7, 0.5), (0.5, 0.5, 1.0)),))
            if again or layers is under:
                lamp = near_lamp_from_text("shape=rectangle,x=1,y=1.5,z=1,power=20,width=0.5,height=0.5")
                scene = dataclasses.replace(scene, near_lamps=(lamp,), directions=9)
            theirs = renderer.radiance(scene, (48, 48))
            ours = drain(radiance(scene, (48, 48)))
            digits = 1e-4 if scene.near_lamps else 1e-5  # edges of polygons are summed in 32 bits
            assert np.abs(ours - theirs).mean() < digits * ours.mean() + 1e-6
            assert np.quantile(np.abs(ours - theirs), 0.999) < 1e-3
    finally:
        renderer.release()


def test_rough_white_metal_vanishes_in_even_light() -> None:
    """A flat square under light from everywhere, path-traced and summed, is as bright as the light: 0.99 … 1."""
    white = MetallicRoughness((1.0, 1.0, 1.0), 1.0, 0.9)
    maps = dataclasses.replace(maps_like(white), multiple_scattering=True)
    even = EnvironmentMap(np.ones((16, 32, 3), np.float32))
    scene = scene_of(maps, square(), environment=even, directions=512, repeats=1.0)
    inside = (slice(6, -6), slice(6, -6), 0)
    assert drain(radiance(scene, (20, 20), samples=1))[inside].mean() == pytest.approx(0.995, abs=0.008)
    assert drain(reference(scene, (20, 20), samples=64)).image[inside].mean() == pytest.approx(0.995, abs=0.008)
    lost = dataclasses.replace(scene, material=material_of_maps(maps_like(white), "lossy"))
    assert drain(radiance(lost, (20, 20), samples=1))[inside].mean() < 0.7


def test_ground_beside_maps_stays_what_it_is() -> None:
    from engine.geometry.ground import Ground

    scene = scene_of(vary(), shape("sphere"), ground=Ground(albedo=0.5))
    plain = dataclasses.replace(scene, material=None)
    ours, theirs = (drain(reference(each, (24, 24), samples=4)).image for each in (scene, plain))
    np.testing.assert_allclose(ours[-2:, :4], theirs[-2:, :4], rtol=1e-5, atol=1e-6)
    assert np.abs(ours - theirs).max() > 0.01


def bumpy(size: int = 64, slope: float = 0.3) -> PbrMaps:
    """Smooth random relief with slopes of this deviation, of a roughness that makes it glitter."""
    frequency = np.fft.fftfreq(size)[:, None] ** 2 + np.fft.rfftfreq(size)[None] ** 2
    noise = np.fft.rfft2(np.random.default_rng(1).normal(size=(size, size)))
    height = np.fft.irfft2(noise * np.exp(-frequency / (2 * 0.06**2)), s=(size, size))
    down, right = (0.5 * (np.roll(height, -1, axis) - np.roll(height, 1, axis)) for axis in (0, 1))
    scale = slope / np.sqrt(0.5 * (down**2 + right**2).mean())
    normal = normalize(np.dstack([-right * scale, down * scale, np.ones((size, size))])).astype(np.float32)
    return dataclasses.replace(maps_like(MetallicRoughness((0.2, 0.2, 0.2), 0.0, 0.25), size), normal=normal)


@pytest.mark.parametrize("light", [(0.0, 0.0, 1.0), pytest.param((0.6, 0.2, 0.77), marks=pytest.mark.long)])
def test_relief_reflects_alike_from_any_distance(light: tuple[float, float, float]) -> None:
    """The mean is that of the reference, which looks up full size alone, within 3 % from near and from afar, and within
    9 % where a pixel covers one bump; mean normals without their spread make it four times as bright."""
    eye = Camera((0.0, 0.0, 1e4), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), np.degrees(2e-4))

    def mean(size: int, repeats: float, samples: int = 0) -> float:
        scene = dataclasses.replace(scene_of(bumpy(size), square(), light=light, repeats=repeats), camera=eye)
        if samples:
            return float(drain(reference(scene, (64, 64), samples=samples)).image[..., 0].mean())
        return float(drain(radiance(scene, (64, 64), samples=4))[..., 0].mean())

    whole = mean(256, 16.0, samples=16)
    for size, repeats, tolerance in ((64, 1.0, 0.03), (256, 16.0, 0.09), (256, 128.0, 0.03)):
        exact = whole if size == 256 else mean(size, repeats, samples=16)
        assert mean(size, repeats) == pytest.approx(exact, rel=tolerance)


def test_relief_under_a_light_nearby_is_that_of_the_reference(gl: Any) -> None:
    """A bumpy square that a light spans: its mean holds from near and from afar; OpenGL shows what the CPU does."""
    from engine.gl.direct import DirectRenderer

    eye = Camera((0.0, 0.0, 1e4), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), np.degrees(2e-4))
    near = near_lamp_from_text("shape=rectangle,x=0.4,z=1,facing_theta_deg=90,facing_phi_deg=200,power=9")
    renderer = DirectRenderer(gl)
    try:
        for size, repeats, tolerance in ((64, 1.0, 0.03), (256, 64.0, 0.03)):
            scene = scene_of(bumpy(size), square(), near_lamps=(near,), irradiance=0.0, repeats=repeats)
            scene = dataclasses.replace(scene, camera=eye)
            traced = drain(reference(scene, (32, 32), samples=64)).image[..., :3]
            ours = drain(radiance(scene, (32, 32)))[..., :3]
            assert ours.mean() == pytest.approx(traced.mean(), rel=tolerance)
            theirs = renderer.radiance(scene, (32, 32))[..., :3]
            assert np.abs(ours - theirs).mean() < 1e-3 * ours.mean()
    finally:
        renderer.release()


def test_opengl_averages_normals_as_the_cpu_does(gl: Any) -> None:
    from engine.gl.direct import DirectRenderer

    scene = scene_of(
        dataclasses.replace(bumpy(), multiple_scattering=True), shape("sphere"), repeats=6.0, light=(0.4, 0.3, 0.86)
    )
    ours = drain(radiance(scene, (48, 48)))
    renderer = DirectRenderer(gl)
    try:
        theirs = renderer.radiance(scene, (48, 48))
    finally:
        renderer.release()
    assert np.abs(ours - theirs).mean() < 1e-4 * ours.mean()
    assert np.quantile(np.abs(ours - theirs), 0.999) < 1e-3 * ours.max()


def patches(random: np.random.Generator, share: float) -> NDArray[np.bool_]:
    """(64, 64) patches some five texels wide, that repeat, over a share of the maps."""
    across, down = np.meshgrid(np.fft.fftfreq(64), np.fft.fftfreq(64))
    noise = np.fft.fft2(random.random((64, 64))) * np.exp(-120.0 * (across**2 + down**2))
    smooth = np.fft.ifft2(noise).real
    return np.asarray(smooth < np.quantile(smooth, share))


def patchy(kind: str) -> PbrMaps:
    """Maps of which patches are rougher, or metal under a dark coat that is none."""
    random = np.random.default_rng(4)
    flat = np.zeros((64, 64, 3), np.float32)
    flat[..., 2] = 1.0
    inside = patches(random, 0.3 if kind == "rare roughness" else 0.5)
    is_rough = kind != "metal"
    roughness = np.where(inside, 0.2, 0.6) if is_rough else np.full((64, 64), 0.4)
    base = np.full((64, 64), 0.6) if is_rough else np.where(inside, 0.9, 0.1)
    metallic = np.ones((64, 64)) if is_rough else inside.astype(np.float64)
    colour = np.repeat(base[..., None], 3, axis=2).astype(np.float32)
    return PbrMaps(
        colour, flat, roughness.astype(np.float32), metallic.astype(np.float32), np.full((64, 64), 0.04, np.float32)
    )


@pytest.mark.parametrize(
    ("kind", "mode"),
    [
        ("rare roughness", "hex"),
        ("metal", "grid"),
        *(
            pytest.param(*pair, marks=pytest.mark.long)
            for pair in (("roughness", "grid"), ("roughness", "hex"), ("rare roughness", "grid"), ("metal", "hex"))
        ),
    ],
)
def test_patches_of_gloss_and_of_metal_are_as_bright_from_afar(kind: str, mode: Any, gl: Any) -> None:
    """A mean roughness was off by 40 %, and means of base colour and metallic by more."""
    from engine.gl.direct import DirectRenderer

    eye = Camera((0.0, 0.0, 1e4), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), np.degrees(2e-4))
    renderer = DirectRenderer(gl)
    try:
        for light in ((0.05, 0.1, 0.99), (0.2, 0.2, 0.96), (0.6, 0.2, 0.77)):
            near = dataclasses.replace(scene_of(patchy(kind), square(), light=light, repeats=1.0), camera=eye)
            traced = drain(reference(near, (96, 96), samples=16)).image[..., 1].mean()
            for repeats in (16.0, 128.0):
                far = dataclasses.replace(near, repeats=repeats, tiling_mode=mode)
                found = drain(radiance(far, (31, 31), samples=2))[..., 1].mean()
                assert found == pytest.approx(traced, rel=0.06 if "rough" in kind else 0.03)
                assert renderer.radiance(far, (31, 31))[..., 1].mean() == pytest.approx(found, rel=5e-3)
    finally:
        renderer.release()
