"""Frames along texture coordinates and brushes, where these say something and where they do not."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.directions import dot, frames_along, normalize, uv_tangents, world_from_tangent
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh, complete
from engine.geometry.shapes import shape
from engine.gl.direct import DirectRenderer
from engine.render.direct import radiance
from engine.scene.scene import Scene


def test_F2_normals_that_are_none_become_those_of_the_face() -> None:
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    faces = np.array([[0, 1, 2], [1, 3, 2]])
    for useless in ((0.0, 0.0, 0.0), (np.nan, 0.0, 1.0), (0.0, 0.0, np.inf)):
        normals = np.array([useless, (0.0, 0.0, 7.0), (0.0, 0.0, 1e-9), (0.0, 0.0, 1.0)])
        arrays = complete(positions, faces, normals, None, "sheet")
        assert arrays["normals"] == pytest.approx(np.broadcast_to([0.0, 0.0, 1.0], (4, 3)))
        assert arrays["figures"]["normals_replaced"] == 1


def test_F3_frames_are_right_handed_and_mirrored_texture_keeps_its_sign() -> None:
    rng = np.random.default_rng(3)
    normal, brush = normalize(rng.normal(size=(10_000, 3))), rng.normal(size=(10_000, 3))
    frames = frames_along(normal, brush)
    assert np.linalg.det(frames) == pytest.approx(np.ones(len(normal)), abs=4e-15)
    assert np.abs(np.einsum("nij,nik->njk", frames, frames) - np.eye(3)).max() < 4e-15
    assert (dot(frames[..., 0], brush) > 0.0).all()

    positions = np.array([[0.0, 0, 0], [2, 0, 0], [0, 3, 0], [2, 3, 0]])
    up, faces = np.tile(np.array([0, 0, 1], np.float32), (4, 1)), np.array([[0, 1, 2], [1, 3, 2]], np.int32)
    straight = positions[:, :2].astype(np.float32)
    for uv, tangent, sign in (
        (straight, (1, 0, 0), 1.0),
        (straight * (-1, 1), (-1, 0, 0), -1.0),
        (straight[:, ::-1], (0, 1, 0), -1.0),
        (straight[:, ::-1] * (1, -1), (0, 1, 0), 1.0),
    ):
        found, signs = uv_tangents(positions, up, uv.astype(np.float32), faces)
        assert found == pytest.approx(np.broadcast_to(tangent, (4, 3)))
        assert signs.tolist() == [sign] * 4


@pytest.mark.parametrize("useless", [(0, 0, 1), (0, 0, -3e8), (0, 0, 0), (np.nan, 1, 0), (1e-9, 0, 1)])
def test_F4_a_brush_along_the_normal_falls_back(useless: tuple[float, ...]) -> None:
    up = np.array([0.0, 0.0, 1.0])
    assert np.array_equal(frames_along(up, useless), world_from_tangent(up))


def test_texture_without_area_or_that_cancels_falls_back() -> None:
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [-1, 0, 0]])
    up, faces = np.tile(np.array([0, 0, 1], np.float32), (4, 1)), np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    for uv in (np.zeros((4, 2)), np.abs(positions[:, :2])):
        tangents, _ = uv_tangents(positions, up, uv.astype(np.float32), faces)
        assert tangents[0] == pytest.approx(world_from_tangent((0.0, 0.0, 1.0))[:, 0])


def test_made_texture_coordinates_brush_nothing() -> None:
    sphere = shape("sphere")
    health = dataclasses.replace(sphere.health, figures={"texture_coordinates_made": 1.0})
    made = Mesh(sphere.positions, sphere.normals, sphere.uv, sphere.faces, "made", health)
    wanted = world_from_tangent(normalize(made.normals))[..., 0]
    assert made.tangents == pytest.approx(wanted, abs=1e-6)
    assert not np.allclose(sphere.tangents, wanted, atol=0.1)


def test_brushed_materials_run_along_the_texture_alike_on_both_renderers(gl: Any) -> None:
    camera = Camera((0.0, 0.0, 4.0))
    for text in ("ward:kd=0.05,ks=0.5,alpha_x=0.08,alpha_y=0.5", "ggx:kd=0.1,alpha_x=0.5,alpha_y=0.1,f0=0.5"):
        scene = Scene(shape("torus-knot"), camera, brdf_from_text(text))
        renderer = DirectRenderer(gl)
        drawn = renderer.radiance(scene, (96, 72), samples=1)
        renderer.release()
        computed = drain(radiance(scene, (96, 72), samples=1))
        inside = (drawn[..., 3] == 1.0) & (computed[..., 3] == 1.0)
        difference = np.abs(drawn - computed)[inside][:, :3].max(axis=1)
        assert np.mean(difference > 1e-3) < 0.01
        assert inside.sum() > 500
