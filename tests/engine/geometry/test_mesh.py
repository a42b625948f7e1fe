"""Reading meshes, filling in what they lack, and the built-in models."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.geometry.mesh import Mesh, complete, read_mesh
from engine.geometry.mesh_repair import usable_faces
from engine.geometry.obj import _face_indices
from engine.geometry.shapes import SHAPES, open_mesh, shape

CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 2) for y in (0, 2) for z in (0, 2)) + (
    "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
)


def write(folder: Path, text: str, name: str = "model.obj") -> Path:
    path = folder / name
    path.write_text(text)
    return path


def texel_density(mesh: Mesh) -> np.ndarray:
    """Square root of uv area over surface area, of each triangle."""
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    p, q, r = (mesh.uv[mesh.faces[:, corner]].astype(float) for corner in range(3))
    across, down = q - p, r - p
    area = np.abs(across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0])
    return np.sqrt(area / np.linalg.norm(np.cross(b - a, c - a), axis=1))


def test_a_cube_without_anything_gets_flat_normals_and_even_texture(tmp_path: Path) -> None:
    mesh = read_mesh(write(tmp_path, CUBE))
    assert len(mesh.faces) == 12
    assert len(mesh.positions) == 24
    outward = np.sum(mesh.normals * (mesh.positions - 1.0), axis=1)
    assert outward == pytest.approx(np.ones(24))
    assert texel_density(mesh) == pytest.approx(np.full(12, 0.5), rel=1e-6)


@pytest.mark.parametrize(("slope", "shared"), [(0.5, True), (2.0, False)])
def test_smooth_normals_are_weighted_by_area_up_to_a_sharp_edge(slope: float, shared: bool) -> None:
    positions = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, -1.0, -slope], [4, -1.0, -slope]])
    faces = np.array([[0, 1, 2], [0, 3, 1]])
    arrays = complete(positions, faces, None, None, "x")
    sum_of_areas = np.array([[0, 0, 16.0], [0, -4.0 * slope, 4.0]]).sum(0)
    weighted = np.isclose(arrays["normals"], sum_of_areas / np.linalg.norm(sum_of_areas), atol=1e-6).all(axis=1)
    assert np.sum(weighted) == (2 if shared else 0)
    assert len(arrays["positions"]) == (4 if shared else 6)


def test_V6_unusable_faces_are_dropped_and_counted() -> None:
    positions = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [np.nan, 0, 0], [1e300, 1e300, 0], [2, 0, 0], [0.5, 1e-9, 0], [1, 0, 0]]
    )
    faces = np.array(
        [[0, 1, 2], [0, 1, 9], [-1, 1, 2], [0, 1, 3], [0, 1, 5], [0, 0, 2], [0, 1, 4], [0, 5, 6], [1, 2, 0], [0, 7, 2]]
    )
    usable, counts = usable_faces(positions, faces)
    assert faces[usable].tolist() == [[0, 1, 2]]
    assert counts == {
        "faces_with_wrong_indices_dropped": 2,
        "faces_with_non_finite_vertices_dropped": 2,
        "faces_without_area_dropped": 2,
        "needles_dropped": 1,
        "repeated_faces_dropped": 2,
    }
    assert sum(counts.values()) + usable.sum() == len(faces)


@pytest.mark.parametrize("scale", [1e-12, 1e-6, 2.0**-20, 1.0, 2.0**20, 1e6, 1e12])
def test_V12_units_do_not_decide_what_is_dropped(scale: float) -> None:
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 1e-9, 0], [0.5, 1e-7, 0]]) * scale
    usable, counts = usable_faces(positions, np.array([[0, 1, 2], [0, 1, 3], [0, 1, 4]]))
    assert usable.tolist() == [True, False, True]
    assert counts["needles_dropped"] == 1


def test_what_was_dropped_is_said(tmp_path: Path) -> None:
    mesh = read_mesh(write(tmp_path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\nf 1 2 4\n"))
    assert len(mesh.faces) == 1
    assert mesh.health.warnings[0] == "1 face with non-finite vertices excluded"


def test_the_file_s_own_normals_decide_which_side_is_outside() -> None:
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])
    arrays = complete(positions, np.array([[0, 1, 2]]), np.tile([[0, 0, -1.0]], (3, 1)), None, "x")
    a, b, c = arrays["positions"][arrays["faces"][0]]
    assert np.cross(b - a, c - a)[2] < 0
    assert arrays["normals"][:, 2] == pytest.approx([-1.0] * 3)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("empty.obj", "", "empty"),
        ("points.obj", "v 0 0 0\nv 1 1 1\n", "no triangles"),
        ("needle.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no usable triangle .1 face without area"),
        ("wrong.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nf 1 2 9\n", "no usable triangle .1 face with wrong indices"),
        ("zero.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nf 0 1 2\n", "1 face with wrong indices"),
        ("one.obj", "v 0 0 0\n", "no triangles"),
        ("line.obj", "v 0 0 0\nv 1 0 0\nl 1 2\nf 1 2\nf 1\n", "no triangles"),
        ("half.obj", "v 0 0 0\nv 1 0 0\nv 2 1 0\nf 1 2 2.5\n", "line 4 is not a whole number"),
        ("letter.obj", "v 0 0 0\nv 1 x 0\nv 2 1 0\nf 1 2 3\n", "'x' in line 2 is not a number"),
        ("short.obj", "v 0 0\nv 1 0\nv 2 1\nf 1 2 3\n", "missing in line 1"),
        ("tiny.obj", "v 0 0 0\nv 1e-320 0 0\nv 0 1e-320 0\nf 1 2 3\n", "too small"),
        ("model.3mf", "PK", "Export it as"),
        ("model.step", "ISO-10303-21;", "tessellated"),
        ("model.dae", "<COLLADA/>", "as .glb"),
        ("cloud.xyz", "0 0 0", "points"),
        ("models.zip", "PK", "Unpack"),
        ("noise.glb", "this is not a mesh", "damaged"),
        ("picture.jpg", "x", "not a mesh"),
        ("lies.off", "OFF\n999999999999 1 0\n0 0 0\n3 0 1 2\n", "damaged"),
    ],
)
def test_bad_files_are_input_errors(tmp_path: Path, name: str, text: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_mesh(write(tmp_path, text, name))


def test_an_unknown_model_names_the_known_ones() -> None:
    with pytest.raises(InputError, match="torus-knot"):
        open_mesh("teapot")


@pytest.mark.parametrize("name", ["classic/spot.obj", "nasty_trimesh/Duck.glb", "nasty_assimp/spider.obj"])
def test_real_files_keep_their_texture_coordinates(shared_data: Callable[[str], Path], name: str) -> None:
    mesh = read_mesh(shared_data(f"mesh/{name}"))
    assert mesh.health.figures["texture_coordinates_made"] == 0
    assert np.ptp(mesh.uv, axis=0).min() > 0.1


@pytest.mark.parametrize(
    ("name", "faces"), [("classic/stanford-bunny.obj", 69451), ("nasty_trimesh/20mm-xyz-cube.stl", 260)]
)
def test_real_files_without_them_get_an_even_texture(shared_data: Callable[[str], Path], name: str, faces: int) -> None:
    mesh = read_mesh(shared_data(f"mesh/{name}"))
    assert len(mesh.faces) == faces
    unit = texel_density(mesh) * np.ptp(mesh.positions, axis=0).max()
    assert unit.min() > 0.7
    assert unit.max() < 1.02
    assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(np.ones(len(mesh.normals)), abs=1e-6)


@pytest.mark.parametrize("name", SHAPES)
def test_built_in_models_are_sound(name: str) -> None:
    mesh = shape(name)
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    assert np.all(np.sum(np.cross(b - a, c - a) * mesh.normals[mesh.faces].sum(axis=1), axis=1) > 0)
    p, q, r = (mesh.uv[mesh.faces[:, corner]].astype(float) for corner in range(3))
    assert np.all((q - p)[:, 0] * (r - p)[:, 1] - (q - p)[:, 1] * (r - p)[:, 0] > -1e-12), "a mirrored texture"
    assert 0.8 < mesh.radius < 2.5
    assert not mesh.positions.flags.writeable


def test_the_sphere_is_a_sphere_and_closed() -> None:
    mesh = shape("sphere")
    assert np.linalg.norm(mesh.positions, axis=1) == pytest.approx(np.ones(len(mesh.positions)))
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    assert np.sum(a * np.cross(b, c)) / 6 == pytest.approx(4 / 3 * np.pi, rel=1e-3)


def test_a_mesh_that_does_not_fit_together_is_refused() -> None:
    good = shape("plane")
    with pytest.raises(ValueError, match="faces"):
        Mesh(good.positions, good.normals, good.uv, np.array([[0, 1, 4]], np.int32), "x")
    with pytest.raises(ValueError, match="fit"):
        Mesh(good.positions, good.normals[:3], good.uv, good.faces, "x")


def test_an_index_that_float64_rounds_names_no_vertex() -> None:
    numbers = [b"9007199254740993", b"9007199254740991", b"-9007199254740993"]
    assert _face_indices(([1], [b" ".join(numbers)]), "x.obj")[1][:, 0].tolist() == [0, 2**53 - 1, 0]
