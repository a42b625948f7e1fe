"""Texels in the light of a bake: exact for convex models and for Lambertian texels, and nearer to the reference."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.accuracy.compare import compare
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.render.direct import radiance
from engine.render.reference import reference
from engine.render.shadowed import FLOOR, shadowed
from engine.render.transported import picture_of
from engine.scene.material import Material
from engine.scene.scene import Scene
from engine.shading.shading_map import ShadingMap
from engine.transport.baking.settings import ShLight
from engine.transport.relit import light_of
from engine.transport.sh.bake import BakeSettings, bake, prepare
from engine.transport.sh_method import relit, relit_openly
from tests.engine.domes import dome_material
from tests.engine.render.test_transported_sh import ball, smooth_sky

SIZE = (48, 40)
CAMERA = Camera((3.0, 2.2, 4.0), (0.0, -0.3, 0.0))
LIGHT = tuple(normalize(np.array([0.6, 0.7, 0.4])).tolist())


def sloped(albedo: NDArray[Any], bend: float = 1.0) -> Material:
    """Texels (H, W, 3) of S(r) = albedo r^bend, of which Lambert's r is at most 1."""
    r = np.linspace(0.0, 1.0, 65)
    slices = (albedo * r[:, None, None, None] ** bend).astype(np.float32)
    return Material(ShadingMap(slices, 1.0, r), None, "lambert:albedo=1", sigma=np.pi)


def pictures(scene: Scene, folder: Path) -> tuple[Any, Any, Any]:
    """Texels without shadows, and the bake with them and without."""
    work = drain(prepare(scene.mesh, scene.brdf, BakeSettings(order=5, edge=16, fine=4), scene.ground))
    transport = drain(bake(folder / "a.transport", work)).transport
    light, asked = light_of(scene), ShLight()
    found = [drain(picture_of(make(transport, light, asked), CAMERA, SIZE)).picture for make in (relit, relit_openly)]
    return drain(radiance(scene, SIZE)), found[0], found[1]


@pytest.mark.parametrize("material", [sloped(np.full((1, 1, 3), 0.4), 2.0), dome_material()])
def test_one_light_on_a_convex_model_is_the_shading_map(material: Material, tmp_path: Path) -> None:
    scene = Scene(ball(), CAMERA, material.reflectance, material, LIGHT, 2.0, repeats=1.0)
    texels, baked, unshadowed = pictures(scene, tmp_path)
    assert shadowed(texels, baked, unshadowed) == pytest.approx(texels, rel=1e-4, abs=1e-6)
    assert texels[..., :3].max() > 0.1


def test_lambertian_texels_send_albedo_times_irradiance(tmp_path: Path) -> None:
    """Under a sky of which spherical harmonics leave nothing out."""
    albedo = np.array([0.8, 0.4, 0.1])
    material = sloped(albedo.reshape(1, 1, 3))
    sky: dict[str, Any] = {"environment": smooth_sky(), "directions": 1024}
    scene = Scene(ball(), CAMERA, material.reflectance, material, ground=Ground(albedo=1.0, cells=24), **sky)
    texels, baked, unshadowed = pictures(scene, tmp_path)
    found = shadowed(texels, baked, unshadowed)
    model = (found[..., 3] == 1.0) & (
        np.abs(drain(radiance(dataclasses.replace(scene, ground=None), SIZE))[..., 3] - 1) < 1e-6
    )
    wanted = np.pi * albedo * baked[model][:, :3]  # of a BRDF of 1 / π, and r = cos θ
    assert (np.abs(baked[model] - unshadowed[model]).mean(axis=0)[:3] > 0.02).all()
    assert np.sqrt(np.mean((found[model][:, :3] / wanted - 1.0) ** 2)) < 0.02


def test_texels_in_shadow_are_nearer_to_the_reference(tmp_path: Path) -> None:
    """A bent look-up, whose error is not zero, under light from everywhere."""
    material = sloped(np.full((1, 1, 3), 0.5), 1.6)
    sky: dict[str, Any] = {"environment": smooth_sky(), "directions": 256}
    scene = Scene(ball(), CAMERA, material.reflectance, material, ground=Ground(albedo=0.5, cells=24), **sky)
    texels, baked, unshadowed = pictures(scene, tmp_path)
    truth = drain(reference(scene, SIZE, samples=128)).picture
    inside = (texels[..., 3] == 1.0) & (truth[..., 3] == 1.0)
    before = compare(texels, truth, inside).rmse_rel
    after = compare(shadowed(texels, baked, unshadowed), truth, inside).rmse_rel
    assert after < 0.25 * before, (before, after)


def test_the_floor_by_hand() -> None:
    """Half the light arrives at one pixel; none goes to another, which keeps what it has; one is empty."""
    texels = np.array([[[0.2, 0.2, 0.2, 1.0], [0.1, 0.1, 0.1, 1.0], [0.0, 0.0, 0.0, 0.0]]], np.float32)
    unshadowed = np.array([[[4.0, 4.0, 4.0, 1.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0]]], np.float32)
    baked = unshadowed * np.array([0.5, 0.5, 0.5, 1.0], np.float32)
    found = shadowed(texels, baked, unshadowed)
    floor = FLOOR * 2.0
    assert found[0, 0, :3] == pytest.approx(0.2 * (2.0 + floor) / (4.0 + floor))
    assert (found[0, 1:] == texels[0, 1:]).all()
