"""Faces that are turned against each other or inside out are mended, whatever was done to them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from engine.geometry.mesh import mesh_of_arrays, read_mesh
from engine.geometry.orientation import find_turned

Faces = NDArray[np.int64]
SOLIDS = {
    "ball": trimesh.creation.icosphere(2),
    "box": trimesh.creation.box(),
    "ring": trimesh.creation.torus(1.0, 0.3, 16, 12),
    "pipe": trimesh.creation.annulus(0.5, 0.8, 1.0, 16),
}


def turn(faces: Faces, which: NDArray[np.bool_]) -> Faces:
    return np.where(which[:, None], faces[:, ::-1], faces)


def find(points: NDArray[np.float64], faces: Faces, votes: NDArray[np.float64] | None = None) -> NDArray[np.bool_]:
    a, b, c = (np.asarray(points, np.float64)[faces[:, corner]] for corner in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return find_turned(np.asarray(points, np.float64), np.asarray(faces, np.int64), area if votes is None else votes)


@given(st.sampled_from(sorted(SOLIDS)), st.integers(0, 99), st.floats(0.0, 1.0))
def test_whatever_is_turned_of_a_closed_surface_is_turned_back(name: str, seed: int, share: float) -> None:
    solid = SOLIDS[name]
    which = np.random.default_rng(seed).random(len(solid.faces)) < share
    assert (find(solid.vertices, turn(np.array(solid.faces), which)) == which).all()


@given(st.integers(0, 99))
def test_a_surface_with_small_holes_faces_outwards(seed: int) -> None:
    ball = SOLIDS["ball"]
    random = np.random.default_rng(seed)
    faces = np.delete(np.array(ball.faces), random.choice(len(ball.faces), 4, replace=False), axis=0)
    which = random.random(len(faces)) < 0.9
    assert (find(ball.vertices, turn(faces, which)) == which).all()


def test_holes_are_measured_one_by_one() -> None:
    """Fourteen holes of a face each are 4 % of this ball; one whose rim is as long as theirs would be most of it."""
    ball = SOLIDS["ball"]
    some = np.argsort(ball.triangles_center @ (1.0, 0.3, 0.2))[::24]
    apart = np.setdiff1d(np.arange(len(ball.faces)), some)
    assert find(ball.vertices, np.array(ball.faces)[apart][:, ::-1]).all()


def test_an_open_surface_stays_as_most_of_it_is() -> None:
    """A bowl may be meant from within; its normals, where a file states them, are those of its front."""
    ball = SOLIDS["ball"]
    faces = np.array(ball.faces)[ball.triangles_center[:, 2] < 0.0][:, ::-1]
    which = np.arange(len(faces)) % 4 == 0
    assert (find(ball.vertices, turn(faces, which)) == which).all()
    bowl = mesh_of_arrays(ball.vertices, turn(faces, which))
    assert (np.einsum("vi,vi->v", bowl.normals, bowl.positions) < 0.0).all()


def test_the_hollow_of_a_wall_turns_with_the_wall() -> None:
    outer, inner = trimesh.creation.icosphere(2, radius=2.0), trimesh.creation.icosphere(1, radius=1.0)
    inner.invert()
    wall = trimesh.util.concatenate([outer, inner])
    assert not find(wall.vertices, np.array(wall.faces)).any()
    assert find(wall.vertices, np.array(wall.faces)[:, ::-1]).all()
    solid_in_solid = trimesh.util.concatenate([outer, trimesh.creation.icosphere(1, radius=1.0)])
    assert not find(solid_in_solid.vertices, np.array(solid_in_solid.faces)).any()


def test_solids_that_share_an_edge_are_turned_each_by_itself() -> None:
    one, other = trimesh.creation.box(), trimesh.creation.box()
    other.apply_translation((1.0, 1.0, 0.0))
    both = trimesh.util.concatenate([one, other])
    both.merge_vertices()
    which = np.arange(len(both.faces)) < len(one.faces)
    assert (find(both.vertices, turn(np.array(both.faces), which)) == which).all()


def test_a_strip_with_one_side_stays_as_it_is() -> None:
    turn_by = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(turn_by), np.sin(turn_by), 0.0 * turn_by], -1)
    half = 0.2 * (np.cos(turn_by / 2.0)[:, None] * ring + np.sin(turn_by / 2.0)[:, None] * (0.0, 0.0, 1.0))
    points = np.stack([ring - half, ring + half], 1).reshape(-1, 3)
    corners = np.arange(48).reshape(24, 2)
    following = np.roll(corners, -1, axis=0)
    following[-1] = following[-1][::-1]
    quads = np.stack([corners[:, 0], corners[:, 1], following[:, 1], following[:, 0]], -1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    assert not find(points, faces).any()


def test_normals_of_a_file_turn_with_its_faces_or_stay_where_they_are_right(tmp_path: Path) -> None:
    ball = SOLIDS["ball"]
    normals = ball.vertices / np.linalg.norm(ball.vertices, axis=1, keepdims=True)
    some = np.random.default_rng(3).random(len(ball.faces)) < 0.4
    for number, (faces, stated) in enumerate(
        (
            (np.array(ball.faces)[:, ::-1], -normals),
            (np.array(ball.faces)[:, ::-1], normals),
            (turn(np.array(ball.faces), some), normals),
        )
    ):
        path = tmp_path / f"{number}.obj"
        lines = [f"v {x} {y} {z}" for x, y, z in ball.vertices] + [f"vn {x} {y} {z}" for x, y, z in stated]
        lines += ["f " + " ".join(f"{each}//{each}" for each in face) for face in faces + 1]
        path.write_text("\n".join(lines))
        mesh = read_mesh(path)
        assert np.einsum("vi,vi->v", mesh.normals, mesh.positions).min() > 0.9
        assert mesh.topology.volume > 0.0
        assert mesh.topology.closed
        assert any("turned" in text for text in mesh.health.warnings)


def test_a_model_is_kept_or_turned_as_a_whole_where_the_user_says_so(tmp_path: Path) -> None:
    box = trimesh.creation.box()
    path = tmp_path / "inside_out.ply"
    trimesh.Trimesh(box.vertices, np.array(box.faces)[:, ::-1], process=False).export(path)
    assert read_mesh(path).topology.volume == pytest.approx(1.0)
    assert read_mesh(path, "keep").topology.volume == pytest.approx(-1.0)
    assert read_mesh(path, "flip").topology.volume == pytest.approx(1.0)
    assert not any("turned" in text for text in read_mesh(path, "flip").health.warnings)


def test_both_sides_of_a_sheet_stay_turned_against_each_other() -> None:
    plane = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    faces = np.array([[0, 1, 2], [2, 3, 0], [2, 1, 0], [3, 2, 0]])
    assert not find(plane, faces).any()
    turned = find(plane, turn(faces, np.array([False, True, False, True])))
    assert turned[1] == turned[3] != turned[0] == turned[2]
