"""Meshes as real programs write them, odd ones and hostile ones: each is read right, or refused in a sentence."""

from __future__ import annotations

import base64
import importlib.util
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from engine.core.errors import InputError
from engine.exchange.readers.read import open_material
from engine.geometry import obj
from engine.geometry.mesh import INSTEAD, Mesh, decode_mesh, read_mesh
from engine.geometry.obj import read_obj
from engine.geometry.polygons import Polygons, triangulate
from engine.geometry.read_scene import check_memory, estimate_faces
from engine.storage.readers import suffixes
from tests.engine.gltf_models import Model

HAS_DRACO = importlib.util.find_spec("DracoPy") is not None

TRIANGLE = b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], np.float32)


def read(folder: Path, name: str, content: bytes) -> Mesh:
    path = folder / name
    path.write_bytes(content)
    return read_mesh(path)


def area(mesh: Mesh) -> float:
    a, b, c = (mesh.positions[mesh.faces[:, corner]] for corner in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


@pytest.mark.parametrize(
    ("text", "faces"),
    [
        (b"mtllib ../../secret.mtl\no a\ng b c\nusemtl none\ns off\n" + TRIANGLE + b"f 1 2 3\n", 1),
        (TRIANGLE + b"vt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\n", 1),
        (TRIANGLE + b"vn 0 0 1\nf 1//1 2//1 3//1\n", 1),
        (TRIANGLE + b"vn 0 0 1\nv 1 1 0\nf 1//1 2//1 3//1\nf 2 4 3\n", 2),
        (TRIANGLE + b"vt 0 0\nf 1/1/ 2/1/ 3/1/\n", 1),
        (TRIANGLE + b"f 1/7/9 2/7/9 3/7/9\n", 1),
        (TRIANGLE + b"f -3 -2 -1\nv 1 1 0\nf -3 -1 -2\n", 2),
        (TRIANGLE.replace(b"\n", b"\r\n") + b"f 1 2 3\r\n", 1),
        (TRIANGLE.replace(b"\n", b"\r") + b"f 1 2 3\r", 1),
        (TRIANGLE.replace(b" ", b"\t  ") + b"   f  1   2\t3   # the only one", 1),
        (b"\xef\xbb\xbf# made by hand\n" + TRIANGLE + b"f 1 2 3", 1),
        (b"v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0.5\nf 1 2 3\n", 1),
        (TRIANGLE + b"f 1 2 \\\n3\n", 1),
        (TRIANGLE + b"l 1 2\np 1\nf 1 2\nf 1\nf\nf 1 2 3\n", 1),
        (TRIANGLE + b"#" + b"x" * 100_000 + b"\nf 1 2 3\n", 1),
        (TRIANGLE + b"v 5 5 1.#QNAN\nv -nan(ind) 0 0\nf 1 2 3\nf 1 2 4\n", 1),
        (TRIANGLE + b"v 1e-320 -1e-310 5e-324\nf 4 2 3\n", 1),
        (TRIANGLE + b"f 1 2 3\nf 1 2 99999999999999999999\nf 1 2 0\nf 1 2 -9\n", 1),
        (TRIANGLE + b"f 1 2 3\nf 2 3 1\nf 3 2 1\n", 2),
    ],
)
def test_V12_obj_as_programs_write_it(tmp_path: Path, text: bytes, faces: int) -> None:
    mesh = read(tmp_path, "a.obj", text)
    assert len(mesh.faces) == faces
    assert area(mesh) == pytest.approx(0.5 * faces)


def test_an_obj_is_the_same_model_in_blocks_of_any_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Indices that count backwards, colours of some points and names of materials reach over blocks."""
    text = (
        b"usemtl a\n" + TRIANGLE + b"v 1 1 0 .5 .5 .5\nvt 0 0\nvn 0 0 1\nf 1/1 2/1 3/1\nusemtl b\nf -3//1 -1//-1 3//1\n"
    )
    whole = read(tmp_path, "a.obj", text)
    monkeypatch.setattr(obj, "BLOCK_BYTES", 9)
    blocks = read_obj(text, "a.obj")
    monkeypatch.setattr(obj, "BLOCK_BYTES", 1 << 22)
    for name, each in vars(read_obj(text, "a.obj")).items():
        np.testing.assert_array_equal(getattr(blocks, name), each)
    assert (len(whole.faces), blocks.part_names) == (2, ("a", "b"))


@pytest.mark.parametrize(
    ("face", "words"),
    [
        (b"f 1 2 3\nf /1 2/1 3/1", "line 5 gives a corner without a point"),
        (b"f 1/1/1/1 2 3", "line 4 .* too many parts"),
    ],
)
def test_an_obj_with_corners_that_cannot_be_names_their_line(face: bytes, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read_obj(TRIANGLE + face, "a.obj")


@pytest.mark.parametrize("kind", ["obj", "ply", "ply-bytes"])
def test_colours_of_vertices_are_read_as_srgb(tmp_path: Path, kind: str) -> None:
    codes = np.array([[255, 0, 51], [0, 102, 255], [128, 128, 0]])
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    if kind == "obj":
        rows = [
            f"v {x} {y} {z} {r / 255} {g / 255} {b / 255}" for (x, y, z), (r, g, b) in zip(points, codes, strict=True)
        ]
        content = "\n".join([*rows, "v 7 7 7", "f 1 2 3"]).encode()
    else:
        names = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue"))
        form = "ascii" if kind == "ply" else "binary_little_endian"
        head = f"ply\nformat {form} 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        head += f"{names}element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        rows = [" ".join(map(str, row)) for row in np.hstack([points, codes]).tolist()]
        body = "\n".join([*rows, "3 0 1 2"]).encode()
        if kind == "ply-bytes":
            pairs = zip(points.tolist(), codes.tolist(), strict=True)
            body = b"".join(struct.pack("<3f3B", *point, *colour) for point, colour in pairs)
            body += struct.pack("<B3i", 3, 0, 1, 2)
        content = head.encode() + body
    mesh = read(tmp_path, f"a.{kind[:3]}", content)
    assert mesh.colours is not None
    assert mesh.part_names == ("no material",)
    share = codes / 255
    wanted = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(mesh.colours[np.lexsort(mesh.positions.T)], wanted[np.lexsort(points.T)], atol=1e-6)
    material = open_material(tmp_path / f"a.{kind[:3]}", parts=True)
    assert [each.name for each in material.parts] == ["no material"]
    assert material.pbr is not None
    assert np.all(material.pbr.base_colour == 1.0)


def test_faces_without_texture_coordinates_among_others_get_some(tmp_path: Path) -> None:
    text = TRIANGLE + b"v 5 5 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 2 4 3\n"
    mesh = read(tmp_path, "a.obj", text)
    assert mesh.uv[mesh.faces[0]].tolist() == [[0, 0], [1, 0], [0, 1]]
    assert "1 face without texture coordinates got those of a box" in mesh.health.warnings


STAR = [(np.cos(k * np.pi / 5) * (1, 0.4)[k % 2], np.sin(k * np.pi / 5) * (1, 0.4)[k % 2]) for k in range(10)]
ARROW = [(0, 0), (2, -1), (0.5, 0), (2, 1)]
COMB = [(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
HOUSE = [(0, 0), (1, 0), (1, 0.5), (1, 1), (0.5, 2), (0, 1)]


def shoelace(outline: list[tuple[float, float]]) -> float:
    x, y = np.array(outline, float).T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2.0)


def write(kind: str, points: np.ndarray, polygons: list[list[int]]) -> bytes:
    """A file of `kind` with these polygons, written here and not by what is tested."""
    if kind == "obj":
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
        return "\n".join(lines + ["f " + " ".join(str(1 + c) for c in one) for one in polygons]).encode()
    lines = [f"{x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += [" ".join(map(str, [len(one), *one])) for one in polygons]
    if kind == "off":
        return "\n".join(["OFF", f"{len(points)} {len(polygons)} 0", *lines]).encode()
    header = (
        f"ply\nformat {{}} 1.0\ncomment x\nelement vertex {len(points)}\nproperty double x\nproperty double y\n"
        f"property double z\nelement face {len(polygons)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    if kind == "ply":
        return "\n".join([header.format("ascii")[:-1], *lines]).encode()
    order = "<" if kind == "ply-little" else ">"
    body = points.astype(order + "f8").tobytes()
    body += b"".join(struct.pack(f"{order}B{len(one)}i", len(one), *one) for one in polygons)
    return header.format(f"binary_{kind.removeprefix('ply-')}_endian").encode() + body


@pytest.mark.parametrize("kind", ["obj", "off", "ply", "ply-little", "ply-big"])
@pytest.mark.parametrize("turn", [0, 1, 3])
@pytest.mark.parametrize("outline", [ARROW, STAR, COMB, HOUSE], ids=["arrow", "star", "comb", "house"])
def test_V12_polygons_with_inward_corners_are_cut_right(
    kind: str, turn: int, outline: list[tuple[float, float]]
) -> None:
    flat = np.array([*outline[turn:], *outline[:turn]], float)
    points = np.concatenate([np.stack([flat[:, 1], 0 * flat[:, 0], flat[:, 0]], -1), [[9, 9, 9], [9, 8, 9], [8, 8, 8]]])
    count = len(outline)
    content = write(kind, points, [list(range(count)), [count, count + 1, count + 2]])
    reply = decode_mesh(content, f"a.{kind.split('-')[0]}")
    a, b, c = (reply["positions"][reply["faces"][:, corner]] for corner in range(3))
    directed = np.cross(b - a, c - a) / 2.0
    assert len(reply["faces"]) >= count - 2
    assert directed[:-1, 1].min() > 0.0
    assert directed[:-1, 1].sum() == pytest.approx(shoelace(outline))


@settings(max_examples=80)
@given(st.integers(0, 2**32 - 1), st.integers(3, 40))
def test_any_polygon_gives_two_triangles_less_than_corners(seed: int, corners: int) -> None:
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.random(corners)) * 2 * np.pi
    radius = rng.random(corners) + 0.05
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(corners)], -1)
    if seed % 4 == 0:
        points = rng.integers(0, 3, (corners, 3)).astype(float)
    triangles = triangulate(Polygons(points, np.arange(corners), np.array([corners])))
    assert triangles.shape == (corners - 2, 3)
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    whole = np.sum(np.cross(points, np.roll(points, -1, axis=0)), axis=0)
    assert np.sum(np.cross(b - a, c - a), axis=0) == pytest.approx(whole, abs=1e-9)
    if seed % 4 and np.diff(angle, append=angle[0] + 2 * np.pi).max() < np.pi:
        assert np.cross(b - a, c - a)[:, 2].min() > -1e-9


def ply(body: bytes, *header: str, kind: str = "ascii") -> bytes:
    return "\n".join(["ply", f"format {kind} 1.0", *header, "end_header", ""]).encode() + body


XYZ = ("property float x", "property float y", "property float z")


def test_ply_with_more_than_it_needs(tmp_path: Path) -> None:
    vertex = np.zeros(3, [("p", "<f4", 3), ("n", "<f4", 3), ("c", "u1", 3), ("uv", "<f4", 2)])
    vertex["p"], vertex["n"], vertex["uv"] = CORNERS[:3], (0, 0, 1), CORNERS[:3, :2]
    face = struct.pack("<iB3I2f", 7, 3, 0, 1, 2, 0.5, 0.5)
    header = (
        "element vertex 3", *XYZ, *(f"property float n{axis}" for axis in "xyz"),
        *(f"property uchar {colour}" for colour in ("red", "green", "blue")), "property float s", "property float t",
        "element face 1", "property int flags", "property list uchar uint vertex_index", "property float quality",
        "property float extra", "element camera 1", "property double f", "property list ushort short odd",
    )  # fmt: skip
    body = vertex.tobytes() + face + struct.pack("<dH2h", 1.0, 2, 3, 4)
    mesh = read(tmp_path, "a.ply", ply(body, *header, kind="binary_little_endian"))
    assert mesh.uv[mesh.faces[0]].tolist() == CORNERS[:3, :2].tolist()
    assert mesh.normals.tolist() == [[0, 0, 1]] * 3


def test_ply_in_strips_and_with_texture_at_corners(tmp_path: Path) -> None:
    points = "\n".join(f"{x} {y} 0" for x in range(4) for y in range(2))
    strips = ("element vertex 8", *XYZ, "element tristrips 1", "property list int int vertex_indices")
    mesh = read(tmp_path, "a.ply", ply(f"{points}\n9 0 2 1 3 -1 4 6 5 7\n".encode(), *strips))
    assert (len(mesh.faces), area(mesh)) == (4, 2.0)
    assert mesh.health.figures["clashing_edges"] == 0
    assert mesh.normals[:, 2].tolist() == [1.0] * 8
    wedge = ("element vertex 3", *XYZ, "element face 1", "property list uchar int vertex_indices",
             "property list uchar float texcoord")  # fmt: skip
    mesh = read(tmp_path, "b.ply", ply(b"0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0 0 1 0 0 1\n", *wedge))
    assert mesh.uv[mesh.faces[0]].tolist() == [[0, 0], [1, 0], [0, 1]]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"not a ply", "no PLY header"),
        (ply(b"", "element vertex 3", *XYZ, kind="binary_middle_endian"), "format"),
        (ply(b"", "element vertex 999999999999", *XYZ, "element face 0"), "announce"),
        (ply(b"0 0 0\n", "element vertex -1", *XYZ), "header says"),
        (ply(b"0 0 0\n", "property float x", "element vertex 1"), "header says|has no|damaged"),
        (ply(b"0 0 0\n", "element vertex 1", "property half x"), "unknown kind"),
        (ply(b"0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "element vertex 3", *XYZ, "element face 1",
             "property list uchar int vertex_indices"), "ends"),
        (ply(b"\0" * 36 + b"\xff" * 5, "element vertex 3", *XYZ, "element face 1",
             "property list int int vertex_indices", kind="binary_little_endian"), "list is|ends"),
    ],
)  # fmt: skip
def test_fault6_ply_headers_that_lie(tmp_path: Path, content: bytes, words: str) -> None:
    with pytest.raises(InputError, match=words):
        read(tmp_path, "a.ply", content)


@pytest.mark.parametrize(
    ("text", "faces"),
    [
        ("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", 1),
        ("OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", 1),
        ("# first\nOFF # here\n# more\n3 1 0\n\n0 0 0\n1 0 0 # x\n0 1 0\n3 0 1 2 255 0 0\n", 1),
        ("COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 0 255 0 255\n0 1 0 0 0 255 255\n3 0 1 2\n", 1),
        ("NOFF\n3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n3 0 1 2\n", 1),
        ("STOFF\n3 1 0\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n", 1),
        ("OFF\n3 3 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 9\n2 0 1\n", 1),
    ],
)
def test_off_with_all_its_headers(tmp_path: Path, text: str, faces: int) -> None:
    mesh = read(tmp_path, "a.off", text.encode())
    assert len(mesh.faces) == faces
    assert mesh.health.figures["texture_coordinates_made"] == float(not text.startswith("ST"))


@pytest.mark.parametrize(
    "text", ["3 1 0\n", "4OFF\n1 1 0\n0 0 0 0\n1 0\n", "OFF BINARY\n\0\0\0\3", "OFF\nx y\n", "OFF\n"]
)
def test_off_of_other_kinds_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError):
        read(tmp_path, "a.off", text.encode())


def test_stl_of_several_solids(tmp_path: Path) -> None:
    facet = "facet normal 0 0 1\nouter loop\nvertex {0} 0 0\nvertex 1 {0} 0\nvertex 0 1 {0}\nendloop\nendfacet\n"
    text = "".join(f"solid part {k}\n{facet.format(k)}endsolid part {k}\n" for k in range(3))
    for name in ("a.stl", "a.STL", "a.stl_ascii"):
        assert len(read(tmp_path, name, text.encode()).faces) == 3


def soup_of(triangles: np.ndarray) -> bytes:
    """A binary STL file of `triangles` (F, 3, 3)."""
    faces = np.arange(len(triangles) * 3).reshape(-1, 3)
    content: bytes = trimesh.Trimesh(triangles.reshape(-1, 3), faces, process=False).export(file_type="stl")
    return content


def test_a_seam_whose_sides_differ_by_rounding_is_closed(tmp_path: Path) -> None:
    """The sine of a full turn is no 0, so that the seam of a sphere was open, lit from both sides and creased."""
    around, down = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 17), np.linspace(0.0, np.pi, 9))
    points = np.stack([np.sin(down) * np.cos(around), np.sin(down) * np.sin(around), np.cos(down)], axis=-1)
    at = np.arange(points[..., 0].size).reshape(9, 17)
    corners = [at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, :-1], at[1:, 1:], at[:-1, 1:]]
    faces = np.stack(corners, axis=-1).reshape(-1, 3)
    sphere = trimesh.Trimesh(points.reshape(-1, 3), faces, process=False)
    sphere.update_faces(sphere.area_faces > 1e-6)
    for ending in ("ply", "glb"):
        found = read(tmp_path, f"a.{ending}", sphere.export(file_type=ending))
        assert found.topology.closed
        assert not found.health.warnings


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_an_stl_whose_corners_differ_by_rounding_is_closed(tmp_path: Path, size: float) -> None:
    """Each face has corners of its own, off by 1e-7 of the size; what is off by 1e-5 is apart."""
    solid = trimesh.creation.icosphere(subdivisions=3, radius=size / 2)
    random = np.random.default_rng(0)
    soup = solid.triangles + random.uniform(-1e-7, 1e-7, solid.triangles.shape) * size
    found = read(tmp_path, "a.stl", soup_of(soup))
    assert found.topology.closed
    assert len(found.faces) == len(solid.faces)
    assert any("close gaps" in finding.text for finding in found.health.findings)
    assert np.abs(np.linalg.norm(found.positions, axis=1) / (size / 2) - 1.0).max() < 2e-6
    soup[0] *= 1.0 + 1e-5
    assert read(tmp_path, "b.stl", soup_of(soup)).topology.open_edges == 6


def test_small_faces_of_an_stl_keep_their_area(tmp_path: Path) -> None:
    near = [[0.5, 0.5, 0], [0.5 + 2e-7, 0.5, 0], [0.5, 0.5 + 2e-7, 0]]
    soup = np.array([[[0, 0, 1], [1, 0, 1], [0, 1, 1]], near])
    assert len(read(tmp_path, "a.stl", soup_of(soup)).faces) == 2


def gltf(points: np.ndarray, *nodes: dict[str, Any], uri: str | None = None, **primitive: Any) -> dict[str, Any]:
    """A glTF tree with one mesh of the triangles (0, 1, 2) and (1, 3, 2), placed by `nodes`."""
    body = points.tobytes() + np.array([0, 1, 2, 1, 3, 2], np.uint16).tobytes()
    kind = {"float32": 5126, "int16": 5122}[points.dtype.name]
    data = "data:application/octet-stream;base64," + base64.b64encode(body).decode()
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(nodes) or 1))}],
        "nodes": [{"mesh": 0, **node} for node in nodes] or [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, **primitive}]}],
        "buffers": [{"byteLength": len(body), "uri": uri or data}],
        "bufferViews": [
            {"buffer": 0, "byteLength": points.nbytes},
            {"buffer": 0, "byteOffset": points.nbytes, "byteLength": 12},
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": kind,
                "count": len(points),
                "type": "VEC3",
                "min": [0] * 3,
                "max": [1] * 3,
            },
            {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
    }


def as_gltf(folder: Path, tree: dict[str, Any]) -> Mesh:
    return read(folder, "a.gltf", json.dumps(tree).encode())


def test_gltf_instances_and_mirrored_nodes(tmp_path: Path) -> None:
    nodes: Any = ({}, {"translation": [0, 0, 5]}, {"scale": [-1, 1, 1], "translation": [0, 0, 9]})
    mesh = as_gltf(tmp_path, gltf(CORNERS, *nodes))
    assert (len(mesh.faces), area(mesh)) == (6, 3.0)
    assert mesh.health.figures["components"] == 3
    assert mesh.normals[:, 2].tolist() == [1.0] * len(mesh.normals)
    assert sorted(set(mesh.positions[:, 2].tolist())) == [0.0, 5.0, 9.0]


def nest(levels: int) -> dict[str, Any]:
    """A triangle within `levels` nodes, each within the next and moved by 1."""
    tree = gltf(CORNERS)
    (leaf,) = tree["nodes"]
    groups = [{"translation": [1.0, 0.0, 0.0], "children": [at + 1]} for at in range(levels - 1)]
    return {**tree, "nodes": [*groups, leaf], "scenes": [{"nodes": [0]}]}


def test_gltf_with_nodes_within_nodes_is_read_to_a_hundred_levels(tmp_path: Path) -> None:
    flat = as_gltf(tmp_path, nest(1))
    assert np.allclose(as_gltf(tmp_path, nest(100)).positions - flat.positions, [99.0, 0.0, 0.0])
    for levels in (101, 20_000):  # trimesh's time is quadratic in them
        with pytest.raises(InputError, match="nodes within nodes over more than 100 levels"):
            as_gltf(tmp_path, nest(levels))


def test_gltf_with_nodes_in_a_circle_or_that_are_missing_is_damaged(tmp_path: Path) -> None:
    tree = nest(3)
    tree["nodes"][1]["children"] = [2, 1]
    with pytest.raises(InputError, match="in a circle"):
        as_gltf(tmp_path, tree)
    tree["nodes"][1]["children"] = [7]
    with pytest.raises(InputError, match="names node 7"):
        as_gltf(tmp_path, tree)
    with pytest.raises(InputError, match=r"has 100,001 nodes, more than 100,000"):
        as_gltf(tmp_path, {**tree, "nodes": [{}] * 100_001})


def test_gltf_keeps_texture_coordinates_without_a_material(tmp_path: Path) -> None:
    tree = gltf(CORNERS)
    uv = np.ascontiguousarray(CORNERS[:, :2])
    tree["buffers"].append({"byteLength": 32, "uri": "data:;base64," + base64.b64encode(uv.tobytes()).decode()})
    tree["bufferViews"].append({"buffer": 1, "byteLength": 32})
    tree["accessors"].append({"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"})
    tree["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = 2
    mesh = as_gltf(tmp_path, tree)
    assert mesh.health.figures["texture_coordinates_made"] == 0
    for position, (u, v) in zip(mesh.positions, mesh.uv, strict=True):
        assert (u, v) == (position[0], 1.0 - position[1])


def test_gltf_compressed_by_draco_is_that_without_compression(tmp_path: Path) -> None:
    """Written by the library itself, with attributes in another order than the vertices of the accessors."""
    draco = pytest.importorskip("DracoPy", reason="DracoPy is not installed")
    random = np.random.default_rng(3)
    points = random.normal(size=(40, 3)).astype(np.float32)
    faces = np.arange(39).reshape(13, 3).astype(np.uint32)
    uv = random.random((40, 2))
    plain, packed = Model(), Model(extensionsRequired=["KHR_draco_mesh_compression"])
    for model in (plain, packed):
        model.add(points, faces, TEXCOORD_0=uv)
    content = draco.encode(points, faces, quantization_bits=20, tex_coord=uv)
    packed.tree["buffers"].append({"uri": "data:;base64," + base64.b64encode(content).decode()})
    packed.tree["bufferViews"].append({"buffer": len(packed.tree["buffers"]) - 1, "byteLength": len(content)})
    for accessor in packed.tree["accessors"]:
        del accessor["bufferView"]
    known = {each["attribute_type"]: each["unique_id"] for each in draco.decode(content).attributes}
    extension = {"bufferView": len(packed.tree["bufferViews"]) - 1}
    attributes = {"POSITION": known[0], "TEXCOORD_0": known[3]}
    packed.primitives[0]["extensions"] = {"KHR_draco_mesh_compression": {**extension, "attributes": attributes}}
    packed.tree["accessors"][0]["count"] = packed.tree["accessors"][1]["count"] = len(draco.decode(content).points)
    wanted, found = (read(tmp_path, "a.gltf", json.dumps(model.tree).encode()) for model in (plain, packed))

    def rows(mesh: Mesh) -> np.ndarray:
        corners = np.concatenate([mesh.positions[mesh.faces], mesh.uv[mesh.faces]], axis=-1)
        first = np.argmin(corners[..., 0], axis=1)
        turned = np.stack([corners[np.arange(len(first)), (first + step) % 3] for step in range(3)], axis=1)
        return turned.reshape(len(first), -1)[np.argsort(turned[:, 0, 0])]

    np.testing.assert_allclose(rows(found), rows(wanted), atol=1e-4)
    packed.tree["accessors"][0]["count"] = 7
    with pytest.raises(InputError, match="not as many as it says"):
        read(tmp_path, "a.gltf", json.dumps(packed.tree).encode())


def test_gltf_with_its_numbers_in_a_file_beside_it(tmp_path: Path) -> None:
    tree = gltf(CORNERS, uri="my%20data/a.bin")
    with pytest.raises(InputError, match=r"needs the file 'my%20data/a.bin' next to it, which does not exist"):
        as_gltf(tmp_path, tree)
    (tmp_path / "my data").mkdir()
    (tmp_path / "my data" / "a.bin").write_bytes(CORNERS.tobytes() + np.array([0, 1, 2, 1, 3, 2], np.uint16).tobytes())
    assert len(as_gltf(tmp_path, tree).faces) == 2
    (tmp_path / "wide.gltf").write_text(json.dumps(tree), encoding="utf-16")
    assert len(read_mesh(tmp_path / "wide.gltf").faces) == 2


@pytest.mark.parametrize("how", ["up", "absolute", "link", "web", "file"])
def test_gltf_reads_nothing_outside_its_folder(tmp_path: Path, how: str) -> None:
    inside = tmp_path / "inside"
    inside.mkdir()
    secret = tmp_path / "secret.bin"
    secret.write_bytes(CORNERS.tobytes() + np.array([0, 1, 2, 1, 3, 2], np.uint16).tobytes())
    (inside / "link.bin").symlink_to(secret)
    uri = {"up": "../secret.bin", "absolute": str(secret), "link": "link.bin", "web": "https://x.org/a.bin"}
    with pytest.raises(InputError, match=r"outside its folder|elsewhere"):
        as_gltf(inside, gltf(CORNERS, uri=uri.get(how, secret.as_uri())))


def add_accessor(tree: dict[str, Any], values: np.ndarray, component: int, kind: str, **more: Any) -> int:
    """The index of a new accessor of `values` in a buffer of its own."""
    data = np.ascontiguousarray(values).tobytes()
    tree["buffers"].append({"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()})
    tree["bufferViews"].append({"buffer": len(tree["buffers"]) - 1, "byteLength": len(data)})
    view = {"bufferView": len(tree["bufferViews"]) - 1}
    tree["accessors"].append({**view, "componentType": component, "count": len(values), "type": kind, **more})
    return len(tree["accessors"]) - 1


def test_gltf_with_quantized_numbers_is_the_same_model(tmp_path: Path) -> None:
    """KHR_mesh_quantization: normals of signed bytes, positions and texture coordinates of unsigned shorts."""
    tree = gltf(CORNERS)
    attributes = tree["meshes"][0]["primitives"][0]["attributes"]
    attributes["POSITION"] = add_accessor(tree, (CORNERS * 65535).astype("<u2"), 5123, "VEC3", normalized=True)
    normals = np.tile(np.array([0, 0, 127, 0], np.int8), (4, 1))
    attributes["NORMAL"] = add_accessor(tree, normals[:, :3], 5120, "VEC3", normalized=True)
    uv = (CORNERS[:, :2] * 255).astype(np.uint8)
    attributes["TEXCOORD_0"] = add_accessor(tree, uv, 5121, "VEC2", normalized=True)
    mesh = as_gltf(tmp_path, {**tree, "extensionsRequired": ["KHR_mesh_quantization"]})
    assert area(mesh) == pytest.approx(1.0)
    assert mesh.normals == pytest.approx(np.tile([0.0, 0.0, 1.0], (4, 1)))
    for position, (u, v) in zip(mesh.positions, mesh.uv, strict=True):
        assert (u, v) == (pytest.approx(position[0]), pytest.approx(1.0 - position[1]))


def test_gltf_with_sparse_accessors(tmp_path: Path) -> None:
    tree = gltf(CORNERS)
    row = add_accessor(tree, np.array([[3]], "<u2"), 5123, "SCALAR")
    moved = add_accessor(tree, np.array([[2.0, 1.0, 0.0]], "<f4"), 5126, "VEC3")
    views = [tree["accessors"][each]["bufferView"] for each in (row, moved)]
    indices, values = {"bufferView": views[0], "componentType": 5123}, {"bufferView": views[1]}
    tree["accessors"][0]["sparse"] = {"count": 1, "indices": indices, "values": values}
    assert sorted(as_gltf(tmp_path, tree).positions[:, 0]) == [0.0, 0.0, 1.0, 2.0]


@pytest.mark.parametrize("indexed", [False, True])
def test_gltf_with_fans_of_triangles(indexed: bool, tmp_path: Path) -> None:
    around = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    tree = gltf(around)
    primitive = tree["meshes"][0]["primitives"][0]
    primitive["mode"] = 6
    primitive.pop("indices")
    if indexed:
        primitive["indices"] = add_accessor(tree, np.array([[1], [2], [3], [0]], np.uint8), 5121, "SCALAR")
    mesh = as_gltf(tmp_path, tree)
    assert (len(mesh.faces), area(mesh)) == (2, pytest.approx(1.0))
    assert (mesh.normals[:, 2] > 0.99).all()


def test_gltf_with_strips_of_triangles_turns_every_other_one(tmp_path: Path) -> None:
    model = Model()
    model.add([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 2, 0]], mode=5)
    mesh = as_gltf(tmp_path, model.tree)
    assert (len(mesh.faces), area(mesh)) == (3, pytest.approx(1.5))
    assert mesh.health.figures["faces_turned"] == 0.0


def test_gltf_with_instances_on_the_graphics_device(tmp_path: Path) -> None:
    """EXT_mesh_gpu_instancing: moved, turned a quarter about z and doubled, within a node that lifts both by one."""
    model = Model()
    model.add(CORNERS, [[0, 1, 2], [1, 3, 2]])
    attributes = {
        "TRANSLATION": model.accessor(np.array([[5.0, 0.0, 0.0], [0.0, 7.0, 0.0]])),
        "ROTATION": model.accessor(np.array([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.5**0.5, 0.5**0.5]])),
        "SCALE": model.accessor(np.array([[1.0, 1.0, 1.0], [2.0, 2.0, 2.0]])),
    }
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": attributes}}
    model.tree["nodes"] = [{"mesh": 0, "translation": [0, 0, 1], "extensions": instancing}]
    mesh = as_gltf(tmp_path, {**model.tree, "extensionsRequired": ["EXT_mesh_gpu_instancing"]})
    assert (len(mesh.faces), area(mesh)) == (4, pytest.approx(1.0 + 4.0))
    first = mesh.positions[mesh.positions[:, 0] >= 4.0]
    second = mesh.positions[mesh.positions[:, 0] < 4.0]
    assert (first.min(axis=0), first.max(axis=0)) == (pytest.approx([5, 0, 1]), pytest.approx([6, 1, 1]))
    assert (second.min(axis=0), second.max(axis=0)) == (pytest.approx([-2, 7, 1]), pytest.approx([0, 9, 1]))


def test_gltf_takes_the_texture_coordinates_of_each_material(tmp_path: Path) -> None:
    """texCoord 1, turned a quarter anticlockwise (v down), scaled and moved: by the formula of the extension."""
    place = {"offset": [0.25, 0.5], "rotation": np.pi / 2.0, "scale": [2.0, 3.0], "texCoord": 1}
    texture = {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": place}}
    model = Model(materials=[{"pbrMetallicRoughness": {"baseColorTexture": texture}}])
    second = np.array([[0.1, 0.2], [0.9, 0.2], [0.1, 0.7], [0.9, 0.7]])
    model.add(CORNERS, [[0, 1, 2], [1, 3, 2]], material=0, TEXCOORD_0=np.zeros((4, 2)), TEXCOORD_1=second)
    mesh = as_gltf(tmp_path, model.tree)
    for corner, (u, v) in zip(CORNERS, second, strict=True):
        at = np.flatnonzero((mesh.positions == corner).all(axis=1))[0]
        assert mesh.uv[at] == pytest.approx((0.25 + 3.0 * v, 1.0 - (0.5 - 2.0 * u)), abs=1e-6)


def test_gltf_says_which_material_each_face_has(tmp_path: Path) -> None:
    """Names are made for materials without and for those that others have; colours stay at their corners."""
    model = Model(materials=[{"name": "a"}, {}, {"name": "a"}])
    colours = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    for at, material in enumerate((2, 0, 1, None)):
        more: dict[str, Any] = {} if material is None else {"material": material}
        more |= {"COLOR_0": colours} if at == 1 else {}
        model.add(CORNERS[:3] + np.array([0.0, 0.0, 2.0 * at]), **more)
    mesh = as_gltf(tmp_path, model.tree)
    assert mesh.part_names == ("a 2", "a", "material 2", "no material")
    assert mesh.part is not None
    assert mesh.colours is not None
    for face, part in zip(mesh.faces, mesh.part, strict=True):
        assert mesh.positions[face, 2] == pytest.approx(2.0 * part)
        wanted = colours[[int(np.argmin(np.abs(CORNERS[:3, :2] - xy).sum(axis=1))) for xy in mesh.positions[face, :2]]]
        assert mesh.colours[face] == pytest.approx(wanted if part == 1 else np.ones((3, 3)))
    assert mesh.flipped().part is mesh.part


def test_gltf_without_scenes_shows_all_root_nodes(tmp_path: Path) -> None:
    tree = gltf(CORNERS)
    tree["nodes"] = [{"mesh": 0}, {"children": [2]}, {"mesh": 0, "translation": [5, 0, 0]}]
    for name in ("scenes", "scene"):
        tree.pop(name, None)
    mesh = as_gltf(tmp_path, tree)
    assert len(mesh.faces) == 4
    assert np.ptp(mesh.positions[:, 0]) == pytest.approx(6.0)


def cut_sparse(tree: dict[str, Any]) -> None:
    indices = {"bufferView": 1, "componentType": 5123}
    tree["accessors"][0]["sparse"] = {"count": 900, "indices": indices, "values": {"bufferView": 0}}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (cut_sparse, "damaged"),
        *(
            []
            if HAS_DRACO
            else [(lambda tree: tree.update(extensionsRequired=["KHR_draco_mesh_compression"]), "Draco")]
        ),
        (lambda tree: tree.update(extensionsRequired=["EXT_meshopt_compression"]), "meshopt"),
        (lambda tree: tree["accessors"][0].update(count=1 << 40), "damaged"),
        (lambda tree: tree["accessors"][0].pop("bufferView"), "no data"),
        (lambda tree: tree["asset"].update(version="1.0"), "only GLTF 2"),
        (lambda tree: tree["meshes"][0]["primitives"][0].update(mode=1), "no triangles"),
        (lambda tree: tree["nodes"][0].update(scale=[0, 0, 0]), "no usable triangle"),
        (lambda tree: tree["nodes"][0].update(scale=[1e300, 1, 1]), "no usable triangle"),
    ],
)
def test_gltf_that_would_be_misread_is_refused(
    tmp_path: Path, change: Callable[[dict[str, Any]], None], words: str
) -> None:
    tree = gltf(CORNERS)
    change(tree)
    with pytest.raises(InputError, match=words):
        as_gltf(tmp_path, tree)


def test_gltf_in_whole_numbers_is_scaled_by_its_node(tmp_path: Path) -> None:
    points = np.zeros((4, 4), np.int16)
    points[:, :3] = CORNERS * 1000
    tree = gltf(points, {"scale": [0.001] * 3})
    tree["bufferViews"][0]["byteStride"] = 8
    assert area(as_gltf(tmp_path, tree)) == pytest.approx(1.0)


def test_deep_nesting_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        read(tmp_path, "a.gltf", b'{"a":' * 100_000)


@pytest.mark.parametrize("suffix", INSTEAD)
def test_kinds_that_are_not_read_say_what_to_give_instead(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(InputError, match=f"is not a mesh that can be read .{suffix}") as refusal:
        read(tmp_path, f"a{suffix}", b"x")
    assert refusal.value.remedy
    assert suffix not in suffixes("mesh")


@pytest.mark.parametrize(
    ("kind", "head", "size", "faces"),
    [
        ("stl", bytes(80) + struct.pack("<I", 10_000_000), 84 + 500_000_000, 10_000_000),
        ("ply", ply(b"", "element vertex 3", *XYZ, "element face 10000000"), 200_000_000, 10_000_000),
        ("off", b"OFF\n# x\n5000000 10000000 0\n", 400_000_000, 10_000_000),
        ("off", b"OFF\n353535235358 6 0\n", 309, 6),
        ("ply", ply(b"", "element vertex 3", *XYZ, "element face 999999999999"), 600, 100),
        ("obj", b"v 0 0 0\n", 600_000_000, 20_000_000),
    ],
)
def test_V9_how_many_triangles_a_file_holds_is_known_beforehand(kind: str, head: bytes, size: int, faces: int) -> None:
    assert estimate_faces(head, size, kind) == faces


def test_V9_fault16_a_mesh_that_does_not_fit_is_refused_before_it_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "large.stl"
    with path.open("wb") as file:
        file.write(bytes(80) + struct.pack("<I", 10_000_000))
        file.truncate(84 + 500_000_000)
    memory = psutil.virtual_memory()._replace(available=4 << 30)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: memory)
    monkeypatch.setattr("engine.geometry.mesh.decode_in_child", lambda *_, **__: pytest.fail("it was read"))
    with pytest.raises(InputError, match=r"about 10 million triangles .* GiB .* 4 GiB are free"):
        read_mesh(path)
    memory = memory._replace(available=1 << 40)
    check_memory(path)


WORDS = st.sampled_from(["v", "vt", "vn", "f", "o", "#", "1", "2", "3", "-1", "1/1/1", "2//2", "0.5", "\\", "\n"])


def reply_or_sentence(read_one: Callable[[], Any]) -> Any:
    """The result of reading, or the sentence with which the file was refused."""
    try:
        return read_one()
    except InputError as error:
        return str(error)


@settings(max_examples=150)
@given(st.lists(WORDS, max_size=60).map(" ".join), st.sampled_from(["obj", "off", "ply"]))
def test_text_of_any_kind_is_read_or_refused(text: str, kind: str) -> None:
    start = {"obj": TRIANGLE.decode() + "f 1 2 3\n", "off": "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"}
    content = (start.get(kind, ply(b"", "element vertex 3", *XYZ).decode()) + text).encode()
    reply = reply_or_sentence(lambda: decode_mesh(content, f"a.{kind}"))
    if isinstance(reply, str):
        assert "\n" not in reply
    else:
        assert np.isfinite(reply["positions"]).all()
        assert reply["faces"].max() < len(reply["positions"])


#: The given files that hold no mesh, or whose numbers are none.
NO_MESH = {"OutOfMemory.off", "empty.obj", "empty.stl", "invalid.off", "issue623.ply", "number_formats.obj"}


def test_every_given_file_is_a_mesh_with_a_report_or_one_sentence(shared_data: Callable[[str], Path]) -> None:
    paths = [path for folder in ("nasty_assimp", "nasty_trimesh") for path in shared_data(f"mesh/{folder}").iterdir()]
    for path in sorted(paths):
        mesh = reply_or_sentence(lambda path=path: read_mesh(path))  # type: ignore[misc]
        assert isinstance(mesh, str) == (path.name in {*NO_MESH, "points_bin.ply"}), f"{path.name}: {mesh}"
        if isinstance(mesh, str):
            assert "\n" not in mesh, path.name
            continue
        assert {"open_edges", "closed", "convex", "components"} <= set(mesh.health.figures), path.name
        assert np.isfinite(mesh.uv).all(), path.name
        assert np.linalg.norm(mesh.normals, axis=1) == pytest.approx(np.ones(len(mesh.normals)), abs=1e-5), path.name
