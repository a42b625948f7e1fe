"""Models whose parts have materials of their own, and colours of vertices: every renderer draws the same, which is
Lambert's law in closed form, and what Mitsuba draws of the same quads."""

from __future__ import annotations

import dataclasses
import importlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.exchange.readers.read import open_material
from engine.geometry.camera import Camera
from engine.geometry.mesh import read_mesh
from engine.gl.direct import DirectRenderer
from engine.render.direct import radiance
from engine.render.reference import reference
from engine.scene.mode import MODES
from engine.scene.scene import Scene, make_scene
from tests.engine.gltf_models import Model

#: Base colours of the left and the right half, and the colours of the vertices of the left, corner by corner.
LEFT, RIGHT = (0.8, 0.4, 0.2), (0.1, 0.6, 0.9)
COLOURS = np.array([[1.0, 0.2, 0.5], [0.4, 1.0, 0.1], [0.3, 0.6, 1.0], [0.9, 0.8, 0.7]])

#: Corners of the left half; those of the right lie one to the right.
CORNERS = np.array([[-1.0, -1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])

THETA_DEG, IRRADIANCE, SIZE = 30.0, 2.0, 16


def diffuse(name: str, colour: tuple[float, ...]) -> dict[str, Any]:
    """A material that is Lambertian but for what Schlick's law adds at grazing angles: f0 is 0."""
    pbr = {"baseColorFactor": [*colour, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.3}
    specular = {"KHR_materials_specular": {"specularFactor": 0.0}}
    return {"name": name, "pbrMetallicRoughness": pbr, "extensions": specular}


@pytest.fixture(scope="module")
def two_halves(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The right half first in the file, and with the second of its materials."""
    model = Model(materials=[diffuse("left", LEFT), diffuse("right", RIGHT)])
    model.add(CORNERS + np.array([1.0, 0.0, 0.0]), [[0, 1, 2], [0, 2, 3]], material=1)
    model.add(CORNERS, [[0, 1, 2], [0, 2, 3]], material=0, COLOR_0=COLOURS)
    path = tmp_path_factory.mktemp("model") / "halves.gltf"
    path.write_text(json.dumps(model.tree))
    return path


@pytest.fixture(scope="module")
def scene(two_halves: Path) -> Scene:
    """The halves seen head-on, 2 × 2 over the whole image."""
    camera = Camera((0.0, 0.0, 10.0), (0.0, 0.0, 0.0), fov_deg=float(np.degrees(2.0 * np.arctan(0.1))))
    light = (0.0, np.sin(np.radians(THETA_DEG)), np.cos(np.radians(THETA_DEG)))
    material = open_material(two_halves, parts=True)
    return make_scene(read_mesh(two_halves), camera, material=material, light=light, irradiance=IRRADIANCE)


def expected() -> NDArray[np.float64]:
    """Lambert's law at the centres of pixels, with colours that are linear in each triangle."""
    centre = (np.arange(SIZE) + 0.5) * 2.0 / SIZE - 1.0
    x, y = np.meshgrid(centre, -centre)
    u, v = x + 1.0, (y + 1.0) / 2.0  # within the left half
    below = (1.0 - u)[..., None] * COLOURS[0] + (u - v)[..., None] * COLOURS[1] + v[..., None] * COLOURS[2]
    above = (1.0 - v)[..., None] * COLOURS[0] + u[..., None] * COLOURS[2] + (v - u)[..., None] * COLOURS[3]
    tinted = np.where((u > v)[..., None], below, above) * LEFT
    base = np.where((x < 0.0)[..., None], tinted, RIGHT)
    return base / np.pi * np.cos(np.radians(THETA_DEG)) * IRRADIANCE


@pytest.mark.parametrize("mode", ["shading-map", "direct"])
def test_parts_and_colours_of_vertices_follow_lamberts_law(gl: Any, scene: Scene, mode: str) -> None:
    shown = MODES[mode].adapt(scene)
    on_cpu = drain(radiance(shown, (SIZE, SIZE), samples=1))
    renderer = DirectRenderer(gl)
    on_device = renderer.radiance(shown, (SIZE, SIZE), samples=1)
    renderer.release()
    for image in (on_cpu, on_device):
        assert image[..., :3] == pytest.approx(expected(), rel=1e-3, abs=1e-4)
        assert (image[..., 3] == 1.0).all()
    assert on_device == pytest.approx(on_cpu, rel=1e-3, abs=1e-5)


def test_another_brdf_takes_the_place_of_all_parts(scene: Scene) -> None:
    assert MODES["direct"].adapt(dataclasses.replace(scene, brdf=brdf_from_text("lambert"))).material is None


def test_the_reference_shows_parts_and_colours_of_vertices(scene: Scene) -> None:
    image = drain(reference(scene, (SIZE, SIZE), samples=16)).image
    difference = image[..., :3] / expected() - 1.0
    assert np.abs(difference.mean(axis=(0, 1))).max() < 5e-3
    assert np.abs(difference).max() < 0.1  # of colours that change within a pixel


def test_a_material_is_chosen_by_name_and_which_one_is_taken_is_said(two_halves: Path) -> None:
    chosen = open_material(f"{two_halves}#right")
    assert chosen.pbr is not None
    assert (chosen.name, chosen.parts) == ("right", ())
    assert chosen.pbr.base_colour[0, 0] == pytest.approx(RIGHT)
    taken = open_material(two_halves)
    assert "of 2 materials, 'left' is taken; halves.gltf#NAME chooses another one" in taken.health.warnings


def test_parts_without_a_known_name_have_the_material_itself(scene: Scene) -> None:
    assert scene.material is not None
    assert [part.health.warnings for part in scene.material.parts] == [[], []]
    only_left = dataclasses.replace(scene.material, parts=scene.material.parts[:1])
    named = {each.material.name for each in dataclasses.replace(scene, material=only_left).parts if each.material}
    assert named == {"left"}


def test_mitsuba_draws_the_same(scene: Scene) -> None:
    try:
        mitsuba = importlib.import_module("mitsuba")
    except (ImportError, NameError) as error:
        pytest.skip(f"Mitsuba cannot be loaded: {error}")
    mitsuba.set_variant("scalar_rgb")

    def half(corners: NDArray[np.float64], colours: NDArray[np.float64]) -> Any:
        bsdf = {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "vertex_color"}}
        properties = mitsuba.Properties()
        properties["bsdf"] = mitsuba.load_dict(bsdf)
        mesh = mitsuba.Mesh("half", 4, 2, props=properties)
        parameters = mitsuba.traverse(mesh)
        parameters["vertex_positions"] = corners.astype(np.float32).ravel()
        parameters["faces"] = np.array([0, 1, 2, 0, 2, 3], np.uint32)
        parameters.update()
        mesh.add_attribute("vertex_color", 3, colours.astype(np.float32).ravel())
        return mesh

    look_at = mitsuba.ScalarTransform4f().look_at([0, 0, 10], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    away = [-each for each in scene.light]
    light = {"type": "directional", "direction": away, "irradiance": {"type": "rgb", "value": [IRRADIANCE] * 3}}
    content = {
        "type": "scene",
        "integrator": {"type": "direct"},
        "sensor": {"type": "perspective", "fov": scene.camera.fov_deg, "to_world": look_at, "film": film},
        "light": light,
        "left": half(CORNERS, COLOURS * LEFT),
        "right": half(CORNERS + np.array([1.0, 0.0, 0.0]), np.tile(RIGHT, (4, 1))),
    }
    theirs = np.array(mitsuba.render(mitsuba.load_dict(content), spp=64, seed=1))
    ours = drain(radiance(scene, (SIZE, SIZE), samples=4))[..., :3]
    assert np.abs(ours / theirs - 1.0).max() < 0.03
    assert np.abs((ours / theirs - 1.0).mean(axis=(0, 1))).max() < 2e-3
