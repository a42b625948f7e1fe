"""USD: the same model and colours as in glTF, our own exports come back, and nothing outside its folder is read."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.core.steps import drain
from engine.exchange.readers.read import open_material
from engine.exchange.subject import Settings, Subject
from engine.exchange.usd import contents, usdz
from engine.geometry.mesh import decode_mesh, read_mesh
from engine.scene.credits import Credits
from engine.scene.material import material_of_maps
from tests.engine.gltf_models import Model

from .images import find_known, png

pytest.importorskip("pxr.Usd", reason="usd-core is not installed")
from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade

#: A box without its lid, as five quadrilaterals; the first two have one material, the others another.
POINTS = np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, 0, 1], [2, 0, 1], [2, 1, 1], [0, 1, 1]], float)
QUADS = np.array([[0, 3, 2, 1], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
UV = np.random.default_rng(5).random((20, 2))
COLOURS = np.random.default_rng(6).random((8, 3))
SHIFT, SCALE = np.array([3.0, -1.0, 0.5]), np.array([1.0, 2.0, -1.5])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`model.gltf` beside `model.usda`, `model.usdc` and `model.usdz` of the same."""
    folder = tmp_path_factory.mktemp("usd")
    png(folder / "tex" / "base.png", np.random.default_rng(7).integers(0, 256, (4, 8, 3)))
    png(folder / "tex" / "orm.png", np.random.default_rng(8).integers(0, 256, (4, 8, 3)))
    write_gltf(folder / "model.gltf")
    for name in ("model.usda", "model.usdc"):
        write_usd(folder / name)
    members = {name: (folder / name).read_bytes() for name in ("model.usdc", "tex/base.png", "tex/orm.png")}
    (folder / "model.usdz").write_bytes(usdz(members))
    return folder


def write_gltf(path: Path) -> None:
    """Positions in metres with y up: (x, z, −y) of what USD has in centimetres."""
    model = Model(
        [
            {
                "name": "plain",
                "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.25, 0.1, 1.0], "roughnessFactor": 0.4},
            },
            {
                "name": "painted",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.5, 1.0, 0.25, 1.0],
                    "baseColorTexture": {"index": 0},
                    "metallicRoughnessTexture": {"index": 1},
                },
            },
        ],
        textures=[{"source": 0}, {"source": 1}],
        images=[{"uri": "tex/base.png"}, {"uri": "tex/orm.png"}],
    )
    model.tree["materials"][0]["pbrMetallicRoughness"]["metallicFactor"] = 0.0
    corners = 0.01 * ((POINTS * SCALE + SHIFT)[QUADS] @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])).reshape(-1, 3)
    faces = np.array([[0, 2, 1], [0, 3, 2]])  # the scale mirrors
    for chosen, material in (([0, 1], 0), ([2, 3, 4], 1)):
        index = np.concatenate([4 * quad + faces for quad in chosen])
        model.add(corners, index, TEXCOORD_0=UV * (1, -1) + (0, 1), material=material)
    path.write_text(json.dumps(model.tree))


def write_usd(path: Path) -> None:
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    root = UsdGeom.Xform.Define(stage, "/all")
    root.AddTranslateOp().Set(Gf.Vec3d(*SHIFT))
    mesh = UsdGeom.Mesh.Define(stage, "/all/box")
    mesh.AddScaleOp().Set(Gf.Vec3f(*SCALE))
    mesh.CreatePointsAttr(POINTS.tolist())
    mesh.CreateFaceVertexCountsAttr([4] * 5)
    mesh.CreateFaceVertexIndicesAttr(QUADS.ravel().tolist())
    mesh.CreateSubdivisionSchemeAttr("none")
    primvars = UsdGeom.PrimvarsAPI(mesh)
    st = primvars.CreatePrimvar("map", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
    st.Set(UV[::-1].tolist())
    st.SetIndices(np.arange(20)[::-1].tolist())
    plain = material(stage, "plain", diffuseColor=(0.5, 0.25, 0.1), roughness=0.4)
    painted = material(stage, "painted")
    UsdShade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(painted)
    subset = UsdShade.MaterialBindingAPI(mesh).CreateMaterialBindSubset("some", [0, 1])
    UsdShade.MaterialBindingAPI.Apply(subset.GetPrim()).Bind(plain)
    stage.GetRootLayer().Save()


def material(stage: Usd.Stage, name: str, **values: object) -> UsdShade.Material:
    """A UsdPreviewSurface with values, or with textures in a graph of nodes."""
    types = Sdf.ValueTypeNames
    found = UsdShade.Material.Define(stage, f"/all/{name}")
    surface = UsdShade.Shader.Define(stage, f"/all/{name}/surface")
    surface.CreateIdAttr("UsdPreviewSurface")
    found.CreateSurfaceOutput().ConnectToSource(surface.CreateOutput("surface", types.Token))
    kinds = {"diffuseColor": types.Color3f, "roughness": types.Float, "metallic": types.Float}
    for key, value in values.items():
        surface.CreateInput(key, kinds[key]).Set(value)
    if values:
        return found
    graph = UsdShade.NodeGraph.Define(stage, f"/all/{name}/graph")
    reader = UsdShade.Shader.Define(stage, f"/all/{name}/graph/st")
    reader.CreateIdAttr("UsdPrimvarReader_float2")
    reader.CreateInput("varname", types.String).Set("map")
    for file, space, scale in (("base", "sRGB", (0.5, 1.0, 0.25, 1.0)), ("orm", "raw", (1.0,) * 4)):
        texture = UsdShade.Shader.Define(stage, f"/all/{name}/graph/{file}")
        texture.CreateIdAttr("UsdUVTexture")
        texture.CreateInput("file", types.Asset).Set(Sdf.AssetPath(f"tex/{file}.png"))
        texture.CreateInput("sourceColorSpace", types.Token).Set(space)
        texture.CreateInput("scale", types.Float4).Set(scale)
        texture.CreateInput("st", types.Float2).ConnectToSource(reader.CreateOutput("result", types.Float2))
        inputs = {"diffuseColor": "rgb"} if file == "base" else {"roughness": "g", "metallic": "b"}
        for key, output in inputs.items():
            kind = kinds[key]
            through = graph.CreateOutput(key, kind)
            through.ConnectToSource(texture.CreateOutput(output, kind))
            surface.CreateInput(key, kind).ConnectToSource(through)
    return found


def decode(path: Path) -> dict[str, Any]:
    """What the decoder makes of a file, or what it misses, in this process."""
    return decode_mesh(b"", str(path), oriented=False, copies=str(path.parent), file=path.name)


def list_triangles(mesh: Mapping[str, Any]) -> NDArray[np.float64]:
    """Rows of material and corners of each triangle in an order of their own: positions, coordinates, normals."""
    part, faces = mesh["part"], mesh["faces"]
    corners = np.concatenate([mesh[key][faces] for key in ("positions", "uv", "normals")], axis=-1)
    first = np.argmin(np.round(corners[..., :3], 5) @ (1.0, 10.0, 100.0), axis=1)
    corners = np.stack([corners[np.arange(len(faces)), (first + step) % 3] for step in range(3)], axis=1)
    names = np.array([mesh["part_names"].index("plain") == each for each in part])[:, None]
    rows = np.concatenate([names, corners.reshape(len(faces), -1)], axis=1)
    return rows[np.lexsort(np.round(rows, 5).T)]


@pytest.mark.parametrize("name", ["model.usda", "model.usdc", "model.usdz"])
def test_a_model_is_that_of_gltf(folder: Path, name: str) -> None:
    wanted = decode_mesh((folder / "model.gltf").read_bytes(), "model.gltf", oriented=False)
    found = decode(folder / name)
    np.testing.assert_allclose(list_triangles(found), list_triangles(wanted), atol=2e-6)
    assert found["figures"]["vertices_without_faces_dropped"] == 0


def test_model_and_materials_of_a_package_are_those_of_gltf(folder: Path) -> None:
    """Through the confined process."""
    assert vars(read_mesh(folder / "model.usdz"))["part_names"] == ("plain", "painted")
    wanted, found = (open_material(folder / each, parts=True) for each in ("model.gltf", "model.usdz"))
    assert sorted(each.name for each in found.parts) == ["painted", "plain"]
    assert found.name == "painted"
    for part in wanted.parts:
        (same,) = (each for each in found.parts if each.name == part.name)
        assert part.pbr is not None
        assert same.pbr is not None
        for key in ("base_colour", "roughness", "metallic", "f0", "normal"):
            np.testing.assert_allclose(getattr(same.pbr, key), getattr(part.pbr, key), atol=1e-6)
    with pytest.raises(InputError, match="has no material 'rusty'"):
        open_material(f"{folder / 'model.usda'}#rusty")


def test_our_own_exports_come_back(tmp_path: Path) -> None:
    """The package, and the layer of MaterialX over it, which is read with the package below it."""
    maps = find_known()
    subject = Subject(material_of_maps(maps, '"Röck"'), maps, 1.0 / np.pi)
    credits = Credits('The "rock"', "Änne \\ Ö.", "CC-BY-4.0", "© 2026", "https://example.com/rock")
    for name, content in drain(contents(subject, Settings(credits=credits), "")).files.items():
        (tmp_path / name).write_bytes(content)
    for name in ("R_ck.usdz", "R_ck_materialx.usda"):
        found = open_material(tmp_path / name)
        assert found.name == '"Röck"'
        assert not found.health.warnings
        assert found.credits == credits
        assert found.pbr is not None
        step = 0.5 / 255 * 1.01
        assert np.abs(found.pbr.base_colour - maps.base_colour).max() <= step * 2.4 / 1.055 + 1e-6
        for key, bound in (("roughness", step), ("metallic", step), ("normal", 4.0 * step), ("f0", 1e-6)):
            assert np.abs(getattr(found.pbr, key) - getattr(maps, key)).max() <= bound, (name, key)


HEAD = "#usda 1.0\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("(\n    subLayers = [@../other.usda@]\n)\n", "outside its folder"),
        ("(\n    subLayers = [@/etc/passwd.usda@]\n)\n", "outside its folder"),
        ('def "a" (\n    references = @https://example.com/a.usda@\n)\n{\n}\n', "outside its folder"),
        ('def "a" (\n', "is damaged"),
        ('def Sphere "a"\n{\n}\n', "no triangles"),
        (
            'def Mesh "a"\n{\n    int[] faceVertexCounts = [3]\n    int[] faceVertexIndices = [0, 1]\n'
            "    point3f[] points = [(0, 0, 0)]\n}\n",
            "other corners",
        ),
    ],
)
def test_what_is_not_read_is_named(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "other.usda").write_text(HEAD)
    (tmp_path / "a" / "a.usda").write_text(HEAD + text)
    with pytest.raises(InputError, match=words):
        decode(tmp_path / "a" / "a.usda")


def test_a_layer_that_is_missing_is_named(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(HEAD + 'def "a" (\n    payload = @absent.usdc@\n)\n{\n}\n')
    assert decode(tmp_path / "a.usda") == {"missing": ["absent.usdc"]}
    with pytest.raises(InputError, match=r"needs the file 'absent.usdc' next to it, which does not exist"):
        read_mesh(tmp_path / "a.usda")


def test_instances_holes_and_colours_of_faces(tmp_path: Path) -> None:
    """A scatter of two squares, each of two faces, of which one is a hole; its faces have colours and no material."""
    layer = """
def Mesh "square"
{{
    uniform token subdivisionScheme = "none"
    uniform token orientation = "leftHanded"
    int[] faceVertexCounts = [3, 3]
    int[] faceVertexIndices = [0, 2, 1, 0, 3, 2]
    int[] holeIndices = [{hole}]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    color3f[] primvars:displayColor = [(1, 0, 0), (0, 1, 0)] (
        interpolation = "uniform"
    )
}}
"""
    (tmp_path / "square.usda").write_text(
        HEAD + '(\n    defaultPrim = "square"\n    metersPerUnit = 1\n)\n' + layer.format(hole=1)
    )
    (tmp_path / "a.usda").write_text(
        HEAD
        + """(
    metersPerUnit = 1
    upAxis = "Y"
)
def PointInstancer "many"
{
    rel prototypes = [</many/square>]
    int[] protoIndices = [0, 0]
    point3f[] positions = [(0, 0, 0), (0, 0, 5)]
    def "square" (
        references = @./square.usda@
    )
    {
    }
}
"""
    )
    mesh = decode(tmp_path / "a.usda")
    assert len(mesh["faces"]) == 2
    corners = mesh["positions"][mesh["faces"]]
    assert sorted(corners.mean(axis=1)[:, 2].tolist()) == [0.0, 5.0]
    assert np.all(mesh["colours"] == (1.0, 0.0, 0.0))
    a, b, c = corners[0]
    assert np.cross(b - a, c - a)[2] > 0.0  # 0, 2, 1 of a left-handed mesh is 0, 1, 2


def test_a_package_without_a_layer_is_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.usdz", "w") as package:
        package.writestr("a.txt", "nothing")
    with pytest.raises(InputError, match="damaged"):
        decode(tmp_path / "a.usdz")
