"""glTF files: free of errors and warnings for Khronos' validator, and read back by trimesh."""

from __future__ import annotations

import dataclasses
import io
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
import trimesh

from engine.core.steps import drain
from engine.exchange.gltf import contents
from engine.exchange.subject import Settings, Subject
from engine.exchange.textures import ior_of

from .materials import measure_subject, woven_subject

#: The place where `npm install --prefix build/node gltf-validator` puts the validator.
NODE = Path(__file__).resolve().parents[3] / "build" / "node"

VALIDATE = """
const validator = require(require.resolve('gltf-validator', {paths: [process.argv[2], process.cwd()]}));
validator.validateBytes(new Uint8Array(require('fs').readFileSync(process.argv[1]))).then(
    report => console.log(JSON.stringify(report.issues)));
"""


def make_varied_subject() -> Subject:
    subject = measure_subject()
    f0 = np.linspace(0.02, 0.08, subject.maps.f0.size, dtype=np.float32).reshape(subject.maps.size)
    return dataclasses.replace(subject, maps=dataclasses.replace(subject.maps, f0=f0))


SUBJECTS = {"shading map": woven_subject, "measured": measure_subject, "f0 varies": make_varied_subject}


def file_of(subject: Subject) -> bytes:
    return drain(contents(subject, Settings(), "An error of 3 %.")).files["A_cloth_woven.glb"]


def document_of(glb: bytes) -> dict:
    length = int.from_bytes(glb[12:16], "little")
    document: dict = json.loads(glb[20 : 20 + length])
    return document


@pytest.mark.parametrize("name", SUBJECTS)
def test_the_validator_of_khronos_has_nothing_to_say(name: str, tmp_path: Path) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    (tmp_path / "x.glb").write_bytes(file_of(SUBJECTS[name]()))
    done = subprocess.run([node, "-e", VALIDATE, tmp_path / "x.glb", NODE], capture_output=True, text=True, timeout=120)
    if "Cannot find module" in done.stderr:
        pytest.skip("gltf-validator is missing: npm install --prefix build/node gltf-validator")
    issues = json.loads(done.stdout)
    assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]
    assert {message["code"] for message in issues["messages"]} <= {"IMAGE_NPOT_DIMENSIONS"}


def test_trimesh_reads_sphere_and_maps() -> None:
    subject = measure_subject()
    scene = trimesh.load(io.BytesIO(file_of(subject)), file_type="glb")
    (mesh,) = scene.geometry.values()
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1.0, atol=1e-6)
    material = mesh.visual.material
    orm = np.asarray(material.metallicRoughnessTexture, np.float64) / 255.0
    np.testing.assert_allclose(orm[..., 1], subject.maps.roughness, atol=0.51 / 255)
    np.testing.assert_allclose(orm[..., 2], subject.maps.metallic, atol=0.51 / 255)
    normal = np.asarray(material.normalTexture, np.float64) / 127.5 - 1.0
    np.testing.assert_allclose(normal, subject.maps.normal, atol=1.01 / 255)


def test_tangents_go_along_u_and_bitangents_up_the_image() -> None:
    """B = N x T w points to smaller v of glTF, which is up in an image whose row 0 is on top."""
    glb = file_of(woven_subject())
    document = document_of(glb)
    body = glb[28 + int.from_bytes(glb[12:16], "little") :]

    def values(name: str) -> np.ndarray:
        accessor = document["accessors"][document["meshes"][0]["primitives"][0]["attributes"][name]]
        view = document["bufferViews"][accessor["bufferView"]]
        width = {"VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        return np.frombuffer(body, np.float32, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)

    view = document["bufferViews"][document["accessors"][4]["bufferView"]]
    faces = np.frombuffer(body, np.uint32, document["accessors"][4]["count"], view["byteOffset"]).reshape(-1, 3)
    positions, uv, tangents, normals = (values(n) for n in ("POSITION", "TEXCOORD_0", "TANGENT", "NORMAL"))
    middle = faces[np.abs(positions[faces, 1]).max(axis=1) < 0.9]
    edges = positions[middle[:, 1:]] - positions[middle[:, :1]]
    steps = uv[middle[:, 1:]] - uv[middle[:, :1]]
    along = np.linalg.solve(steps.astype(np.float64), edges.astype(np.float64))
    corner = middle[:, 0]
    assert (np.einsum("fi,fi->f", along[:, 0], tangents[corner, :3]) > 0.0).all()
    bitangent = np.cross(normals[corner], tangents[corner, :3]) * tangents[corner, 3:]
    assert (np.einsum("fi,fi->f", -along[:, 1], bitangent) > 0.0).all()


def test_reflectance_other_than_usual_is_stated() -> None:
    plain = document_of(file_of(woven_subject()))
    assert "extensionsUsed" not in plain
    assert plain["asset"]["extras"]["lightarc_loss"] == "An error of 3 %."
    one = document_of(file_of(measure_subject()))["materials"][0]["extensions"]
    assert one == {"KHR_materials_ior": {"ior": pytest.approx(ior_of(0.06))}}
    assert ((ior_of(0.06) - 1.0) / (ior_of(0.06) + 1.0)) ** 2 == pytest.approx(0.06)
    varied = document_of(file_of(make_varied_subject()))
    assert varied["extensionsUsed"] == ["KHR_materials_ior", "KHR_materials_specular"]
    assert varied["images"][3]["name"] == "specularColor"


def test_a_sample_of_known_width_has_its_true_size_on_the_ball() -> None:
    """Four repeats of 50 mm go round the ball; glTF counts in metres."""
    file = drain(contents(measure_subject(), Settings(width_mm=50.0), "")).files["A_cloth_woven.glb"]
    document = document_of(file)
    assert document["nodes"][0]["scale"] == pytest.approx([4 * 0.05 / (2 * np.pi)] * 3)
    assert document["materials"][0]["extras"]["lightarc_width_mm"] == 50.0
    assert "scale" not in document_of(file_of(measure_subject()))["nodes"][0]
