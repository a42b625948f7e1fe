"""Cube maps: exact areas, OpenGL's orientation, and resampling that keeps constants, energy and directions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.light.cube_map import (
    CubeMap,
    cube_directions,
    cube_of,
    cube_solid_angles,
    direction_on_face,
    environment_of,
    face_coordinates,
    mean_radiance,
    resize,
    texel_numbers,
)
from engine.light.environment import EnvironmentMap, map_coordinates, solid_angles, texel_directions

AXES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
SIDES = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z], float)


def noise(height: int, width: int, seed: int = 0) -> EnvironmentMap:
    """A few texels are a thousand times as bright as the others."""
    return EnvironmentMap((1000 * np.random.default_rng(seed).random((height, width, 3)) ** 16).astype(np.float32))


def flux(environment: EnvironmentMap) -> np.ndarray:
    return (environment.radiance * solid_angles(*environment.radiance.shape[:2])[..., None]).sum(axis=(0, 1))


@pytest.mark.parametrize("n", [1, 2, 3, 16, 64, 512])
def test_H14_exact_areas_sum_to_the_sphere(n: int) -> None:
    assert abs(6.0 * cube_solid_angles(n).sum() - 4.0 * np.pi) <= 1e-13
    middle = direction_on_face(*(np.asarray(v) for v in (4, 0.5, 0.5)))
    assert middle.tolist() == [0.0, 0.0, 1.0]


def test_H14_areas_are_those_of_spherical_triangles() -> None:
    """Van Oosterom and Strackee 1983 for the two halves of each texel."""
    n = 5
    t, s = np.meshgrid(np.arange(n + 1) / n, np.arange(n + 1) / n, indexing="ij")
    corner = direction_on_face(np.full(s.shape, 4), s, t)
    a, b, c, d = corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]

    def triangle(p: np.ndarray, q: np.ndarray, r: np.ndarray) -> np.ndarray:
        volume = np.einsum("...i,...i->...", p, np.cross(q, r))
        return 2 * np.abs(np.arctan2(volume, 1 + (p * q + q * r + r * p).sum(axis=-1)))

    np.testing.assert_allclose(triangle(a, b, c) + triangle(a, c, d), cube_solid_angles(n), rtol=1e-12)


#: Axes along which s and t grow, from OpenGL 4.6, table 8.20.
OPENGL = {0: ("-z", "-y"), 1: ("+z", "-y"), 2: ("+x", "+z"), 3: ("+x", "-z"), 4: ("+x", "-y"), 5: ("-x", "-y")}


@pytest.mark.parametrize("face", range(6))
def test_EN13_faces_lie_as_in_opengl(face: int) -> None:
    directions = cube_directions(3)[face]
    assert np.allclose(directions[1, 1], AXES[face], atol=1e-15)
    for grown, name in zip(
        (directions[1, 2] - directions[1, 0], directions[2, 1] - directions[0, 1]), OPENGL[face], strict=True
    ):
        axis = "xyz".index(name[1])
        assert np.sign(grown[axis]) == (1 if name[0] == "+" else -1)
        assert np.abs(np.delete(grown, axis)).max() < 1e-15


def test_EN13_the_six_axes_and_all_26_directions_find_their_face() -> None:
    colours = np.arange(6)
    face, s, t = face_coordinates(AXES)
    assert np.array_equal(face, colours)
    assert (s == 0.5).all()
    assert (t == 0.5).all()
    face, s, t = face_coordinates(SIDES)
    assert np.allclose(direction_on_face(face, s, t) * np.linalg.norm(SIDES, axis=1)[:, None], SIDES, atol=1e-15)
    assert np.isin(s, (0.0, 0.5, 1.0)).all()
    assert np.isin(t, (0.0, 0.5, 1.0)).all()
    for n in (1, 4):
        directions = cube_directions(n)
        face, s, t = face_coordinates(directions)
        assert np.array_equal(face, np.broadcast_to(colours[:, None, None], face.shape))
        assert np.array_equal((s * n).astype(int), np.broadcast_to(np.arange(n), s.shape))
        assert np.array_equal((t * n).astype(int), np.broadcast_to(np.arange(n)[:, None], t.shape))


def test_EN13_six_colours_go_to_the_cube_and_back() -> None:
    colours = np.eye(3)[[0, 0, 1, 1, 2, 2]] * np.array([1, 2, 1, 2, 1, 2])[:, None]
    face, _, _ = face_coordinates(texel_directions(256, 512))
    painted = EnvironmentMap(colours[face].astype(np.float32))
    cube = cube_of(painted, 16)
    assert np.allclose(cube.radiance[:, 2:-2, 2:-2], colours[:, None, None], atol=1e-6)
    back = environment_of(cube, 256)
    u, v = map_coordinates(AXES)
    at = back.radiance[np.minimum((v * 256).astype(int), 255), (u * 512).astype(int)]
    assert np.allclose(at, colours, atol=1e-6)
    assert np.mean(np.abs(back.radiance - painted.radiance)) < 0.02


@pytest.mark.parametrize("n", [1, 3, 16])
def test_texels_hold_the_directions_through_them(n: int) -> None:
    assert (texel_numbers(cube_directions(n).reshape(-1, 3), n) == np.arange(6 * n * n)).all()
    assert set(texel_numbers(SIDES, n)) <= set(range(6 * n * n))
    assert (texel_numbers(5.0 * AXES, n) // (n * n) == np.arange(6)).all()


@pytest.mark.parametrize("n", [1, 2, 5, 64])
def test_directions_survive_both_ways(n: int) -> None:
    """A map of the directions themselves: each texel gets the mean direction of what it covers."""
    environment = EnvironmentMap((2.0 + texel_directions(128, 256)).astype(np.float32))
    cube = cube_of(environment, n)
    fine = 64 // n * n
    directions = cube_directions(fine).reshape(6, n, fine // n, n, fine // n, 3)
    weights = cube_solid_angles(fine).reshape(n, fine // n, n, fine // n)
    exact = np.einsum("faibjc,aibj->fabc", directions, weights) / weights.sum(axis=(1, 3))[..., None]
    np.testing.assert_allclose(cube.radiance - 2.0, exact, atol=0.01)


@pytest.mark.parametrize("n", [1, 2, 3, 7, 64])
@pytest.mark.parametrize("size", [(1, 1), (1, 2), (2, 4), (37, 50), (128, 256)])
def test_EN9_constants_stay_and_flux_is_kept(n: int, size: tuple[int, int]) -> None:
    constant = EnvironmentMap(np.full((*size, 3), 0.7, np.float32))
    assert np.abs(cube_of(constant, n).radiance / np.float32(0.7) - 1).max() <= 2e-7
    cube = CubeMap(np.full((6, n, n, 3), 0.7, np.float32))
    assert np.abs(environment_of(cube, size[0]).radiance / np.float32(0.7) - 1).max() <= 2e-7
    environment = noise(*size)
    cube = cube_of(environment, n)
    np.testing.assert_allclose(4 * np.pi * mean_radiance(cube), flux(environment), rtol=1e-6)
    np.testing.assert_allclose(flux(environment_of(cube, size[0])), flux(environment), rtol=1e-6)


@given(st.integers(0, 31), st.integers(0, 63), st.integers(1, 40))
def test_EN6_one_bright_texel_keeps_its_flux_and_its_place(row: int, column: int, n: int) -> None:
    radiance = np.zeros((32, 64, 3), np.float32)
    radiance[row, column] = 1e6
    environment = EnvironmentMap(radiance)
    cube = cube_of(environment, n)
    np.testing.assert_allclose(4 * np.pi * mean_radiance(cube), flux(environment), rtol=1e-6)
    mean = np.einsum("fij,ij,fijk->k", cube.radiance[..., 0], cube_solid_angles(n), cube_directions(n))
    apart = np.linalg.norm(mean / np.linalg.norm(mean) - texel_directions(32, 64)[row, column])
    assert apart <= 1.5 / n + 0.05


def test_EN9_the_pole_rows_and_the_seam_are_no_seams_in_the_cube() -> None:
    """A smooth map read with its seam at any longitude gives the rotated cube."""
    smooth = (2.0 + texel_directions(64, 128)).astype(np.float32)
    turned = cube_of(EnvironmentMap(np.ascontiguousarray(np.roll(smooth, 32, axis=1))), 8).radiance
    straight = cube_of(EnvironmentMap(smooth), 8).radiance
    np.testing.assert_allclose(turned[[4, 1, 5, 0]], straight[[0, 4, 1, 5]], atol=1e-6)  # +X to +Z to −X to −Z to +X
    np.testing.assert_allclose(turned[2], np.rot90(straight[2], -1), atol=1e-6)
    np.testing.assert_allclose(turned[3], np.rot90(straight[3]), atol=1e-6)


@pytest.mark.parametrize(("old", "new"), [(1, 8), (7, 8), (8, 7), (64, 16), (100, 128)])
def test_resizing_keeps_constants_and_flux(old: int, new: int) -> None:
    random = np.random.default_rng(1).random((6, old, old, 3)).astype(np.float32)
    cube = resize(CubeMap(random), new)
    assert cube.edge == new
    np.testing.assert_allclose(mean_radiance(cube), mean_radiance(CubeMap(random)), rtol=1e-6)
    constant = resize(CubeMap(np.full((6, old, old, 3), 0.3, np.float32)), new)
    assert np.abs(constant.radiance / np.float32(0.3) - 1).max() <= 2e-7
    assert resize(constant, new) is constant


def test_what_is_no_cube_is_refused() -> None:
    for shape in ((5, 2, 2, 3), (6, 2, 3, 3), (6, 2, 2, 4), (6, 0, 0, 3)):
        with pytest.raises(ValueError, match="cube map"):
            CubeMap(np.zeros(shape, np.float32))
    with pytest.raises(ValueError, match="finite"):
        CubeMap(np.full((6, 1, 1, 3), np.nan, np.float32))
    with pytest.raises(ValueError, match="at least 1"):
        cube_of(noise(2, 4), 0)
    with pytest.raises(ValueError, match="at least 1"):
        environment_of(CubeMap(np.ones((6, 1, 1, 3), np.float32)), 0)
