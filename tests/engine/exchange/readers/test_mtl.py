"""Materials of OBJ models: each face with its own, by hand, and what is missing or not drawn is said."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.bundle.bundle import save_bundle
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.exchange.readers.read import find_doubt_of_parts, open_material
from engine.geometry.camera import Camera
from engine.geometry.mesh import read_mesh
from engine.gl.direct import DirectRenderer
from engine.render.direct import radiance
from engine.render.reference import reference
from engine.scene.material import Material
from engine.scene.scene import Scene

from .images import grey, png

OBJ = """mtllib parts.mtl
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vt 0 0
vt 1 0
vt 0 1
f 1/1 2/2 3/3
usemtl red paint
f 1/1 2/2 4/3
usemtl worn
f 1/1 3/2 4/3
usemtl red paint
f 2/1 3/2 4/3
usemtl lost
f 3/1 2/2 1/3
"""

MTL = """# comment
newmtl red paint
Kd 0.5 0.25 0.125
Ks 0.5 0.5 0.5
Ns 98
illum 2
d 0.5

newmtl worn
Kd 1 1 1
map_Kd -s 2 2 1 maps\\\\base.png
Pr 0.25
Pm 1.0
map_Bump -bm 0.5 maps/relief.png
Ke 0 0 0
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    (tmp_path / "parts.obj").write_text(OBJ)
    (tmp_path / "parts.mtl").write_text(MTL)
    for name in ("base", "relief"):
        png(tmp_path / "maps" / f"{name}.png", grey(255))
    return tmp_path / "parts.obj"


def test_udim_tiles_lie_where_texture_coordinates_say(tmp_path: Path, gl: Any) -> None:
    """A square over 2 × 3 tiles beside a texture that has none, under one lamp that faces it: each sixth its colour."""
    tiles = {1001: (255, 0, 0), 1002: (0, 255, 0), 1011: (0, 0, 255), 1021: (255, 255, 0), 1022: (0, 255, 255)}
    for number, colour in tiles.items():
        png(tmp_path / f"base.{number}.png", np.full((4, 4, 3), colour))
    png(tmp_path / "metal.png", grey(0))
    corners = "v 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\nvt 0 0\nvt 2 0\nvt 2 3\nvt 0 3\n"
    (tmp_path / "square.obj").write_text(f"mtllib square.mtl\n{corners}usemtl a\nf 1/1 2/2 3/3 4/4\n")
    (tmp_path / "square.mtl").write_text("newmtl a\nmap_Kd base.<UDIM>.png\nPr 1\nmap_Pm metal.png\n")
    material, mesh = open_material(tmp_path / "square.obj", parts=True), read_mesh(tmp_path / "square.obj")
    assert material.pbr is not None
    assert (material.pbr.tiles, material.pbr.size) == (3, (12, 12))
    assert any("3 × 3 tiles" in words for words in material.health.warnings)
    saved = open_material(drain(save_bundle(tmp_path / "square.lightarc", material)))
    assert saved.pbr is not None
    assert saved.pbr.tiles == 3
    camera = Camera((1.0, 1.5, 4.0), (1.0, 1.5, 0.0), (0.0, 1.0, 0.0), 41.11)  # 3 high
    scene = Scene(mesh, camera, material.reflectance, material, light=(0.0, 0.0, 1.0), irradiance=np.pi, repeats=1.0)
    renderer = DirectRenderer(gl)
    images = (
        drain(radiance(scene, (12, 12))),
        renderer.radiance(scene, (12, 12)),
        drain(reference(scene, (12, 12))).image,
    )
    renderer.release()
    for (column, row), number in {
        (0, 0): 1001,
        (1, 0): 1002,
        (0, 1): 1011,
        (1, 1): 1001,
        (0, 2): 1021,
        (1, 2): 1022,
    }.items():
        for image in images:
            found = image[11 - 4 * row - 1, 2 + 4 * column + 2, :3]  # within the tile
            assert np.argsort(found > 0.3).tolist() == np.argsort(np.array(tiles.get(number)) > 0).tolist()


def test_a_set_of_udim_tiles_without_any_is_named(model: Path) -> None:
    library = model.with_suffix(".mtl")
    library.write_text(MTL.replace("maps\\\\base.png", "maps/base.<UDIM>.png"))
    with pytest.raises(InputError, match=r"base\.1001\.png"):
        open_material(model, parts=True)


def part(material: Material, name: str) -> Material:
    return next(each for each in material.parts if each.name == name)


def test_each_face_has_the_material_that_stands_before_it(model: Path) -> None:
    mesh = read_mesh(model)
    assert mesh.part_names == ("no material", "red paint", "worn", "lost")
    assert mesh.part is not None
    assert mesh.part.tolist() == [0, 1, 2, 1, 3]


def test_libraries_give_base_colour_highlight_and_metal(model: Path) -> None:
    """An exponent of 98 is GGX of alpha = √(2 / 100); Ks of 0.5 is the f0 of 0.04."""
    opened = open_material(model, parts=True)
    paint, worn = part(opened, "red paint"), part(opened, "worn")
    assert paint.pbr is not None
    assert worn.pbr is not None
    assert paint.pbr.base_colour[0, 0] == pytest.approx((0.5, 0.25, 0.125))
    assert paint.pbr.roughness[0, 0] == pytest.approx(0.02**0.25)
    assert (paint.pbr.f0[0, 0], paint.pbr.metallic[0, 0]) == (pytest.approx(0.04), 0.0)
    assert worn.pbr.base_colour[0, 0] == pytest.approx((1.0, 1.0, 1.0))
    assert (worn.pbr.roughness[0, 0], worn.pbr.metallic[0, 0]) == (0.25, 1.0)
    assert paint.health.warnings == ["opacity is not drawn"]
    assert worn.health.warnings == ["the relief of map_bump is not drawn", "-s of map_kd is passed over"]
    assert part(opened, "lost").health.warnings == ["is in no library of the model, and drawn white"]
    assert (opened.name, open_material(f"{model}#red paint").name) == ("worn", "red paint")
    assert "of 3 materials, 'worn' is taken; parts.obj#NAME chooses another one" in opened.health.warnings


@pytest.mark.parametrize(
    ("kd", "colour", "notes"),
    [
        ("Kd 0 0 0\n", 1.0, ["Kd is 0 and is taken as 1 under map_Kd"]),
        ("", 1.0, []),
        ("Kd 0.5 0.5 0.5\n", 0.5, []),
    ],
)
def test_an_image_is_not_black_by_a_colour_that_programs_ignore(
    model: Path, kd: str, colour: float, notes: list[str]
) -> None:
    (model.parent / "parts.mtl").write_text(f"newmtl worn\n{kd}map_Kd maps/base.png\n")
    worn = part(open_material(model, parts=True), "worn")
    assert worn.pbr is not None
    assert worn.pbr.base_colour[0, 0] == pytest.approx((colour,) * 3)
    assert worn.health.warnings == notes


def test_a_model_without_its_library_says_so(model: Path) -> None:
    assert find_doubt_of_parts(model) is None
    (model.parent / "parts.mtl").unlink()
    doubt = find_doubt_of_parts(model)
    assert doubt == "is drawn without its materials: it needs the file 'parts.mtl' next to it, which does not exist"
    for wrong in ("../parts.mtl", "/etc/passwd"):
        model.write_text(OBJ.replace("parts.mtl", wrong))
        with pytest.raises(InputError, match="outside its folder"):
            open_material(model)


def test_libraries_and_their_images_may_lie_below_a_folder_that_is_named(model: Path) -> None:
    kept = model.parent / "kept"
    kept.mkdir()
    for name in ("parts.mtl", "maps"):
        (model.parent / name).rename(kept / name)
    assert find_doubt_of_parts(model) != find_doubt_of_parts(model, kept) is None
    with pytest.raises(InputError, match=r"parts\.mtl"):
        open_material(model, parts=True)
    found = open_material(model, parts=True, search=kept)
    assert [each.name for each in found.parts][:2] == ["red paint", "worn"]
