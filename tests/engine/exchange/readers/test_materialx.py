"""MaterialX documents: our own come back, other surfaces and node graphs by hand, and what is hostile is refused."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable
from pathlib import Path

import MaterialX as materialx
import numpy as np
import pytest

from engine.core.errors import InputError
from engine.core.steps import drain
from engine.exchange.materialx import contents
from engine.exchange.readers.materialx import materialx_of
from engine.exchange.readers.read import describe, open_material
from engine.exchange.readers.textures import Described
from engine.exchange.subject import Settings, Subject
from engine.scene.credits import Credits
from engine.scene.material import Material, material_of_maps
from engine.surface.pbr_maps import PbrMaps

from .images import find_known, grey, png


def open_path(path: Path) -> tuple[PbrMaps, list[str]]:
    material = open_material(path)
    assert material.pbr is not None
    return material.pbr, material.health.warnings


def document(folder: Path, body: str, root: str = 'colorspace="lin_rec709"') -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / "m.mtlx"
    path.write_text(f'<?xml version="1.0"?>\n<materialx version="1.39" {root}>{body}</materialx>')
    return path


def test_our_own_document_comes_back_within_its_rounding(tmp_path: Path) -> None:
    maps = find_known()
    subject = Subject(material_of_maps(maps, "rock"), maps, 1.0 / np.pi)
    credits = Credits('The "rock" & <more>', "Änne \\ Ö.", "CC-BY-4.0", "© 2026", "https://example.com/rock")
    for name, content in drain(contents(subject, Settings(credits=credits), "")).files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    found, notes = open_path(tmp_path / "rock.mtlx")
    assert open_material(tmp_path / "rock.mtlx").credits == credits
    step = 0.5 / 255 * 1.01
    assert np.abs(found.roughness - maps.roughness).max() <= step
    assert np.abs(found.metallic - maps.metallic).max() <= step
    assert np.abs(found.base_colour - maps.base_colour).max() <= step * 2.4 / 1.055 + 1e-6
    assert np.abs(found.normal - maps.normal).max() <= 4.0 * step
    assert np.abs(found.f0 - 0.04).max() < 1e-5
    assert any("of 2 surfaces" in note for note in notes)


def test_standard_surface_through_a_graph(tmp_path: Path) -> None:
    """base × image × factor, one channel of a packed image, an inverted one, and IOR 2 at half weight."""
    png(tmp_path / "t" / "base.png", grey(255))
    png(tmp_path / "t" / "packed.png", np.tile(np.array([0, 51, 102], np.uint8), (4, 4, 1)))
    body = """
      <nodegraph name="g">
        <image name="b" type="color3"><input name="file" type="filename" value="t/base.png" colorspace="srgb_texture"/>
        </image>
        <multiply name="tinted" type="color3">
          <input name="in1" type="color3" nodename="b"/><input name="in2" type="color3" value="0.5, 0.25, 1"/>
        </multiply>
        <image name="p" type="color3"><input name="file" type="filename" value="t/packed.png"/></image>
        <separate3 name="s" type="multioutput"><input name="in" type="color3" nodename="p"/></separate3>
        <invert name="rough" type="float"><input name="in" type="float" nodename="s" output="outg"/></invert>
        <extract name="metal" type="float"><input name="in" type="color3" nodename="p"/>
          <input name="index" type="integer" value="2"/></extract>
        <output name="base_out" type="color3" nodename="tinted"/>
        <output name="rough_out" type="float" nodename="rough"/>
        <output name="metal_out" type="float" nodename="metal"/>
      </nodegraph>
      <standard_surface name="shader" type="surfaceshader">
        <input name="base" type="float" value="0.5"/>
        <input name="base_color" type="color3" nodegraph="g" output="base_out"/>
        <input name="specular_roughness" type="float" nodegraph="g" output="rough_out"/>
        <input name="metalness" type="float" nodegraph="g" output="metal_out"/>
        <input name="specular" type="float" value="0.5"/><input name="specular_IOR" type="float" value="2"/>
        <input name="coat" type="float" value="1"/>
      </standard_surface>
      <surfacematerial name="rock" type="material">
        <input name="surfaceshader" type="surfaceshader" nodename="shader"/>
      </surfacematerial>"""
    path = document(tmp_path, body)
    found, notes = open_path(path)
    np.testing.assert_allclose(found.base_colour[0, 0], (0.25, 0.125, 0.5), atol=1e-6)
    assert found.roughness[0, 0] == pytest.approx(0.8, abs=1e-6)
    assert found.metallic[0, 0] == pytest.approx(0.4, abs=1e-6)
    assert found.f0[0, 0] == pytest.approx(1.0 / 18.0, abs=1e-6)
    assert open_material(path).name == "rock"
    assert notes == []
    assert found.openpbr is not None
    assert (found.openpbr.coat_weight, found.openpbr.coat_roughness, found.openpbr.coat_darkening) == (1.0, 0.1, 0.0)


def test_colour_spaces_are_inherited(tmp_path: Path) -> None:
    png(tmp_path / "a.png", grey(188))
    image = '<image name="i" type="color3"><input name="file" type="filename" value="a.png"{}/></image>'
    surface = '<gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="i"/></gltf_pbr>'
    for own, root, wanted in (
        ("", 'colorspace="lin_rec709"', 188 / 255),
        ("", 'colorspace="srgb_texture"', 0.5029),
        ("", "", 188 / 255),
        (' colorspace="lin_rec709"', 'colorspace="srgb_texture"', 188 / 255),
    ):
        found, notes = open_path(document(tmp_path, image.format(own) + surface, root))
        assert found.base_colour[0, 0, 0] == pytest.approx(wanted, abs=1e-3)
        assert any("states no colour space" in note for note in notes) == (not own and not root)


def test_a_node_that_is_not_read_is_said(tmp_path: Path) -> None:
    body = (
        '<noise2d name="n" type="float"/><open_pbr_surface name="s" type="surfaceshader">'
        '<input name="specular_roughness" type="float" nodename="n"/></open_pbr_surface>'
    )
    found, notes = open_path(document(tmp_path, body))
    assert found.roughness[0, 0] == pytest.approx(0.3)
    assert any("specular_roughness comes from nodes that are not read" in note for note in notes)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("", "no surface that is read"),
        ("<gltf_pbr", "not valid XML"),
        (
            '<image name="i" type="color3"><input name="file" type="filename" value="../secret.png"/></image>'
            '<gltf_pbr name="s"><input name="base_color" type="color3" nodename="i"/></gltf_pbr>',
            "outside its folder",
        ),
        (
            '<convert name="a"><input name="in" nodename="b"/></convert>'
            '<convert name="b"><input name="in" nodename="a"/></convert>'
            '<gltf_pbr name="s"><input name="roughness" type="float" nodename="a"/></gltf_pbr>',
            "without end",
        ),
        ('<gltf_pbr name="s"><input name="roughness" type="float" value="nan"/></gltf_pbr>', "impossible value"),
        (
            '<gltf_pbr name="s"><input name="base_color" type="color3" value="1, 2"/></gltf_pbr>',
            "2 numbers for base_color",
        ),
    ],
)
def test_refusals(tmp_path: Path, body: str, words: str) -> None:
    png(tmp_path / "secret.png", grey(1))
    with pytest.raises(InputError, match=words):
        open_material(document(tmp_path / "m", body))


def test_entities_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "m.mtlx"
    path.write_text('<!DOCTYPE x [<!ENTITY a "aaaa">]><materialx><gltf_pbr name="&a;"/></materialx>')
    with pytest.raises(InputError, match="entities"):
        open_material(path)


def test_library_of_materialx_reads_the_same_document(tmp_path: Path) -> None:
    """A document that the library of MaterialX writes opens here."""
    library = pytest.importorskip("MaterialX")
    made = library.createDocument()
    made.importLibrary(library.createDocument())
    node = made.addNode("standard_surface", "shader", "surfaceshader")
    node.setInputValue("specular_roughness", 0.35)
    node.setInputValue("base", 1.0)
    node.setInputValue("base_color", library.Color3(0.2, 0.4, 0.6))
    made.addMaterialNode("plain", node)
    path = tmp_path / "plain.mtlx"
    library.writeToXmlFile(made, str(path))
    material: Material = open_material(path)
    assert material.pbr is not None
    np.testing.assert_allclose(material.pbr.base_colour[0, 0], (0.2, 0.4, 0.6), atol=1e-6)
    assert material.pbr.roughness[0, 0] == pytest.approx(0.35, abs=1e-6)


@pytest.mark.parametrize("space", ["srgb_texture", "lin_rec709", "acescg", "lin_ap1", "g18_rec709", "adobergb"])
@pytest.mark.parametrize("holder", ["input", "node", "root"])
def test_values_have_the_colour_space_that_is_stated(space: str, holder: str, tmp_path: Path) -> None:
    """As the generators of the MaterialX library transform them: by its own node of that name."""
    colour = np.array([0.6, 0.5, 0.4])
    own, around, root = (f'colorspace="{space}"' if holder == each else "" for each in ("input", "node", "root"))
    body = (
        f'<constant name="c" type="color3" {around}><input name="value" type="color3" value="0.6,0.5,0.4" {own}/>'
        '</constant><gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="c"/>'
        "</gltf_pbr>"
    )
    found, _ = open_path(document(tmp_path, body, root))
    powers = {"srgb_texture": 0.0, "g18_rec709": 1.8, "adobergb": 563 / 256}
    if space == "srgb_texture":
        colour = np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)
    elif space in powers:
        colour = colour ** powers[space]
    for names, node in ((("acescg", "lin_ap1"), "acescg_to_lin_rec709"), (("adobergb",), "lin_adobergb_to_lin_rec709")):
        if space in names:
            colour = matrix_of(node) @ colour
    np.testing.assert_allclose(found.base_colour[0, 0], colour, atol=1e-4)


def matrix_of(node: str) -> np.ndarray:
    """The matrix of a colour transformation of the MaterialX library, which multiplies columns from the left."""
    graph = library().getNodeGraph(f"NG_{node}_color3")
    values = next(each for each in graph.getNodes() if each.getCategory() == "constant").getInput("value")
    return np.array([float(each) for each in values.getValueString().split(",")]).reshape(3, 3).T


@functools.cache
def library() -> materialx.Document:
    found = materialx.createDocument()
    materialx.loadLibraries(materialx.getDefaultDataLibraryFolders(), materialx.getDefaultDataSearchPath(), found)
    return found


SURFACES = ("open_pbr_surface", "standard_surface", "gltf_pbr", "UsdPreviewSurface", "disney_principled")


def inputs_of(surface: str) -> list[tuple[str, str, str]]:
    """Name, type and default of all inputs of a surface, as the library declares them."""
    name = f"ND_{surface}" if surface == "disney_principled" else f"ND_{surface}_surfaceshader"
    declared = library().getNodeDef(name).getActiveInputs()
    return [(each.getName(), each.getType(), each.getValueString()) for each in declared]


def change_value(kind: str, usual: str) -> str:
    """Another value than the default."""
    if kind == "boolean":
        return "false" if usual == "true" else "true"
    if kind == "integer":
        return str(int(usual or 0) + 1)
    if kind in ("string", "filename"):
        return "other"
    numbers = [float(each) for each in (usual or "0,0,1").split(",")]
    return ",".join(f"{0.6 if abs(each - 0.6) > 0.2 else 0.3:g}" for each in numbers)


@pytest.mark.parametrize("surface", SURFACES)
def test_every_input_of_a_surface_is_read_or_named(surface: str, tmp_path: Path) -> None:
    """The walk over the declarations of the library: each input alone changes the material or is in a warning.

    Colours and roughness of a layer count where the layer is there.
    """
    layers = {
        "open_pbr_surface": "coat_weight fuzz_weight thin_film_weight subsurface_weight transmission_weight",
        "standard_surface": "coat sheen subsurface transmission",
        "gltf_pbr": "clearcoat sheen_roughness iridescence transmission anisotropy_strength",
        "UsdPreviewSurface": "clearcoat",
        "disney_principled": "clearcoat",
    }[surface].split()
    present = dict.fromkeys(layers, "0.5")
    present |= {
        "open_pbr_surface": {"emission_luminance": "10"},
        "standard_surface": {"thin_film_thickness": "400", "specular_anisotropy": "0.5", "emission": "1"},
        "gltf_pbr": {"sheen_color": "0.3,0.3,0.3", "roughness": "0.4", "emissive": "1,1,1", "alpha_mode": "1"},
        "UsdPreviewSurface": {"useSpecularWorkflow": "1"},
        "disney_principled": {},
    }[surface]
    kinds = {name: kind for name, kind, _ in inputs_of(surface)}

    def describe(values: dict[str, str]) -> Described:
        said = "".join(f'<input name="{name}" type="{kinds[name]}" value="{each}"/>' for name, each in values.items())
        content = f'<materialx version="1.39"><{surface} name="s" type="surfaceshader">{said}</{surface}></materialx>'
        return materialx_of(content.encode(), tmp_path / "m.mtlx")

    base, lost = describe(present), []
    for name, kind, usual in inputs_of(surface):
        if name in present and name != "sheen_roughness":
            continue
        found = describe({**present, name: change_value(kind, usual)})
        lossy = " ".join(found.notes)
        parts = ("transmission", "subsurface", "emissi", "thickness", "attenuation", "dispersion", "specularColor")
        parts = ("transmission", "subsurface", "emissi", "thickness", "attenuation", "dispersion", "specularColor")
        covered = name.startswith((*parts, "alpha")) and any(
            word in lossy for word in ("goes through", "scattered below", "emissi", "useSpecularWorkflow", "alpha_mode")
        )
        if dataclasses.replace(found, notes=()) == dataclasses.replace(base, notes=()) and name not in lossy:
            lost += [] if covered else [name]
    assert lost == []


@pytest.mark.parametrize("surface", SURFACES)
def test_a_document_that_states_all_defaults_loses_nothing(surface: str, tmp_path: Path) -> None:
    said = "".join(
        f'<input name="{n}" type="{kind}" value="{usual}"/>' for n, kind, usual in inputs_of(surface) if usual
    )
    content = f'<materialx version="1.39"><{surface} name="s" type="surfaceshader">{said}</{surface}></materialx>'
    assert [note for note in materialx_of(content.encode(), tmp_path / "m.mtlx").notes if "not drawn" in note] == []


def test_unknown_spaces_and_sets_of_tiles_are_refused_by_name(tmp_path: Path) -> None:
    surface = '<gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="i"/></gltf_pbr>'
    image = '<image name="i" type="color3"><input name="file" type="filename" value="{}" colorspace="{}"/></image>'
    with pytest.raises(InputError, match="hydra_blue"):
        open_path(document(tmp_path, image.format("a.png", "hydra_blue") + surface))
    with pytest.raises(InputError, match=r"a\.1001\.png"):
        open_path(document(tmp_path, image.format("a.<UDIM>.png".replace("<", "&lt;"), "srgb_texture") + surface))


WHITE = '<{0} name="s" type="surfaceshader"><input name="{1}" type="color3" nodename="i"/></{0}>'
FILE = '<image name="i" type="color3"><input name="file" type="filename" value="{}" colorspace="srgb_texture"/></image>'


def test_images_lie_below_a_folder_that_a_user_names(tmp_path: Path) -> None:
    """As the document says, or as if its name began at the folder; nothing beyond the folder is read."""
    documents, images = tmp_path / "project" / "documents", tmp_path / "project" / "images"
    documents.mkdir(parents=True)
    images.mkdir()
    png(images / "a.png", grey(60))
    png(tmp_path / "b.png", grey(60))
    path = document(documents, FILE.format("../images/a.png") + WHITE.format("gltf_pbr", "base_color"))
    with pytest.raises(InputError, match="outside its folder"):
        open_path(path)
    for search in (tmp_path / "project", images.parent, tmp_path):
        found = open_material(path, search=search).pbr
        assert found is not None
        assert found.base_colour.mean() == pytest.approx(((60 / 255 + 0.055) / 1.055) ** 2.4, rel=1e-3)
    path = document(documents, FILE.format("../../b.png") + WHITE.format("gltf_pbr", "base_color"))
    with pytest.raises(InputError, match=r"b\.png"):
        open_material(path, search=tmp_path / "project")


def test_documents_that_a_document_includes_are_read(tmp_path: Path) -> None:
    surface = '<gltf_pbr name="s" type="surfaceshader"><input name="roughness" type="float" value="0.25"/></gltf_pbr>'
    (tmp_path / "other.mtlx").write_text(f'<materialx version="1.39">{surface}</materialx>')
    include = '<xi:include xmlns:xi="http://www.w3.org/2001/XInclude" href="{}"/>'
    found = open_path(document(tmp_path, include.format("other.mtlx")))
    assert float(found[0].roughness.mean()) == pytest.approx(0.25)
    with pytest.raises(InputError, match=r"none\.mtlx"):
        open_path(document(tmp_path, include.format("none.mtlx")))


def test_examples_of_materialx_open_where_their_images_are_there(shared_data: Callable[[str], Path]) -> None:
    """45 of 50: four name images that are not there, and one is of hair."""
    examples = shared_data("materialx_examples")
    refused = {}
    for path in sorted(examples.rglob("*.mtlx")):
        try:
            describe(path, search=examples)
        except InputError as error:
            refused[path.stem] = error.problem
    assert refused.pop("simple_hair_default") == "has no surface that is read"
    assert all("next to it, which does not exist" in problem for problem in refused.values())
    assert len(refused) == 4


@pytest.mark.parametrize(
    ("coordinates", "words"),
    [
        ('<place2d name="uv" type="vector2"><input name="scale" type="vector2" value="2, 1"/></place2d>', "scale of"),
        ('<place2d name="uv" type="vector2"><input name="rotate" type="float" value="30"/></place2d>', "rotate of"),
        ('<place2d name="uv" type="vector2"><input name="scale" type="vector2" value="1, 1"/></place2d>', ""),
        (
            '<rotate2d name="uv" type="vector2"><input name="amount" type="float" value="30"/></rotate2d>',
            "node rotate2d",
        ),
        ('<texcoord name="uv" type="vector2"/>', ""),
    ],
)
def test_moved_texture_coordinates_are_named(coordinates: str, words: str, tmp_path: Path) -> None:
    """A document has no model whose texture coordinates could be moved."""
    image = (
        '<image name="i" type="color3"><input name="file" type="filename" value="a.png" colorspace="lin_rec709"/>'
        '<input name="texcoord" type="vector2" nodename="uv"/></image>'
    )
    surface = '<gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="i"/></gltf_pbr>'
    content = f'<materialx version="1.39">{coordinates}{image}{surface}</materialx>'
    notes = materialx_of(content.encode(), tmp_path / "m.mtlx").notes
    assert [bool(words) and words in each for each in notes] == [True] * bool(words)
