"""Backs of open surfaces: which faces get one, and that rays and images show the side that faces them."""

from __future__ import annotations

from pathlib import Path

import moderngl
import numpy as np
import pytest
import trimesh

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.backs import with_backs
from engine.geometry.camera import frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import BACKS, Mesh, mesh_of_arrays
from engine.geometry.ray_caster import caster_of
from engine.geometry.shapes import shape
from engine.gl.transported import TransportRenderer
from engine.light.environment_file import open_environment
from engine.render.reference import reference
from engine.render.transported import image_of
from engine.scene.scene import Scene
from engine.transport.method import Subject, method_of
from engine.transport.relight import light_of


def bowl(cut: float) -> Mesh:
    """A ball without what lies above the height `cut`."""
    ball = trimesh.creation.icosphere(3)
    return mesh_of_arrays(ball.vertices, np.array(ball.faces)[ball.triangles_center[:, 1] < cut])


def test_closed_surfaces_have_no_backs() -> None:
    for name in ("sphere", "torus-knot", "blob"):
        assert with_backs(shape(name)) is shape(name)


def test_a_sheet_has_a_back_to_each_face_after_its_fronts() -> None:
    plane = shape("plane")
    both = with_backs(plane)
    count = len(plane.faces)
    assert both.health.figures[BACKS] == count
    assert np.array_equal(both.faces[:count], plane.faces)
    fronts, backs = both.positions[both.faces[:count]], both.positions[both.faces[count:]]
    assert np.array_equal(fronts, backs[:, ::-1])
    assert np.array_equal(both.normals[len(plane.normals) :], -plane.normals)
    assert with_backs(both) is both


def test_a_sheet_on_the_ground_needs_none() -> None:
    corners = np.array([[-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 0.0, -1.0], [-1.0, 0.0, -1.0]])
    sheet = mesh_of_arrays(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    assert BACKS in with_backs(sheet).health.figures
    assert with_backs(sheet, Ground()) is sheet
    assert BACKS in with_backs(sheet, Ground(height=-2.0)).health.figures


@pytest.mark.parametrize(("cut", "some"), [(0.985, False), (0.0, True)])
def test_the_inside_has_one_where_it_sees_out(cut: float, some: bool) -> None:
    """Through a hole of 10° an inside sees less than an eighth of the sky; that of half a ball sees half of it."""
    assert (BACKS in with_backs(bowl(cut)).health.figures) == some


def test_rays_meet_the_side_that_faces_them() -> None:
    both = with_backs(shape("plane"))
    caster = caster_of(both)
    middle = both.centre + 0.01
    normal = both.normals[0].astype(np.float64)
    for side in (1.0, -1.0):
        hits = caster.intersect((middle + side * normal)[None], -side * normal[None])
        met = both.normals[both.faces[hits.face[0]]]
        assert (met @ normal * side > 0.9).all()
        corners = both.positions[both.faces[hits.face[0]]]
        reached = middle + side * normal * (1.0 - hits.distance[0])
        assert hits.barycentric[0] @ corners == pytest.approx(reached, abs=1e-9)


@pytest.mark.parametrize("mode", ["sh", "wavelet", "gaussian"])
def test_both_sides_of_a_bowl_are_lit_as_in_the_reference(mode: str, gl: moderngl.Context, tmp_path: Path) -> None:
    renderer = TransportRenderer(gl)
    mesh, brdf = bowl(0.0), brdf_from_text("ggx:kd=0.6,alpha=0.7,f0=0.04")
    method, subject = method_of(mode), Subject(with_backs(mesh), brdf)
    settings = method.settings(**({} if mode == "gaussian" else {"cube": 16}))
    baking = method.baking
    baked = drain(baking.bake(tmp_path / "bowl", drain(baking.prepare(subject, settings))))
    assert baked.file.mesh.health.figures[BACKS] == subject.mesh.health.figures[BACKS]
    relight = baking.relighter(baked.transport, subject)
    for direction in ((0.3, 1.0, 0.4), (0.3, -0.6, 0.8)):
        scene = Scene(mesh, frame(mesh.positions, direction=direction), brdf, environment=open_environment("overcast"))
        lit = drain(relight(light_of(scene), method.light(), brdf))
        truth = drain(reference(scene, (48, 48), samples=64)).image
        image = drain(image_of(lit, scene.camera, (48, 48))).image
        assert image[..., :3].sum() == pytest.approx(truth[..., :3].sum(), rel=0.04)
        drawn = renderer.radiance(lit, scene.camera, (48, 48))
        assert drawn[..., :3].sum() == pytest.approx(image[..., :3].sum(), rel=0.02)
        covered = (drawn[..., 3] > 0.99) & (truth[..., 3] > 0.99)
        assert (drawn[covered][:, :3].sum(axis=1) > 0.3 * truth[covered][:, :3].sum(axis=1)).all()
    renderer.release()
