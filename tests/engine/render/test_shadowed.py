"""Texels in the light of a bake: exact where the look-up is linear, nearer to the reference where it is not."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.accuracy.compare import compare
from engine.brdf.brdf import brdf_from_text
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.gl.scene_renderer import SceneRenderer, send
from engine.gl.screen import Image
from engine.light.environment import DistantLights
from engine.light.lamps import lights_from_all_sides
from engine.light.near_lamps import NearLamp
from engine.render.direct import radiance
from engine.render.reference import reference
from engine.render.shadowed import combine_shadowed, draw, with_and_without
from engine.render.transported import image_of
from engine.scene.material import Material, material_of_maps
from engine.scene.scene import RelightTransport, Scene
from engine.shading.shading_map import ShadingMap
from engine.surface.pbr_maps import PbrMaps
from engine.transport.method import Subject, method_of
from engine.transport.relight import light_of
from tests.engine.render.test_pbr import bumpy
from tests.engine.render.test_transported_sh import smooth_sky, sphere

SIZE = (32, 28)
#: Enough pixels to tell the texels of a chequerboard apart.
FINE = (48, 40)
CAMERA = Camera((3.0, 2.2, 4.0), (0.0, -0.3, 0.0))
LIGHT = tuple(normalize(np.array([0.6, 0.7, 0.4])).tolist())
NEAR: dict[str, Any] = {"irradiance": 0.0, "near_lamps": (NearLamp((2.0, 2.0, 1.0), (9.0, 9.0, 9.0)),)}
GLOSSY = "phong:kd=0.3,ks=0.3,exponent=8"

#: Settings of quick bakes.
QUICK: dict[str, dict[str, Any]] = {
    "sh": {"order": 4, "cube": 16},
    "wavelet": {"terms": 3, "cube": 8, "coefficients": 128},
    "gaussian": {"samples": 32},
}


def globe() -> Mesh:
    """A coarse ball whose texture lies on it as seen from the front."""
    made = sphere(14, 7)
    return dataclasses.replace(made, uv=made.positions[:, :2].astype(np.float32))


def slope(albedo: NDArray[Any], bend: float, sigma: float) -> Material:
    """Texels (H, W, 3) of S(r) = albedo r^bend."""
    r = np.linspace(0.0, 1.0, 65)
    slices = (albedo * r[:, None, None, None] ** bend).astype(np.float32)
    return Material(ShadingMap(slices, 1.0, r), None, GLOSSY, sigma=sigma)


def scene_with(material: Material, **light: Any) -> Scene:
    lit = light or {"environment": smooth_sky(), "directions": 256}
    return Scene(globe(), CAMERA, material.reflectance, material, ground=Ground(cells=8), repeats=1.0, **lit)


def transport_of(scene: Scene, mode: str, folder: Path) -> Any:
    method = method_of(mode)
    subject = Subject(scene.mesh, scene.brdf, scene.ground)
    work = drain(method.baking.prepare(subject, method.settings(**QUICK[mode])))
    return drain(method.baking.bake(folder / "a.transport", work)).transport


def baked_light(scene: Scene) -> RelightTransport:
    assert scene.relit is not None
    return scene.relit


def light_up(scene: Scene, mode: str, transport: Any) -> Scene:
    """The scene with the bake under its light."""
    method = method_of(mode)
    return dataclasses.replace(scene, relit=method.baking.relight_transport(transport, light_of(scene), method.light()))


@pytest.fixture(scope="module", params=["sh", "wavelet", "gaussian"])
def glossy(request: Any, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Any]:
    """Each method, and its bake of the ball."""
    scene = scene_with(slope(np.ones((1, 1, 3)), 1.0, 1.0))
    return request.param, transport_of(scene, request.param, tmp_path_factory.mktemp("bakes"))


@pytest.mark.parametrize("light", [{}, {"light": LIGHT}, NEAR])
def test_texels_of_a_linear_look_up_are_factors_on_the_bake(glossy: tuple[str, Any], light: dict[str, Any]) -> None:
    """S(r) = a r is a sigma f cos: the bake times a sigma, under any light and where none falls."""
    if "near_lamps" in light and not method_of(glossy[0]).near_light:
        return
    albedo = np.array([0.8, 0.4, 0.1])
    scene = light_up(scene_with(slope(albedo.reshape(1, 1, 3), 1.0, 0.5), **light), *glossy)
    bare = drain(image_of(baked_light(scene), CAMERA, SIZE)).image
    model = drain(radiance(dataclasses.replace(scene, relit=None, ground=None), SIZE))[..., 3] == 1.0
    found = drain(draw(scene, SIZE))
    assert found[model][:, :3] == pytest.approx(0.5 * albedo * bare[model][:, :3], rel=2e-4, abs=1e-7)
    ground = (bare[..., 3] == 1.0) & ~model
    inner = ground & np.roll(ground, 1, 0) & np.roll(ground, -1, 0) & np.roll(ground, 1, 1) & np.roll(ground, -1, 1)
    assert inner.any()
    assert found[inner] == pytest.approx(bare[inner], rel=1e-5)


@pytest.fixture(scope="module")
def bent() -> tuple[Scene, NDArray[np.float32]]:
    """A bent look-up, whose error is not zero, under light from everywhere, and the reference."""
    rng = np.random.default_rng(4)
    scene = scene_with(slope(rng.uniform(0.2, 0.8, (4, 4, 3)), 1.4, 1.0))
    return scene, drain(reference(scene, SIZE, samples=64)).image


def test_texels_in_shadow_are_nearer_to_the_reference(
    glossy: tuple[str, Any], bent: tuple[Scene, NDArray[np.float32]]
) -> None:
    scene, truth = bent
    found = drain(draw(light_up(scene, *glossy), SIZE))
    inside = (found[..., 3] == 1.0) & (truth[..., 3] == 1.0)
    before = compare(drain(radiance(scene, SIZE)), truth, inside).rmse_rel
    after = compare(found, truth, inside).rmse_rel
    assert after < 0.5 * before, (before, after)


def test_both_renderers_agree(gl: Any, glossy: tuple[str, Any]) -> None:
    rng = np.random.default_rng(4)
    scene = light_up(scene_with(slope(rng.uniform(0.2, 0.8, (4, 4, 3)), 1.4, 1.0), light=LIGHT), *glossy)
    renderer, image = SceneRenderer(gl), Image(gl, SIZE)
    found = renderer.radiance(scene, SIZE, samples=2)
    bands = renderer.bands(scene, image.framebuffer, SIZE, samples=2)
    next(bands)
    while not send(bands, 7):
        pass
    shown = image.read()
    baked = renderer.baked.radiance(baked_light(scene), CAMERA, SIZE, samples=2)
    for owner in (image, renderer):
        owner.release()
    with_texels, without = (drain(radiance(each, SIZE)) for each in with_and_without(scene))
    computed = combine_shadowed(with_texels, without, baked)
    inside = (computed[..., 3] == 1.0) & (found[..., 3] == 1.0)
    assert shown == pytest.approx(found, rel=1e-3, abs=1e-5)
    assert compare(found, computed, inside).rmse_rel < 0.01


def checker(base: tuple[float, float], roughness: tuple[float, float]) -> Material:
    """PBR maps of two kinds of texels."""
    first = np.indices((8, 8)).sum(axis=0) % 2 > 0
    plain = np.ones((8, 8), np.float32)
    maps = PbrMaps(
        base_colour=np.where(first, *base).astype(np.float32)[..., None] * np.ones(3, np.float32),
        normal=plain[..., None] * np.array([0.0, 0.0, 1.0], np.float32),
        roughness=np.where(first, *roughness).astype(np.float32),
        metallic=0.0 * plain,
        f0=0.04 * plain,
    )
    return material_of_maps(maps, "checker")


def test_pbr_maps_that_are_all_alike_are_the_bake(tmp_path: Path) -> None:
    scene = scene_with(checker((0.4, 0.4), (0.6, 0.6)))
    scene = light_up(scene, "sh", transport_of(scene, "sh", tmp_path))
    bare = drain(image_of(baked_light(scene), CAMERA, SIZE)).image
    assert drain(draw(scene, SIZE)) == pytest.approx(bare, rel=2e-3, abs=1e-5)


def test_pbr_maps_vary_in_a_bake_of_their_mean(tmp_path: Path) -> None:
    scene = scene_with(checker((0.7, 0.1), (0.3, 0.8)))
    truth = drain(reference(scene, FINE, samples=64)).image
    scene = light_up(scene, "sh", transport_of(scene, "sh", tmp_path))
    found, bare = drain(draw(scene, FINE)), drain(image_of(baked_light(scene), CAMERA, FINE)).image
    model = drain(radiance(dataclasses.replace(scene, relit=None, ground=None), FINE))[..., 3] == 1.0
    inside = model & (found[..., 3] == 1.0) & (truth[..., 3] == 1.0)
    before, after = compare(bare, truth, inside).rmse_rel, compare(found, truth, inside).rmse_rel
    assert after < 0.4 * before, (before, after)


def test_relief_in_a_bake_keeps_its_brightness_from_afar(tmp_path: Path) -> None:
    """Under one lamp, which tells a wider highlight from a brighter one; nothing shadows a ball."""
    lamp: dict[str, Any] = {"light": (0.3, 0.5, 0.8)}
    scene = dataclasses.replace(scene_with(material_of_maps(bumpy(), "bumpy"), **lamp), ground=None)
    transport = transport_of(scene, "sh", tmp_path)

    def mean(repeats: float) -> float:
        lit = light_up(dataclasses.replace(scene, repeats=repeats), "sh", transport)
        image = drain(draw(lit, (64, 64), samples=3))
        return float(image[..., 1].sum() / image[..., 3].sum())

    near = mean(0.5)
    for repeats in (4.0, 32.0):
        assert mean(repeats) == pytest.approx(near, rel=0.03)


def test_a_bake_of_another_brdf_lends_its_shadows_alone(tmp_path: Path) -> None:
    """Nothing shadows a ball: its texels are those without a bake, whatever was baked."""
    scene = dataclasses.replace(scene_with(slope(np.full((1, 1, 3), 0.6), 1.4, 1.0)), ground=None)
    matte = dataclasses.replace(scene, brdf=brdf_from_text("lambert:albedo=0.3"))
    relit = baked_light(light_up(matte, "sh", transport_of(matte, "sh", tmp_path)))
    with_texels, without = (drain(radiance(each, SIZE)) for each in with_and_without(scene, matte.brdf))
    found = combine_shadowed(with_texels, without, drain(image_of(relit, CAMERA, SIZE)).image)
    inside = found[..., 3] == 1.0
    assert compare(found, drain(radiance(scene, SIZE)), inside).rmse_rel < 0.02


def test_by_hand() -> None:
    """Texels without a shadow stay as they are; under half the light they are half; without any, all count alike."""
    texels = np.array([[[0.2, 0.4, 0.2, 1.0], [0.2, 0.4, 0.2, 1.0], [0.0, 0.0, 0.0, 1.0]]], np.float32)
    plain = np.array([[[4.0, 4.0, 4.0, 1.0], [4.0, 4.0, 4.0, 1.0], [0.0, 0.0, 0.0, 1.0]]], np.float32)
    share = np.array([1.0, 0.5, 0.3])[:, None] * np.array([1.0, 1.0, 1.0])
    bake = np.concatenate([plain[..., :3] * share, plain[..., 3:]], axis=-1).astype(np.float32)
    bake[0, 2] = (0.1, 0.2, 0.3, 1.0)
    found = combine_shadowed(texels, plain, bake)
    assert found[0, 0] == pytest.approx(texels[0, 0])
    assert found[0, 1, :3] == pytest.approx(0.5 * texels[0, 1, :3])
    assert found[0, 2, :3] == pytest.approx(bake[0, 2, :3] * 2.0 * np.array([0.05, 0.1, 0.05]))


def test_light_beyond_the_direct_meets_no_texel_that_is_far_brighter_than_all() -> None:
    """A bake is 0.3 where 0.1 is direct; one texel has a hundred times the share of the others."""
    plain = np.full((1, 4, 4), 0.1, np.float32)
    texels = np.array([[[10.0] * 4] + [[0.1] * 4] * 3], np.float32)
    bake = np.full((1, 4, 4), 0.3, np.float32)
    for image in (plain, texels, bake):
        image[..., 3] = 1.0
    found = combine_shadowed(texels, plain, bake)
    assert found[0, 0, :3] == pytest.approx(10.0 + 0.2 * 2.0 * (10.3 / 0.4), rel=1e-5)
    assert found[0, 1:, :3] == pytest.approx(0.3)


def test_an_outline_covers_what_both_images_cover() -> None:
    bake = np.array([[[1.0, 1.0, 1.0, 1.0], [0.75, 0.75, 0.75, 0.75]]], np.float32)
    plain = np.array([[[0.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 0.5]]], np.float32)
    texels = np.array([[[0.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.5, 0.5]]], np.float32)
    assert combine_shadowed(texels, plain, bake) == pytest.approx(np.array([[[0.0] * 4, [0.25, 0.25, 0.25, 0.5]]]))


def test_faint_light_comes_evenly_from_all_sides() -> None:
    lights = lights_from_all_sides(DistantLights(np.eye(3), np.full((3, 3), 2.0)), 0.1)
    assert lights.irradiance.sum(axis=0) == pytest.approx([0.6] * 3)
    assert np.linalg.norm(lights.direction, axis=1) == pytest.approx(np.ones(12))
    assert lights.direction.T @ lights.direction == pytest.approx(4.0 * np.eye(3), abs=1e-12)
    dark = lights_from_all_sides(DistantLights(np.zeros((0, 3)), np.zeros((0, 3))), 0.1)
    assert dark.irradiance.sum(axis=0) == pytest.approx([0.1] * 3)
