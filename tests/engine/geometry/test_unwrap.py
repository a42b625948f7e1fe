"""Charts of texture: of even density, none mirrored, none over another, the same every time, bounded in time."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

from engine.core.errors import InputError
from engine.geometry import unwrap
from engine.geometry.mesh import Mesh, complete
from engine.geometry.unwrap import MAX_FACES, atlas, with_atlas

SOLIDS = {
    "box": trimesh.creation.box((1, 2, 3)),
    "sphere": trimesh.creation.icosphere(3),
    "torus": trimesh.creation.torus(2.0, 0.7),
    "two": trimesh.util.concatenate(
        [trimesh.creation.icosphere(1), trimesh.creation.box().apply_translation((3.0, 0, 0))]
    ),
}


def arrays_of(name: str, scale: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    return np.array(SOLIDS[name].vertices) * scale, np.array(SOLIDS[name].faces, np.int64)


def areas(uv: np.ndarray) -> np.ndarray:
    """Twice the signed areas of triangles (F, 3, 2)."""
    first, second = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_charts_are_even_and_not_mirrored(name: str, scale: float) -> None:
    points, faces = arrays_of(name, scale)
    uv = atlas(points, faces)
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    surface = np.linalg.norm(np.cross(b - a, c - a), axis=1) / np.max(np.ptp(points, axis=0)) ** 2
    assert areas(uv).min() > 0.0
    density = np.sqrt(areas(uv) / surface)
    assert density.min() > 0.6
    assert density.max() < 1.5
    assert np.sqrt(areas(uv).sum() / surface.sum()) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("name", SOLIDS)
def test_charts_do_not_overlap(name: str) -> None:
    uv = atlas(*arrays_of(name))
    random = np.random.default_rng(1).random((3000, 2)) * uv.max(axis=(0, 1))
    inside = np.ones((len(random), len(uv)), bool)
    for corner in range(3):
        start, along = uv[:, corner], uv[:, (corner + 1) % 3] - uv[:, corner]
        offset = random[:, None] - start
        inside &= along[:, 0] * offset[..., 1] - along[:, 1] * offset[..., 0] > 1e-9
    assert inside.sum(axis=1).max() == 1
    assert inside.any(axis=1).mean() > 0.3


def reply_of(name: str) -> dict[str, Any]:
    return complete(*arrays_of(name), None, None, name)


@pytest.mark.parametrize("name", SOLIDS)
def test_charts_change_nothing_but_the_texture_and_are_the_same_every_time(name: str) -> None:
    box, reply, again = reply_of(name), reply_of(name), reply_of(name)
    (finding,) = with_atlas(reply, "solid.ply")
    with_atlas(again, "solid.ply")
    assert "charts that do not overlap" in finding.text
    for field in ("positions", "normals", "uv", "faces"):
        assert np.array_equal(reply[field], again[field]), field
    for field in ("positions", "normals"):
        assert np.array_equal(reply[field][reply["faces"]], box[field][box["faces"]]), field
    mesh = Mesh(reply["positions"], reply["normals"], reply["uv"], reply["faces"], name)
    assert np.linalg.norm(mesh.tangents, axis=1) == pytest.approx(np.ones(len(mesh.positions)), abs=1e-6)
    assert mesh.topology.closed


def test_large_meshes_keep_the_box_projection_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unwrap, "MAX_FACES", 11)
    reply = reply_of("box")
    uv = reply["uv"].copy()
    (finding,) = with_atlas(reply, "solid.ply")
    assert "box projection: the mesh has 12 faces" in finding.text
    assert np.array_equal(reply["uv"], uv)
    assert MAX_FACES == 10_000
    monkeypatch.setattr(unwrap, "MAX_PARTS", 1)
    (finding,) = with_atlas(reply_of("two"), "solids.ply")
    assert "92 faces" in finding.text
    monkeypatch.setattr(unwrap, "MAX_FACES", 1000)
    (finding,) = with_atlas(reply_of("two"), "solids.ply")
    assert "box projection: the mesh has 2 parts" in finding.text


def test_charts_that_fail_keep_the_box_projection(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise InputError("solid.ply", "could not be decoded within 15 s", "")

    monkeypatch.setattr(unwrap, "decode_content", fail)
    reply = reply_of("box")
    (finding,) = with_atlas(reply, "solid.ply")
    assert finding.text.endswith("charts could not be cut (could not be decoded within 15 s)")


def test_charts_of_extreme_meshes_that_are_no_numbers_are_replaced() -> None:
    """xatlas works in 32 bits, in which a bar 10⁷ times as long as wide has charts of no size."""
    bar = trimesh.creation.icosphere(2)
    reply = complete(bar.vertices * (1e7, 1.0, 1.0), bar.faces, None, None, "bar")
    (finding,) = with_atlas(reply, "bar.ply")
    assert np.isfinite(reply["uv"]).all()
    assert "box projection: charts could not be cut" in finding.text
