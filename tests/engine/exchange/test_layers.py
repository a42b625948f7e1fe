"""Layers in the words of others: they come back, and MaterialX draws OpenPBR surfaces as we do."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf import resample
from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.microfacet import MetallicRoughness
from engine.brdf.models.openpbr import OpenPbr
from engine.bundle.bundle import save_bundle
from engine.core.directions import normalize
from engine.core.steps import drain
from engine.exchange import brdf, gltf, materialx, textures, usd
from engine.exchange.brdf import openpbr_document
from engine.exchange.export import as_gltf, with_one_f0
from engine.exchange.loss import loss, references
from engine.exchange.readers.read import open_material
from engine.exchange.subject import Contents, Settings, Subject
from engine.proof import materialx_child
from engine.proof.libraries import with_display
from engine.scene.material import Material, material_of_maps
from engine.surface.pbr_maps import PbrMaps

from .readers.images import find_known

Floats = NDArray[np.float64]

LAYERS = (
    "openpbr:coat_weight=0.8,coat_roughness=0.25,coat_color=0.9/0.5/0.4,coat_ior=1.7,fuzz_weight=0.4,fuzz_roughness=0.3,"
    "fuzz_color=1/0.5/0.25,thin_film_weight=0.5,thin_film_thickness=0.3,specular_color=1/0.75/0.5"
)


def layers_of(text: str) -> OpenPbr:
    found = brdf_from_text(text)
    assert isinstance(found, OpenPbr)
    return found


def layered_subject(text: str = LAYERS, roughness: float | None = None) -> Subject:
    maps = replace(find_known(), layers=layers_of(text))
    if roughness is not None:
        maps = replace(maps, roughness=np.full(maps.size, roughness, np.float32))
    return Subject(material_of_maps(maps, "rock"), maps, 1.0 / np.pi)


def write(folder: Path, contents: Contents) -> Contents:
    for name, content in contents.files.items():
        (folder / name).parent.mkdir(exist_ok=True, parents=True)
        (folder / name).write_bytes(content)
    return contents


def read(path: Path) -> PbrMaps:
    found = open_material(path).pbr
    assert found is not None
    return found


def test_bundles_and_materialx_documents_keep_all_layers(tmp_path: Path) -> None:
    subject = layered_subject()
    saved = drain(save_bundle(tmp_path / "rock.lightarc", subject.material))
    assert read(saved).layers == subject.maps.layers
    made = write(tmp_path, drain(materialx.contents(subject, Settings(), "")))
    assert read(tmp_path / "rock.mtlx").layers == subject.maps.layers
    assert any("fuzz is written as sheen" in words for words in made.warnings)


def test_layers_of_gltf_come_back_as_they_are(tmp_path: Path) -> None:
    """glTF and MaterialX's glTF surface say the very coat and sheen; OpenPBR's and what has none are named."""
    coat = MetallicRoughness(
        coat_weight=0.8, coat_roughness=0.25, sheen_color=(0.75, 0.5, 0.125), sheen_roughness=0.375
    )
    maps = replace(find_known(), layers=coat)
    subject = Subject(material_of_maps(maps, "rock"), maps, 1.0 / np.pi)
    saved = drain(save_bundle(tmp_path / "rock.lightarc", subject.material))
    made = [write(tmp_path, drain(target.contents(subject, Settings(), ""))) for target in (gltf, materialx, usd)]
    for path in (saved, tmp_path / "rock.glb", tmp_path / "rock.mtlx"):
        opened = open_material(path)
        assert opened.pbr is not None
        assert opened.pbr.layers == coat
        assert not any("coat" in words or "drawn as" in words for words in opened.health.warnings)
    for kind in ("coat", "fuzz"):
        said = [any(f"written as OpenPBR's {kind}" in words for words in each.warnings) for each in made]
        assert said == [False, True, True]
    assert b"inputs:clearcoat = 0.8" in made[2].files["rock.usdz"]
    assert "layers are not written: clear coat, sheen" in drain(textures.contents(subject, Settings(), "")).warnings


def test_gltf_keeps_what_its_extensions_have_a_place_for(tmp_path: Path) -> None:
    subject = layered_subject()
    made = write(tmp_path, drain(gltf.contents(subject, Settings(), "")))
    found, given = read(tmp_path / "rock.glb").openpbr, subject.maps.openpbr
    assert found is not None
    assert given is not None
    for name in ("coat_weight", "coat_roughness", "thin_film_weight", "thin_film_thickness", "specular_color"):
        assert getattr(found, name) == pytest.approx(getattr(given, name))
    assert found.fuzz_weight * np.array(found.fuzz_color) == pytest.approx(
        given.fuzz_weight * np.array(given.fuzz_color)
    )
    assert (found.coat_ior, found.coat_darkening) == (1.5, 0.0)
    assert "the coat has no colour here, and the index 1.5" in made.warnings


def test_the_error_of_gltf_counts_what_its_layers_lack() -> None:
    """A coat of the index 1.5 in place of another; of MaterialX nothing is lost."""
    subject = layered_subject("openpbr:coat_weight=1,coat_ior=2.5,coat_roughness=0.4")
    wanted = drain(references(subject.material))
    by_gltf, by_materialx = (
        drain(loss(shown(subject, Settings()), wanted, subject.maps.size)).mean_rmse_rel
        for shown in (as_gltf, with_one_f0)
    )
    assert by_gltf > 0.1
    assert by_materialx < 0.05


def test_flat_normals_come_back_flat(tmp_path: Path) -> None:
    """8 bits have no code for 0: under a smooth coat a map of flat normals would move every highlight."""
    found = layered_subject("openpbr:coat_weight=1")
    flat = np.zeros_like(found.maps.normal)
    flat[..., 2] = 1.0
    subject = replace(found, maps=replace(found.maps, normal=flat))
    for target in (gltf, materialx, usd):
        made = write(tmp_path, drain(target.contents(subject, Settings(), "")))
        assert not any("normal" in name for name in made.files)
    for name in ("rock.glb", "rock.mtlx"):
        np.testing.assert_array_equal(read(tmp_path / name).normal[..., :2], 0.0)
    assert b"normal.png" not in b"".join(made.files.values())


@pytest.mark.parametrize("anisotropy", [0.2, 0.6, 0.9])
def test_anisotropy_comes_back_from_gltf(tmp_path: Path, anisotropy: float) -> None:
    """Two widths in the words of glTF, and back: the same widths, and the rotation."""
    text = f"openpbr:specular_roughness_anisotropy={anisotropy},rotation_deg=30"
    subject = layered_subject(text, roughness=0.5)
    write(tmp_path, drain(gltf.contents(subject, Settings(), "")))
    found = read(tmp_path / "rock.glb")
    layers: Any = found.layers
    assert layers.rotation_deg == pytest.approx(30.0)
    # the factor on roughness is applied to a texture whose mean the reader does not know: half of the factor stands in
    assert layers.specular_roughness_anisotropy == pytest.approx(anisotropy, abs=0.2)


def test_anisotropy_of_a_stated_roughness_is_exact() -> None:
    from engine.exchange.layers import gltf_roughness_factor, gltf_values
    from engine.exchange.readers.layers import gltf_values as read_values

    layers = layers_of("openpbr:specular_roughness_anisotropy=0.7,rotation_deg=-20")
    own = 0.5 * gltf_roughness_factor(layers, 0.5)
    values, factor, _ = read_values(gltf_values(layers, 0.5), own)
    assert values["specular_roughness_anisotropy"] == pytest.approx(0.7)
    assert own * factor == pytest.approx(0.5)
    assert values["rotation_deg"] == pytest.approx(-20.0)


def test_textures_name_the_layers_that_they_leave_out() -> None:
    made = drain(textures.contents(layered_subject(), Settings(), ""))
    words = "layers are not written: clear coat, fuzz, thin film, colour of highlights"
    assert words in made.warnings


def test_usd_has_the_coat_and_names_the_rest() -> None:
    made = drain(usd.contents(layered_subject(), Settings(), ""))
    assert any("UsdPreviewSurface has no fuzz, thin film" in words for words in made.warnings)
    assert b"inputs:clearcoat = 0.8" in made.files["rock.usdz"]
    assert b"color3f inputs:fuzz_color = (1, 0.5, 0.25)" in made.files["rock_materialx.usda"]


def test_an_anisotropy_that_is_turned_is_stated_as_an_error_of_its_document(monkeypatch: pytest.MonkeyPatch) -> None:
    """The document has no rotation: of 0 degrees it is the model itself, of 60 it is not."""
    monkeypatch.setattr(resample, "AZIMUTHS", 1)  # of the table beside it
    stated = []
    for angle in (0, 60):
        text = f"openpbr:base_metalness=1,specular_roughness_anisotropy=0.7,rotation_deg={angle}"
        subject = replace(layered_subject(), material=Material(None, None, brdf=text, name="brushed"))
        made = drain(brdf.contents(subject, Settings(), ""))
        stated.append(made.record["rmse_rel_by_file"]["brushed.mtlx"])
        assert any("leaves out the rotation" in words for words in made.warnings) is (angle > 0)
    assert stated[0] == 0.0
    assert stated[1] > 0.1


def surface(tmp_path: Path, name: str, inputs: str) -> PbrMaps:
    path = tmp_path / "m.mtlx"
    body = f'<{name} name="s" type="surfaceshader">{inputs}</{name}>'
    path.write_text(f'<?xml version="1.0"?>\n<materialx version="1.39">{body}</materialx>')
    return read(path)


def number(name: str, value: object) -> str:
    kind = "color3" if isinstance(value, str) else "float"
    return f'<input name="{name}" type="{kind}" value="{value}"/>'


def test_light_below_the_surface_and_through_it_by_hand(tmp_path: Path) -> None:
    """Scattered light has its colour; of what goes through half, half of the diffuse part is left."""
    inputs = number("base_color", "0.8, 0.4, 0.2") + number("subsurface_weight", 0.5)
    inputs += number("subsurface_color", "0.4, 0.4, 0.6") + number("transmission_weight", 0.5)
    found = surface(tmp_path, "open_pbr_surface", inputs)
    np.testing.assert_allclose(found.base_colour[0, 0], (0.3, 0.2, 0.2), atol=1e-6)


def test_standard_surface_in_openpbr(tmp_path: Path) -> None:
    """αx = r²/√(1 − 0.9 a) and αy = r² √(1 − 0.9 a), by hand for r = 0.5, a = 0.8."""
    inputs = number("specular_roughness", 0.5) + number("specular_anisotropy", 0.8) + number("specular_rotation", 0.25)
    inputs += number("sheen", 0.3) + number("thin_film_thickness", 400.0)
    found = surface(tmp_path, "standard_surface", inputs)
    layers: Any = found.layers
    across = 1.0 - layers.specular_roughness_anisotropy
    along = found.roughness[0, 0] ** 2 * np.sqrt(2.0 / (1.0 + across**2))
    assert (along, across * along) == pytest.approx((0.25 / np.sqrt(0.28), 0.25 * np.sqrt(0.28)), rel=1e-5)
    assert (layers.rotation_deg, layers.fuzz_weight, layers.thin_film_thickness) == pytest.approx((90.0, 0.3, 0.4))


@pytest.mark.parametrize("name", ["gltf_pbr", "standard_surface"])
def test_grey_highlights_of_materialx_are_kept(tmp_path: Path, name: str) -> None:
    layers = surface(tmp_path, name, number("specular_color", "0.5, 0.5, 0.5")).openpbr
    assert layers is not None
    assert layers.specular_color == (0.5, 0.5, 0.5)


def coated(tmp_path: Path, extensions: dict[str, Any]) -> PbrMaps:
    """A material of glTF under a clear coat, with further extensions."""
    coat = {"KHR_materials_clearcoat": {"clearcoatFactor": 1.0}}
    tree = {"asset": {"version": "2.0"}, "materials": [{"name": "m", "extensions": {**coat, **extensions}}]}
    (tmp_path / "m.gltf").write_text(json.dumps(tree))
    return read(tmp_path / "m.gltf")


def test_gltf_counts_grey_highlights_once(tmp_path: Path) -> None:
    """f0 has a grey factor, which the layers must not have again."""
    found = coated(tmp_path, {"KHR_materials_specular": {"specularColorFactor": [0.5, 0.5, 0.5]}})
    assert found.f0[0, 0] == pytest.approx(0.02)
    assert isinstance(found.layers, MetallicRoughness)


def test_gltf_of_full_specular_under_a_coat_opens(tmp_path: Path) -> None:
    """An index of 0 stands for f0 = 1 (KHR_materials_ior), which no index of OpenPBR has."""
    assert coated(tmp_path, {"KHR_materials_ior": {"ior": 0.0}}).f0[0, 0] == 1.0


def test_gltf_without_an_object_for_an_extension_opens(tmp_path: Path) -> None:
    assert coated(tmp_path, {"KHR_materials_specular": None}).layers is not None


def test_a_bundle_with_layers_of_another_model_is_refused(tmp_path: Path, monkeypatch: Any) -> None:
    from engine.bundle import pbr
    from engine.core.errors import InputError

    monkeypatch.setattr(pbr, "brdf_to_text", lambda _brdf: "lambert")
    saved = drain(save_bundle(tmp_path / "rock.lightarc", layered_subject().material))
    with pytest.raises(InputError, match="layers of a model that has none"):
        open_material(saved)


SIDE = 96


def half_ball(path: Path, rings: int = 96, sectors: int = 192) -> Path:
    """A half ball of radius 1 towards +z, with its own normals, u around it."""
    tilt, turn = np.meshgrid(
        np.linspace(0.0, np.pi / 2, rings + 1), np.linspace(0.0, 2 * np.pi, sectors + 1), indexing="ij"
    )
    places = np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)], axis=-1).reshape(-1, 3)
    lines = [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in places]
    lines += [f"vt {u:.6f} {v:.6f}" for v in np.linspace(0, 1, rings + 1) for u in np.linspace(0, 1, sectors + 1)]
    lines += [f"vn {x:.7f} {y:.7f} {z:.7f}" for x, y, z in places]
    first = (np.arange(rings)[:, None] * (sectors + 1) + np.arange(sectors)[None] + 1).ravel()
    for a in first:
        b, c, d = a + sectors + 1, a + sectors + 2, a + 1
        lines += [f"f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}", f"f {a}/{a}/{a} {c}/{c}/{c} {d}/{d}/{d}"]
    path.write_text("\n".join(lines))
    return path


def draw_by_materialx(folder: Path, text: str, lamp: Floats, display: list[str]) -> Floats:
    """(SIDE, SIDE, 3) radiance of the half ball, seen along −z."""
    document = folder / "m.mtlx"
    document.write_bytes(openpbr_document("m", layers_of(text)))
    numbers = map(str, [SIDE, SIDE, 1, 1, *lamp])
    words = [*display, sys.executable, materialx_child.__file__, str(document), "open_pbr_surface"]
    done = subprocess.run([*words, str(folder / "ball.obj"), *numbers], capture_output=True, check=True, timeout=120)
    _, mark, answer = done.stdout.partition(materialx_child.MARK)
    assert mark, done.stderr.decode()[-400:]
    verdict, _, body = answer.partition(b"\n")
    assert verdict == b"valid"
    return np.frombuffer(body, np.float32).reshape(SIDE, SIDE, 3).astype(np.float64)


def draw_ourselves(text: str, lamp: Floats) -> tuple[Floats, NDArray[np.bool_]]:
    place = (np.arange(SIDE) + 0.5) / SIDE * 2.0 - 1.0
    x, y = np.meshgrid(place, -place)
    mask = x * x + y * y < 0.95
    normal = np.stack([x, y, np.sqrt(np.maximum(1.0 - x * x - y * y, 0.0))], axis=-1)[mask]
    tangent = normalize(np.stack([-normal[:, 1], normal[:, 0], 0.0 * normal[:, 0]], axis=-1))
    frames = np.stack([tangent, np.cross(normal, tangent), normal], axis=2)
    wi, wo = np.einsum("nij,i->nj", frames, lamp), frames[:, 2, :]
    image = np.zeros((SIDE, SIDE, 3))
    image[mask] = np.pi * layers_of(text).f(wi, wo) * np.maximum(wi[:, 2:], 0.0)
    return image, mask


@pytest.mark.parametrize(
    ("text", "most"),
    [
        ("openpbr:base_color=0.5/0.9/0.2,specular_roughness=0.5,specular_ior=1.8,base_diffuse_roughness=0.5", 0.03),
        ("openpbr:base_color=0.1/0.6/0.9,coat_weight=0.8,coat_roughness=0.35,coat_color=0.9/0.6/0.5", 0.03),
        ("openpbr:base_color=0.4/0.1/0.2,fuzz_weight=0.8,fuzz_roughness=0.4,fuzz_color=1/0.7/0.5", 0.03),
        (
            "openpbr:base_color=0,thin_film_weight=1,thin_film_thickness=0.4,thin_film_ior=1.3,specular_roughness=0.3",
            0.04,
        ),
        ("openpbr:base_color=0.9/0.7/0.4,base_metalness=1,specular_color=0.9/0.8/1,specular_roughness=0.3", 0.03),
    ],
)
def test_materialx_draws_what_we_draw(tmp_path: Path, text: str, most: float) -> None:
    """A ball under two lamps, by the renderer of MaterialX on another implementation of the standard: within 3 %."""
    pytest.importorskip("MaterialX", reason="MaterialX is not installed")
    display = with_display()
    if display is None:
        pytest.skip("there is no display, and xvfb-run is not installed")
    half_ball(tmp_path / "ball.obj")
    for lamp in (normalize(np.array([0.6, 0.3, 0.742])), normalize(np.array([-0.5, 0.5, 0.5]))):
        theirs = draw_by_materialx(tmp_path, text, lamp, display)
        ours, mask = draw_ourselves(text, lamp)
        assert np.sqrt(((ours - theirs)[mask] ** 2).sum() / (theirs[mask] ** 2).sum()) < most
