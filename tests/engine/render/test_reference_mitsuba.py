"""The reference against Mitsuba 3, an independent renderer, on scenes whose BRDF both state alike.

Both give a mean and a variance for each pixel; the difference is tested against both variances, at a level of 0.01 for
the whole image (Šidák), and 99.75 % of the pixels must pass, as Mitsuba's own tests of renderings ask. Environment
maps are constant over each texel here and bilinear there, so Mitsuba gets them finer. Triangles are flat where
normals that turn away from the viewer would be treated differently. A test that fails leaves the images.

The ordinary suite renders constant light, a rotated map, a directional light, interreflection with the ground, and a
metal under a disc lamp and a map; what these have in part, and a measured BRDF, take --long.
"""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
import trimesh
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf, brdf_from_text
from engine.brdf.readers.rgl import read_rgl
from engine.core.directions import Vectors, normalize, world_direction
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.images.encode import encode_png
from engine.light.environment import EnvironmentMap
from engine.light.lamps import Lamp
from engine.light.near_lamps import NearLamp, near_lamp_from_text
from engine.render.display import Display, display
from engine.render.reference import reference
from engine.scene.material import material_of_maps
from engine.scene.scene import Scene
from engine.surface.pbr_maps import PbrMaps

Floats = NDArray[np.float64]

#: Side of the images, samples of each pixel in each, and images by Mitsuba of which the variance is taken.
SIZE, SAMPLES, IMAGES = 28, 256, 16

#: Mitsuba computes in float32: where both are free of noise, so much of the value may be between them.
ROUNDING = 2e-4

BLACK = EnvironmentMap(np.zeros((1, 1, 3), np.float32))


@pytest.fixture(scope="module")
def mitsuba() -> Any:
    try:
        module = importlib.import_module("mitsuba")
    except (ImportError, NameError) as error:  # NameError: what its own package makes of a library that is missing
        pytest.skip(f"Mitsuba cannot be loaded: {error}")
    module.set_variant("scalar_rgb")
    return module


@dataclass(frozen=True)
class Swapped:
    """A measurement with its sides exchanged: Mitsuba's paths take the viewer as the measured incident direction."""

    brdf: Brdf

    reciprocal, energy_conserving = False, False

    @property
    def isotropic(self) -> bool:
        return self.brdf.isotropic

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        return self.brdf.f(wo, wi)


def flat(mesh: Mesh) -> Mesh:
    """Every triangle with vertices and a normal of its own."""
    positions = mesh.positions[mesh.faces]
    normal = normalize(np.cross(positions[:, 1] - positions[:, 0], positions[:, 2] - positions[:, 0]))
    faces = np.arange(positions.shape[0] * 3, dtype=np.int32).reshape(-1, 3)
    normals = np.repeat(normal, 3, axis=0).astype(np.float32)
    return Mesh(positions.reshape(-1, 3), normals, mesh.uv[mesh.faces].reshape(-1, 2), faces, mesh.name)


def observe(mesh: Mesh, brdf: Brdf, **options: Any) -> Scene:
    return Scene(mesh, frame(mesh.positions, 1.0, 35.0, (0.3, 0.5, 1.0)), brdf, **options)


def make_lit_hall(rows: int = 16) -> EnvironmentMap:
    """A dim coloured room with three small bright windows."""
    random = np.random.default_rng(3)
    radiance = 0.2 + 0.2 * random.random((rows, 2 * rows, 3))
    for row, column, colour in ((4, 5, (40, 30, 20)), (5, 20, (10, 20, 40)), (7, 14, (15, 15, 15))):
        radiance[row, column] = colour
    return EnvironmentMap(radiance.astype(np.float32))


def translate(
    mitsuba: Any,
    scene: Scene,
    bsdf: dict[str, Any],
    max_depth: int,
    folder: Path,
    model_shape: dict[str, Any] | None = None,
) -> Any:
    """`scene` as Mitsuba's, the model, or `model_shape` in its place, with the BRDF `bsdf`."""
    camera, model = scene.camera, Path(folder, "model.ply")
    _write_ply(model, scene.mesh.positions, scene.mesh.normals, scene.mesh.faces)
    look_at = mitsuba.ScalarTransform4f().look_at(list(camera.eye), list(camera.target), list(camera.up))
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    integrator = {"type": "path", "max_depth": max_depth + 1, "rr_depth": 100, "hide_emitters": True}
    if max_depth == 1:
        integrator = {"type": "direct", "hide_emitters": True}
    parts: dict[str, Any] = {
        "type": "scene",
        "integrator": integrator,
        "sensor": {"type": "perspective", "fov": camera.fov_deg, "to_world": look_at, "film": film},
        "model": {
            **(model_shape or {"type": "ply", "filename": str(model)}),
            "bsdf": {"type": "twosided", "nested": bsdf},
        },
    }
    if scene.ground is not None:
        ground, below = Path(folder, "ground.ply"), len(scene.mesh.positions)
        surface = scene.surface
        faces = surface.faces[len(scene.mesh.faces) :] - below
        _write_ply(ground, surface.positions[below:], surface.normals[below:], faces)
        parts["ground"] = {"type": "ply", "filename": str(ground), "bsdf": diffuse(scene.ground.albedo)}
    if scene.environment is not None:
        fine = np.repeat(np.repeat(scene.environment.radiance * scene.irradiance, 16, axis=0), 16, axis=1)
        turn = mitsuba.ScalarTransform4f().rotate([0, 1, 0], np.degrees(scene.environment_rotation))
        parts["environment"] = {"type": "envmap", "bitmap": mitsuba.Bitmap(fine), "to_world": turn}
    else:
        parts["light"] = _directional(scene.light, (scene.irradiance,) * 3)
    for number, lamp in enumerate(scene.lamps):
        parts[f"lamp{number}"] = _sphere(lamp, scene.mesh) if lamp.radius else _directional(*lamp_of(lamp))
    for number, near in enumerate(scene.near_lamps):
        parts[f"near{number}"] = _area_emitter(mitsuba, near)
    return mitsuba.load_dict(parts)


def diffuse(albedo: float) -> dict[str, Any]:
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": albedo}}


def lamp_of(lamp: Lamp) -> tuple[tuple[float, ...], tuple[float, ...]]:
    return lamp.direction, lamp.irradiance


def _directional(direction: tuple[float, ...], irradiance: tuple[float, ...]) -> dict[str, Any]:
    towards = [-x for x in direction]
    return {"type": "directional", "direction": towards, "irradiance": {"type": "rgb", "value": list(irradiance)}}


def _sphere(lamp: Lamp, mesh: Mesh) -> dict[str, Any]:
    """A ball so far away that it is seen as the same disc from everywhere on the model."""
    distance = 3000.0 * mesh.radius
    centre = mesh.centre + distance * np.asarray(lamp.direction)
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": list(lamp.radiance)}}
    return {
        "type": "sphere",
        "center": centre.tolist(),
        "radius": float(distance * np.sin(lamp.radius)),
        "emitter": emitter,
    }


def _area_emitter(mitsuba: Any, lamp: NearLamp) -> dict[str, Any]:
    """A light near the model; nothing of it is reflected."""
    emitter = {"type": "area", "radiance": {"type": "rgb", "value": list(lamp.radiance)}}
    parts = {"emitter": emitter, "bsdf": diffuse(0.0)}
    if lamp.shape == "sphere":
        return {"type": "sphere", "center": list(lamp.position), "radius": lamp.radius, **parts}
    matrix = np.eye(4)
    matrix[:3, :2] = lamp.half_sides.T
    matrix[:3, 2], matrix[:3, 3] = lamp.facing, lamp.position
    to_world = mitsuba.ScalarTransform4f(matrix)
    return {"type": "disk" if lamp.shape == "disc" else "rectangle", "to_world": to_world, **parts}


def _write_ply(path: Path, positions: Floats, normals: NDArray[np.float32], faces: NDArray[np.int32]) -> None:
    solid = trimesh.Trimesh(positions, faces, vertex_normals=normals, process=False)
    path.write_bytes(trimesh.exchange.ply.export_ply(solid, vertex_normal=True))


def render(mitsuba: Any, scene: Any) -> tuple[Floats, Floats]:
    """Mean and its variance, (SIZE, SIZE, 3) each."""
    images = [
        np.array(mitsuba.render(scene, spp=SAMPLES // IMAGES, seed=seed), np.float64)[..., :3] for seed in range(IMAGES)
    ]
    return np.mean(images, axis=0), np.var(images, axis=0, ddof=1) / IMAGES


def assert_alike(
    mitsuba: Any,
    folder: Path,
    scene: Scene,
    bsdf: dict[str, Any],
    max_depth: int = 1,
    samples: int = SAMPLES,
    model_shape: dict[str, Any] | None = None,
) -> None:
    theirs, their_variance = render(mitsuba, translate(mitsuba, scene, bsdf, max_depth, folder, model_shape))
    found = drain(reference(scene, (SIZE, SIZE), samples=samples, max_depth=max_depth, seed=1))
    assert found.variance is not None
    ours = found.image[..., :3].astype(np.float64)
    error = ours - theirs
    deviation = np.sqrt(found.variance + their_variance + (ROUNDING * theirs) ** 2 + 1e-30)
    limit = NormalDist().inv_cdf(1.0 - (1.0 - 0.99 ** (1.0 / error.size)) / 2.0)
    passed = (np.abs(error) < limit * deviation).all(axis=-1)
    bias = error.sum(axis=(0, 1)) / np.sqrt((deviation**2).sum(axis=(0, 1)))
    if passed.mean() < 0.9975 or np.abs(bias).max() > 4.5:
        exposure = -float(np.log2(max(np.quantile(theirs, 0.98), 1e-9)))
        for name, image in (("picture", ours), ("mitsuba", theirs), ("error", 0.3 + 2.0 * error)):
            covered = np.concatenate([image, np.ones_like(image[..., :1])], axis=-1).astype(np.float32)
            Path(folder, f"{name}.png").write_bytes(encode_png(display(covered, Display(exposure))))
    assert theirs.mean() > 0.0
    assert passed.mean() >= 0.9975, f"{1 - passed.mean():.2%} of the pixels differ; see {folder}"
    assert np.abs(bias).max() < 4.5, f"the whole differs by {bias} standard errors; see {folder}"
    # a test that noise makes blind proves nothing
    assert np.sqrt(np.sum(their_variance) / np.sum(theirs**2)) < 0.1


def test_diffuse_sphere_in_constant_light(mitsuba: Any, tmp_path: Path) -> None:
    environment = EnvironmentMap(np.full((1, 2, 3), (1.0, 0.5, 0.25), np.float32))
    scene = observe(shape("sphere"), brdf_from_text("lambert:albedo=0.6"), environment=environment)
    assert_alike(mitsuba, tmp_path, scene, diffuse(0.6))


def test_self_shadowing_knot_in_a_turned_map(mitsuba: Any, tmp_path: Path) -> None:
    options = {"environment": make_lit_hall(), "environment_rotation": 0.7, "irradiance": 1.5}
    scene = observe(flat(shape("torus-knot")), brdf_from_text("lambert:albedo=0.5"), **options)
    assert_alike(mitsuba, tmp_path, scene, diffuse(0.5))


@pytest.mark.long
def test_metal_in_a_map(mitsuba: Any, tmp_path: Path) -> None:
    brdf = brdf_from_text("metallic-roughness:base_color=0.8/0.6/0.3,metallic=1,roughness=0.5")
    scene = observe(flat(shape("torus-knot")), brdf, environment=make_lit_hall())
    assert_alike(mitsuba, tmp_path, scene, METAL)


METAL = {
    "type": "principled",
    "base_color": {"type": "rgb", "value": [0.8, 0.6, 0.3]},
    "metallic": 1.0,
    "roughness": 0.5,
}


@pytest.mark.long
def test_disc_lamp_casts_soft_shadows(mitsuba: Any, tmp_path: Path) -> None:
    lamp = Lamp(tuple(world_direction(0.8, 0.5)), (3.0, 2.0, 1.0), 0.15)
    scene = observe(
        shape("sphere"), brdf_from_text("lambert:albedo=0.5"), lamps=(lamp,), irradiance=0.0, ground=Ground(albedo=0.7)
    )
    assert_alike(mitsuba, tmp_path, dataclasses.replace(scene, camera=from_above(scene)), diffuse(0.5))


@pytest.mark.parametrize(
    "near",
    [
        "shape=rectangle,x=-0.5,y=1.6,z=0.6,facing_theta_deg=140,facing_phi_deg=140,rotation_deg=25,width=1.2,height=0.5,power=9",
        pytest.param(
            "shape=disc,x=0.9,y=1.5,z=0.9,facing_theta_deg=130,facing_phi_deg=-130,radius=0.4,power=9",
            marks=pytest.mark.long,
        ),
        pytest.param("x=0.9,y=1.5,z=0.9,radius=0.3,power=30", marks=pytest.mark.long),
    ],
)
def test_lights_near_the_model_cast_soft_shadows(mitsuba: Any, tmp_path: Path, near: str) -> None:
    lamp = near_lamp_from_text(f"{near},colour=1:0.7:0.4")
    brdf = brdf_from_text("metallic-roughness:base_color=0.8/0.6/0.3,metallic=1,roughness=0.5")
    scene = observe(flat(shape("sphere")), brdf, near_lamps=(lamp,), irradiance=0.0, ground=Ground(albedo=0.7))
    assert_alike(mitsuba, tmp_path, dataclasses.replace(scene, camera=from_above(scene)), METAL)


def test_directional_lights_cast_hard_shadows(mitsuba: Any, tmp_path: Path) -> None:
    lamp = Lamp((-1.0, 1.0, 0.2), (0.1, 0.2, 0.5))
    scene = observe(flat(shape("torus-knot")), brdf_from_text("lambert:albedo=0.5"), lamps=(lamp,), ground=Ground())
    assert_alike(mitsuba, tmp_path, dataclasses.replace(scene, camera=from_above(scene)), diffuse(0.5))


@pytest.mark.parametrize("max_depth", [pytest.param(2, marks=pytest.mark.long), 5])
def test_light_goes_back_and_forth_between_model_and_ground(mitsuba: Any, tmp_path: Path, max_depth: int) -> None:
    scene = observe(
        flat(shape("torus-knot")),
        brdf_from_text("lambert:albedo=0.9"),
        environment=make_lit_hall(),
        ground=Ground(albedo=0.8),
    )
    scene = dataclasses.replace(scene, camera=from_above(scene))
    assert_alike(mitsuba, tmp_path, scene, diffuse(0.9), max_depth)


def test_metal_mirrors_the_ground(mitsuba: Any, tmp_path: Path) -> None:
    brdf = brdf_from_text("metallic-roughness:base_color=0.8/0.6/0.3,metallic=1,roughness=0.5")
    lamp = Lamp(tuple(world_direction(0.8, 0.5)), (3.0, 2.0, 1.0), 0.15)
    options = {"lamps": (lamp,), "environment": make_lit_hall(), "ground": Ground(albedo=0.8)}
    scene = observe(flat(shape("torus-knot")), brdf, **options)
    assert_alike(mitsuba, tmp_path, dataclasses.replace(scene, camera=from_above(scene)), METAL, 3)


def test_pbr_maps_of_a_metal(mitsuba: Any, tmp_path: Path) -> None:
    """Base colour, roughness and normals that vary: Mitsuba's principled metal behind its normal map."""
    random, size = np.random.default_rng(4), 8
    normal = normalize(np.dstack([random.uniform(-0.3, 0.3, (size, size, 2)), np.ones((size, size))]))
    maps = PbrMaps(
        base_colour=random.uniform(0.1, 0.9, (size, size, 3)).astype(np.float32),
        normal=normal.astype(np.float32),
        roughness=random.uniform(0.4, 0.9, (size, size)).astype(np.float32),
        metallic=np.ones((size, size), np.float32),
        f0=np.full((size, size), 0.04, np.float32),
    )
    square = np.array([(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0)])
    uv = (0.5 + 0.5 * square[:, :2]).astype(np.float32)
    faces = np.array([(0, 1, 2), (0, 2, 3)], np.int32)
    mesh = Mesh(square, np.tile(np.array([0, 0, 1], np.float32), (4, 1)), uv, faces, "square")
    material = material_of_maps(maps, "metal")
    scene = observe(mesh, material.reflectance, material=material, repeats=1.0, environment=make_lit_hall())

    def texture(values: NDArray[np.float32]) -> dict[str, Any]:
        upwards = np.ascontiguousarray(values[::-1] if values.ndim == 3 else values[::-1, :, None])
        return {"type": "bitmap", "bitmap": mitsuba.Bitmap(upwards), "raw": True}

    metal = {
        "type": "principled",
        "base_color": texture(maps.base_colour),
        "roughness": texture(maps.roughness),
        "metallic": 1.0,
    }
    bent = {"type": "normalmap", "normalmap": texture(0.5 + 0.5 * maps.normal), "bsdf": metal}
    assert_alike(mitsuba, tmp_path, scene, bent, model_shape={"type": "rectangle"})


@pytest.mark.long
def test_measured_brdf(mitsuba: Any, tmp_path: Path, shared_data: Callable[[str], Path]) -> None:
    path = shared_data("brdf/rgl/satin_rosaline_rgb.bsdf")
    scene = observe(flat(shape("torus-knot")), Swapped(read_rgl(path)), environment=make_lit_hall())
    assert_alike(mitsuba, tmp_path, scene, {"type": "measured", "filename": str(path)})


def from_above(scene: Scene) -> Any:
    """A view of the model and of the ground around it."""
    eye = scene.mesh.centre + 5.0 * scene.mesh.radius * normalize((0.3, 0.6, 1.0))
    return dataclasses.replace(scene.camera, eye=tuple(eye), target=tuple(scene.mesh.centre), fov_deg=40.0)
