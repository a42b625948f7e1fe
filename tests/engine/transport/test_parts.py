"""Bakes by part: each part as a bake of its BRDF alone in the shade of all, and near to the reference of the whole."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf, brdf_from_text
from engine.core.errors import InputError, UsageError
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.parts import parts_of_vertices, split_parts
from engine.light.environment import EnvironmentMap
from engine.light.lamps import Lamp
from engine.render.reference import reference
from engine.render.transported import image_of
from engine.scene.material import material_of_brdfs
from engine.scene.scene import Scene
from engine.transport.baking.file import TransportFile, open_transport
from engine.transport.baking.parts import MAX_KINDS, kinds_of
from engine.transport.baking.settings import BOUNCES
from engine.transport.baking.spatially_varying import variation_from_text
from engine.transport.gaussian import bake as gaussian_bake
from engine.transport.method import Method, Subject, method_of
from engine.transport.relight import Light, light_of
from engine.transport.reuse import with_brdf
from engine.transport.wavelet import bake as wavelet_bake
from tests.engine.planning.brute_force import sphere

ROUGH = brdf_from_text("lambert:albedo=0.7/0.2/0.1")
GLOSSY = brdf_from_text("ggx:alpha=0.4,kd=0.1/0.3/0.1")
METAL = brdf_from_text("metallic-roughness:base_color=0.9/0.7/0.3,metallic=1,roughness=0.6")
BRUSHED = brdf_from_text("ward:alpha_x=0.5,alpha_y=0.3")

NAMES = ("rough", "glossy", "again", "metal")
PARTS = (ROUGH, GLOSSY, ROUGH, METAL)

SETTINGS = {
    "sh": {"order": 3, "cube": 8},
    "wavelet": {"terms": 2, "cube": 8, "coefficients": 24},
    "gaussian": {"samples": 16, "order": 3, "cube": 8},
}


def bands(names: tuple[str, ...] = NAMES) -> Mesh:
    """A sphere of as many bands as there are names."""
    ball = sphere(8)
    height = ball.positions[ball.faces].mean(axis=1)[:, 1]
    part = np.digitize(height, np.linspace(-1.0, 1.0, len(names) + 1)[1:-1]).astype(np.int32)
    return split_parts(replace(ball, part=part, part_names=names))


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return bands()


@pytest.fixture(scope="module")
def light() -> Light:
    """A bright side, and a lamp."""
    around = np.full((8, 16, 3), 0.2, np.float32)
    around[2:4, 3:6] = (3.0, 2.0, 1.0)
    return Light(EnvironmentMap(around, "bright side"), lamps=(Lamp((0.6, 0.8, 0.0), (1.0, 1.0, 1.0)),))


@pytest.fixture(scope="module")
def file_of_parts(mesh: Mesh, tmp_path_factory: pytest.TempPathFactory) -> TransportFile:
    """A bake in spherical harmonics."""
    folder = tmp_path_factory.mktemp("parts")
    bake("sh", Subject(mesh, ROUGH, parts=PARTS), folder)
    return open_transport(folder / "sh.transport")


def bake(name: str, subject: Subject, folder: Path, **more: Any) -> tuple[Method, Any]:
    method = method_of(name)
    settings = method.with_values({**SETTINGS[name], **more})
    folder.mkdir(exist_ok=True)
    work = drain(method.baking.prepare(subject, settings))
    return method, drain(method.baking.bake(folder / f"{name}.transport", work)).transport


def radiance(method: Method, transport: Any, light: Light, vertices: NDArray[np.int64]) -> NDArray[np.float64]:
    """Radiance of vertices towards two eyes."""
    relit = method.baking.relight_transport(transport, light, method.light())
    corners, weights = np.repeat(vertices[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (len(vertices), 1))
    return np.stack([relit.shade(eye)(corners, weights) for eye in ((0.0, 1.0, 4.0), (3.0, -2.0, 1.0))])


@pytest.mark.parametrize("name", ["sh", "wavelet", "gaussian"])
def test_each_part_is_that_of_a_bake_of_its_brdf_alone(
    mesh: Mesh, light: Light, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The vertices of other parts shade it as they did, and its own are those of the bake of one BRDF."""
    monkeypatch.setattr(wavelet_bake, "MAP_SIZE", 8)
    monkeypatch.setattr(gaussian_bake, "PROBES", 2)
    ground = Ground(cells=2)
    method, transport = bake(name, Subject(mesh, ROUGH, ground, parts=PARTS), tmp_path)
    _, alone = bake(name, Subject(mesh, METAL, ground), tmp_path / "alone")
    own = np.flatnonzero(parts_of_vertices(mesh) == NAMES.index("metal"))
    found, exact = (radiance(method, each, light, own) for each in (transport, alone))
    assert found == pytest.approx(exact, rel=2e-3, abs=2e-3 * exact.max())
    assert exact.max() > 0.1
    on_ground = np.arange(len(mesh.positions), len(transport.mesh.positions))
    assert radiance(method, transport, light, on_ground).max() > 0.05


def bowl() -> tuple[Mesh, NDArray[np.float64]]:
    """The inside of the lower half of a sphere in two parts, and the shares (2,) of the sphere's area that they are."""
    ball = sphere(8)
    corners = ball.positions[ball.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    height = corners.mean(axis=1)[:, 1]
    kept, part = height < 0.0, (height > -0.7).astype(np.int32)
    shares = np.array([area[kept & (part == each)].sum() for each in range(2)]) / area.sum()
    inside = replace(ball, normals=-ball.normals, faces=ball.faces[kept][:, ::-1].copy())
    return split_parts(replace(inside, part=part[kept], part_names=("low", "high"))), shares


@pytest.mark.parametrize("name", ["sh", "wavelet", pytest.param("gaussian", marks=pytest.mark.long)])
def test_parts_light_each_other_as_in_a_sphere(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each point of a sphere sees any piece of it at its share of the area: of what all get, q = Σ shares × albedos
    goes on to all, so that under even light of 1 every point gets (1 − Σ shares)(1 + q + q² + q³)."""
    monkeypatch.setattr(wavelet_bake, "MAP_SIZE", 8)
    monkeypatch.setattr(gaussian_bake, "PROBES", 2)
    mesh, shares = bowl()
    albedo = np.array([[0.9, 0.1, 0.5], [0.1, 0.9, 0.5]])
    # Gaussians need a highlight, be it as faint as this
    text = "phong:ks=0.0001,kd=" if name == "gaussian" else "lambert:albedo="
    brdfs = tuple(brdf_from_text(text + "/".join(map(str, each))) for each in albedo)
    more = {"coefficients": 384} if name == "wavelet" else {}
    method, transport = bake(name, Subject(mesh, brdfs[0], parts=brdfs), tmp_path, interreflection=True, **more)
    even = Light(EnvironmentMap(np.ones((8, 16, 3), np.float32), "even"))
    relit = method.baking.relight_transport(transport, even, method.light())
    passed_on = shares @ albedo
    got = (1.0 - shares.sum()) * sum(passed_on**bounce for bounce in range(BOUNCES + 1))
    for number in range(2):
        own = np.unique(mesh.faces[mesh.part == number])
        corners, weights = np.repeat(own[:, None], 3, axis=1), np.tile([1.0, 0.0, 0.0], (len(own), 1))
        found = relit.shade((0.0, 3.0, 0.0))(corners, weights)
        assert np.median(found, axis=0) == pytest.approx(albedo[number] * got, rel=0.05)


def test_the_mean_light_of_parts_is_that_of_the_reference(
    mesh: Mesh, light: Light, file_of_parts: TransportFile
) -> None:
    method, transport = method_of("sh"), method_of("sh").baking.transport_of(file_of_parts)
    material, camera = material_of_brdfs(PARTS, NAMES), frame(mesh.positions)
    scene = Scene(mesh, camera, ROUGH, material, environment=light.environment)
    relit = method.baking.relight_transport(transport, light_of(scene), method.light())
    image, truth = (
        drain(image_of(relit, camera, (24, 24), 2)).image,
        drain(reference(scene, (24, 24), samples=16)).image,
    )
    inside = (image[..., 3] > 0.999) & (truth[..., 3] > 0.999)
    assert image[inside].sum(axis=0) == pytest.approx(truth[inside].sum(axis=0), rel=0.05)


def test_brushed_and_even_brdfs_lie_beside_each_other(light: Light, tmp_path: Path) -> None:
    mesh = bands(("rough", "brushed"))
    method, transport = bake("sh", Subject(mesh, ROUGH, parts=(ROUGH, BRUSHED)), tmp_path)
    own = np.flatnonzero(parts_of_vertices(mesh) == 0)
    _, alone = bake("sh", Subject(mesh, ROUGH), tmp_path)
    exact = radiance(method, alone, light, own)
    assert radiance(method, transport, light, own) == pytest.approx(exact, abs=0.02 * exact.max())


def test_a_file_that_names_parts_that_do_not_exist_is_refused(file_of_parts: TransportFile) -> None:
    kinds = file_of_parts.settings["part_kinds"]
    for changed in (
        {"part_kinds": [*kinds[:-1], 7]},
        {"part_kinds": kinds[:-1]},
        {"part_names": ["a"], "part_kinds": [0]},
        {"part_brdfs": json.loads("[]")},
    ):
        broken = replace(file_of_parts, settings={**file_of_parts.settings, **changed})
        with pytest.raises(InputError, match="transport that cannot be"):
            method_of("sh").baking.transport_of(broken)


def test_what_bakes_by_part_cannot_do_is_said(mesh: Mesh, file_of_parts: TransportFile, tmp_path: Path) -> None:
    subject = Subject(mesh, ROUGH, parts=PARTS)
    with pytest.raises(UsageError, match="--blend and --albedo are for a model of one BRDF"):
        bake("wavelet", subject, tmp_path, albedo="image.png")
    with pytest.raises(UsageError, match="bakes one BRDF"):
        replace(method_of("sh"), parts=False).check_parts(subject)
    with pytest.raises(UsageError, match="materials for its parts"):
        method_of("sh").check_parts(replace(subject, variations=(variation_from_text("albedo=0:1:y"),)))
    with pytest.raises(UsageError, match="have BRDFs of their own"):
        drain(with_brdf(file_of_parts, GLOSSY, None))


def test_more_brdfs_than_tables_are_refused() -> None:
    names = tuple(map(str, range(MAX_KINDS + 1)))
    mesh = replace(bands(names[:4]), part_names=names)
    many: list[Brdf] = [brdf_from_text(f"lambert:albedo={0.01 * number}") for number in range(len(names))]
    assert kinds_of(mesh, many) is not None  # only those count that a face has
    full = replace(mesh, part=np.arange(len(mesh.faces), dtype=np.int32) % len(names))
    with pytest.raises(UsageError, match=f"with {MAX_KINDS} are baked"):
        kinds_of(split_parts(full), many)
