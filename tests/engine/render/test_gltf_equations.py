"""glTF materials as drawn against the equations of the specification (glTF 2.0, Appendix B), written here again.

A tilted square with textures that are the same all over, a transform that picks a half of them, a map of normals and
colours of its corners, under one light: every pixel can be calculated by hand. What the specification adds by
extensions is calculated as they say (KHR_materials_ior, _specular, _clearcoat, _sheen, _unlit); light that goes
through is lost, which the reader says, and is compared for that alone.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core.steps import drain
from engine.exchange.readers.read import open_material
from engine.geometry.camera import Camera
from engine.geometry.mesh import read_mesh
from engine.images.encode import encode_png
from engine.render.direct import radiance
from engine.scene.material import set_multiple_scattering
from engine.scene.scene import make_scene
from tests.engine.gltf_models import Model

Floats = NDArray[np.float64]

SIZE = 12
EYE = np.array([0.3, -0.2, 2.5])
CAMERA = Camera(tuple(EYE), (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), 30.0)

#: The share of the mean colour of an image that may differ.
BOUND = 0.01


class Case(NamedTuple):
    """A material of glTF, its images, colours of the corners or None, and the light."""

    material: dict[str, Any]
    images: list[NDArray[np.uint8]]
    colours: Floats | None
    light: Floats


def draw_case(seed: int) -> Case:
    random = np.random.default_rng(seed)
    images: list[NDArray[np.uint8]] = []

    def texture(codes: Any) -> dict[str, Any]:
        """A texture of one colour; at times the right half of an image, as a transform says."""
        images.append(np.broadcast_to(np.asarray(codes, np.uint8), (16, 16, 3)).copy())
        found: dict[str, Any] = {"index": len(images) - 1}
        if random.random() < 0.5:
            images[-1][:, :8] = 255 - images[-1][:, :8]
            found["extensions"] = {"KHR_texture_transform": {"offset": [0.6, 0.1], "scale": [0.3, 0.8]}}
        return found

    pbr: dict[str, Any] = {
        "baseColorFactor": [*random.random(3), 1.0],
        "roughnessFactor": float(random.uniform(0.25, 1.0)),
        "metallicFactor": float(random.choice([0.0, 1.0, random.random()])),
    }
    material: dict[str, Any] = {"pbrMetallicRoughness": pbr}
    if random.random() < 0.6:
        pbr["baseColorTexture"] = texture(random.integers(0, 256, 3))
    if random.random() < 0.4:
        pbr["metallicRoughnessTexture"] = texture(random.integers(128, 256, 3))
    if random.random() < 0.4:
        bent = np.array([*random.uniform(-0.4, 0.4, 2), 1.0])
        codes = np.round((bent / np.linalg.norm(bent) + 1.0) * 127.5)
        material["normalTexture"] = {**texture(codes), "scale": float(random.uniform(0.5, 1.0))}
    extensions: dict[str, Any] = {}
    material["extensions"] = extensions
    if random.random() < 0.4:
        extensions["KHR_materials_ior"] = {"ior": float(random.uniform(1.1, 2.2))}
    if random.random() < 0.3:
        extensions["KHR_materials_specular"] = {"specularFactor": float(random.uniform(0.3, 1.0))}
    if random.random() < 0.1:
        extensions["KHR_materials_unlit"] = {}
    kind = random.choice(["", "", "", "clearcoat", "sheen", "transmission"])
    layers: dict[str, dict[str, Any]] = {
        "clearcoat": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.7, "clearcoatRoughnessFactor": 0.3}},
        "sheen": {"KHR_materials_sheen": {"sheenColorFactor": [0.4, 0.3, 0.2], "sheenRoughnessFactor": 0.5}},
        "transmission": {"KHR_materials_transmission": {"transmissionFactor": 0.4}},
    }
    extensions |= layers.get(str(kind), {})
    colours = random.random((4, 3)) if random.random() < 0.3 else None
    light = np.array([*random.uniform(-0.8, 0.8, 2), 1.0])
    places = {
        str(each.get("extensions")) for each in (*pbr.values(), material.get("normalTexture")) if isinstance(each, dict)
    }
    if len(places) > 1:  # of textures that differ in it, the first holds, which is said
        return draw_case(seed + 100_000)
    return Case(material, images, colours, light / np.linalg.norm(light))


def write_case(case: Case, path: Path) -> None:
    uris = [{"uri": "data:image/png;base64," + base64.b64encode(encode_png(each)).decode()} for each in case.images]
    model = Model([case.material], images=uris, textures=[{"source": at} for at in range(len(uris))])
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    more = {} if case.colours is None else {"COLOR_0": case.colours}
    uv = (corners[:, :2] * (0.5, -0.5) + 0.5).astype(float)
    model.add(corners, [0, 1, 2, 0, 2, 3], NORMAL=[[0, 0, 1]] * 4, TEXCOORD_0=uv, material=0, **more)
    path.write_text(json.dumps(model.tree))


def decode(image: NDArray[np.uint8], *, coded: bool) -> Floats:
    value = image[8, 12] / 255.0
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4) if coded else value


def calculate(case: Case) -> Floats:
    """(SIZE, SIZE, 3) radiance by Appendix B under a light of irradiance π."""
    pbr, extensions = case.material["pbrMetallicRoughness"], case.material["extensions"]
    base = np.array(pbr["baseColorFactor"][:3])
    roughness, metallic, normal = pbr["roughnessFactor"], pbr["metallicFactor"], np.array([0.0, 0.0, 1.0])
    if "baseColorTexture" in pbr:
        base = base * decode(case.images[pbr["baseColorTexture"]["index"]], coded=True)
    if "metallicRoughnessTexture" in pbr:
        packed = decode(case.images[pbr["metallicRoughnessTexture"]["index"]], coded=False)
        roughness, metallic = roughness * packed[1], metallic * packed[2]
    if "normalTexture" in case.material:
        given = case.material["normalTexture"]
        normal = (2.0 * decode(case.images[given["index"]], coded=False) - 1.0) * (given["scale"], given["scale"], 1.0)
        normal = normal / np.linalg.norm(normal)

    # the plane z = 0 through the middles of the pixels
    forward = -EYE / np.linalg.norm(EYE)
    right = np.cross(forward, (0.0, 1.0, 0.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    extent = np.tan(np.radians(CAMERA.fov_deg) / 2.0)
    steps = (np.arange(SIZE) + 0.5) / SIZE * 2.0 - 1.0
    rays = forward + extent * (steps[None, :, None] * right - steps[:, None, None] * up)
    place = EYE - rays * (EYE[2] / rays[..., 2:])
    view = EYE - place
    view /= np.linalg.norm(view, axis=-1, keepdims=True)
    base = np.broadcast_to(base, place.shape)
    if case.colours is not None:
        base = base * interpolate(case.colours, place)

    nl, nv = np.maximum(case.light @ normal, 0.0), view @ normal
    half = case.light + view
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    vh, nh = np.sum(view * half, axis=-1), half @ normal
    if "KHR_materials_unlit" in extensions:
        return base * case.light[2]  # which is drawn as a diffuse surface without relief
    alpha = roughness**2
    ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
    weight = extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0)
    schlick = (1.0 - np.abs(vh)) ** 5
    spread = alpha**2 / (np.pi * (nh**2 * (alpha**2 - 1.0) + 1.0) ** 2)
    seen = [1.0 / (cosine + np.sqrt(alpha**2 + (1.0 - alpha**2) * cosine**2)) for cosine in (nl, nv)]
    highlight = (spread * seen[0] * seen[1])[..., None]
    # B.3.5: with one roughness and Schlick's term the mixture of metal and dielectric is one lobe over one base
    f0 = (1.0 - metallic) * min(((ior - 1.0) / (ior + 1.0)) ** 2, 1.0) * weight + metallic * base
    f90 = (1.0 - metallic) * weight + metallic
    fresnel = f0 + (f90 - f0) * schlick[..., None]
    found = np.pi * nl * ((1.0 - fresnel) * (1.0 - metallic) * base / np.pi + fresnel * highlight)
    if "KHR_materials_sheen" in extensions:
        # sheen_material = sheenColor * sheen_brdf + material * sheen_albedo_scaling, about the normal of the material
        given = extensions["KHR_materials_sheen"]
        colour, rough = np.array(given["sheenColorFactor"]), given["sheenRoughnessFactor"]
        albedo = np.maximum(calculate_sheen_albedo(np.array([nl]), rough), calculate_sheen_albedo(nv.ravel(), rough))
        scaling = (1.0 - colour.max() * albedo).reshape(nv.shape)[..., None]
        found = scaling * found + colour * (np.pi * nl * calculate_sheen(nl, nv, nh, rough))[..., None]
    if "KHR_materials_clearcoat" in extensions:
        # coated_material = mix(material, clearcoat_brdf, clearcoat * clearcoat_fresnel), about the surface's own normal
        given = extensions["KHR_materials_clearcoat"]
        lc, vc, hc = case.light[2], view[..., 2], half[..., 2]
        coat_fresnel = 0.04 + (1.0 - 0.04) * (1.0 - np.abs(vc)) ** 5
        alpha = given["clearcoatRoughnessFactor"] ** 2
        spread = alpha**2 / (np.pi * (hc**2 * (alpha**2 - 1.0) + 1.0) ** 2)
        smith = [2.0 * c / (c + np.sqrt(alpha**2 + (1.0 - alpha**2) * c**2)) for c in (lc, vc)]
        coat = spread * smith[0] * smith[1] / (4.0 * lc * vc)
        share = (given["clearcoatFactor"] * coat_fresnel)[..., None]
        found = (1.0 - share) * found + share * (np.pi * lc * coat)[..., None]
    return found


def calculate_sheen(nl: Any, nv: Any, nh: Any, roughness: float) -> Floats:
    """Distribution times visibility, as the implementation notes of KHR_materials_sheen have them."""
    alpha_g = roughness * roughness
    one_minus_alpha_sq = (1.0 - alpha_g) * (1.0 - alpha_g)
    ends = [(21.5473, 25.3245), (3.82987, 3.32435), (0.19823, 0.16801), (-1.97760, -1.27393), (-4.32054, -4.85967)]
    a, b, c, d, e = (one + (other - one) * one_minus_alpha_sq for one, other in ends)

    def lines(x: Any) -> Any:
        return a / (1.0 + b * x**c) + d * x + e

    def shadow(cosine: Any) -> Any:
        above = np.exp(2.0 * lines(0.5) - lines(np.maximum(1.0 - cosine, 0.0)))
        return np.where(np.abs(cosine) < 0.5, np.exp(lines(cosine)), above)

    inverse = 1.0 / alpha_g
    distribution = (2.0 + inverse) * (1.0 - nh * nh) ** (inverse * 0.5) / (2.0 * np.pi)
    return np.asarray(distribution / ((1.0 + shadow(nv) + shadow(nl)) * (4.0 * nv * nl)))


def calculate_sheen_albedo(cosines: Floats, roughness: float) -> Floats:
    """E by the midpoint rule over light, at few cosines and between them by a line."""
    nodes = np.linspace(max(cosines.min() - 1e-3, 1e-3), min(cosines.max() + 1e-3, 1.0), 6)
    heights, turns = (np.arange(200) + 0.5) / 200.0, 2.0 * np.pi * (np.arange(120) + 0.5) / 120.0
    low = heights[:, None] ** 2
    found = []
    for v in nodes:
        across = np.sqrt(1.0 - v * v) * np.sqrt(1.0 - low * low) * np.cos(turns)
        nh = (low + v) / np.sqrt(2.0 + 2.0 * (across + low * v))
        values = calculate_sheen(low, v, nh, roughness) * low * 2.0 * heights[:, None]
        found.append(values.mean() * 2.0 * np.pi)
    return np.interp(cosines, nodes, found)


def interpolate(colours: Floats, place: Floats) -> Floats:
    """Colours of the corners over the two triangles, linear in each."""
    x, y = (place[..., at] * 0.5 + 0.5 for at in range(2))
    below = np.stack([1.0 - x, x - y, y, np.zeros_like(x)], axis=-1)
    above = np.stack([1.0 - y, np.zeros_like(x), x, y - x], axis=-1)
    return np.where((x >= y)[..., None], below, above) @ colours


def compare(seed: int, folder: Path) -> tuple[Case, float, list[str]]:
    """The case, the difference of the images over their mean, and what the reader says."""
    case = draw_case(seed)
    path = folder / f"{seed}.gltf"
    write_case(case, path)
    mesh, material = read_mesh(path), open_material(path, parts=True)
    plain = set_multiple_scattering(material, False)  # which the specification leaves out
    scene = make_scene(
        mesh, CAMERA, brdf=plain.reflectance, material=plain, light=tuple(case.light), irradiance=np.pi, repeats=1.0
    )
    found = drain(radiance(scene, (SIZE, SIZE), samples=1))[..., :3]
    wanted = calculate(case)
    return case, float(np.abs(found - wanted).mean() / wanted.mean()), material.health.warnings


def check(seed: int, folder: Path) -> None:
    case, error, warnings = compare(seed, folder)
    words = " ".join(warnings)
    others = {"transmission": "goes through the surface is lost"}
    (other,) = [name for name in others if f"KHR_materials_{name}" in case.material["extensions"]] or [""]
    if other == "transmission" and case.material["pbrMetallicRoughness"]["metallicFactor"] == 1.0:
        other = "" if "lost" not in words else other  # metals let nothing through
    is_unlit = "KHR_materials_unlit" in case.material["extensions"]
    if other and not is_unlit:
        assert others[other] in words
    else:
        assert error < BOUND, (seed, error, json.dumps(case.material))


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_materials_of_gltf_are_drawn_as_it_says(seed: int, tmp_path: Path) -> None:
    check(seed, tmp_path)


@pytest.mark.long
def test_a_hundred_materials_of_gltf_are_drawn_as_it_says(tmp_path: Path) -> None:
    for seed in range(100):
        check(seed, tmp_path)
