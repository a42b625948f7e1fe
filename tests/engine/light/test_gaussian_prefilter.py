"""Maps under spherical Gaussians: constants, energy, the Gaussian itself on any face, edges, rotation, all widths."""

from __future__ import annotations

from functools import cache

import mpmath
import numpy as np
import pytest

from engine.light.cube_map import (
    CubeMap,
    cube_directions,
    cube_of,
    cube_solid_angles,
    direction_on_face,
    mean_radiance,
)
from engine.light.environment import EnvironmentMap, texel_directions
from engine.light.gaussian_prefilter import (
    PrefilteredCube,
    _node_weights,
    _pad,
    gaussian_integral,
    geometric_sigmas,
    prefilter,
    texel_width,
)
from engine.light.gaussian_prefilter_kernel import halve

N = 32


def gaussian(apart: np.ndarray, sigma: float) -> np.ndarray:
    """Of the distance between the ends of unit vectors, over its integral."""
    return np.exp(-0.5 * (apart / sigma) ** 2) / gaussian_integral(sigma)


def light_up(place: tuple[int, int, int], edge: int = N) -> CubeMap:
    """All light, of flux 1, from one texel."""
    radiance = np.zeros((6, edge, edge, 3), np.float32)
    radiance[place] = 1.0 / cube_solid_angles(edge)[place[1:]]
    return CubeMap(radiance)


def node_directions(level: np.ndarray) -> np.ndarray:
    along = np.linspace(0.0, 1.0, level.shape[1])
    face, t, s = np.meshgrid(np.arange(6), along, along, indexing="ij")
    return direction_on_face(face, s, t)


def around(mu: np.ndarray, sigma: float, count: int = 800) -> np.ndarray:
    """Directions up to three widths from `mu`."""
    random = np.random.default_rng(0)
    tangent = np.cross(random.normal(size=(count, 3)), mu)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    angle = np.minimum(3.0 * sigma * np.sqrt(random.random(count)), 3.1)[:, None]
    return np.cos(angle) * mu + np.sin(angle) * tangent


@pytest.mark.parametrize("sigma", [1e-3, 0.5, 3.0, 1e6, 1e8])
def test_G4_the_integral_is_right_for_any_width(sigma: float) -> None:
    with mpmath.workdps(60):
        square = mpmath.mpf(sigma) ** 2
        exact = float(2 * mpmath.pi * square * (1 - mpmath.exp(-2 / square)))
    assert gaussian_integral(sigma) == pytest.approx(exact, rel=1e-15)


@pytest.mark.parametrize("edge", [1, 2, 5, 32])
def test_EN1_a_constant_stays_constant(edge: int) -> None:
    cube = CubeMap(np.full((6, edge, edge, 3), 0.7, np.float32))
    filtered = prefilter(cube)
    assert max(np.abs(level / np.float32(0.7) - 1).max() for level in filtered.levels) <= 1e-6
    sigma = np.geomspace(1e-4, 1e4, 500)
    values = filtered.lookup(node_directions(filtered.levels[-1]).reshape(-1, 3)[:500], sigma)
    np.testing.assert_allclose(values, 0.7, rtol=1e-6)


def test_EN2_a_smooth_map_has_no_seams() -> None:
    """Nodes on edges are the same for both faces; steps across an edge are like those beside it."""
    x, y, z = np.moveaxis(cube_directions(N), 3, 0)
    radiance = np.stack([2 + x + y, 2 + x * y - z, 2 + y * y - x * z], axis=-1)
    for level in prefilter(CubeMap(radiance.astype(np.float32))).levels:
        directions, values = node_directions(level).reshape(-1, 3), level.reshape(-1, 3)
        _, place = np.unique(directions.round(9), axis=0, return_inverse=True)
        first = np.zeros((place.max() + 1, 3))
        first[place.ravel()] = values
        assert np.array_equal(first[place.ravel()].astype(np.float32), values)
        steps = np.linalg.norm(np.diff(level, axis=2), axis=-1)
        apart = np.linalg.norm(np.diff(node_directions(level), axis=2), axis=-1)
        slope = steps / apart
        assert slope[:, :, [0, -1]].max() <= 1.5 * slope[:, :, 1:-1].max()


def test_EN3_EN6_the_energy_of_each_level_is_that_of_the_map_even_with_a_sun() -> None:
    radiance = np.random.default_rng(0).random((6, N, N, 3)).astype(np.float32) ** 8
    radiance[0, 0, 0] = 1e6
    radiance[2, 11, 17] = (1e6, 1.0, 1e-3)
    cube = CubeMap(radiance)
    filtered = prefilter(cube)
    towards, weight = cube_directions(128).reshape(-1, 3), np.tile(cube_solid_angles(128).ravel(), 6)
    for sigma in filtered.sigma[2:]:
        mean = weight @ filtered.lookup(towards, sigma) / (4 * np.pi)
        np.testing.assert_allclose(mean, mean_radiance(cube), rtol=1e-3)


PLACES = [(0, 0, 0), (2, N - 1, 0), (4, N // 2, N // 2), (4, 0, N // 2), (1, N // 2, N - 1), (3, 8, 10), (5, 2, 5)]


@pytest.mark.parametrize("place", PLACES)
def test_EN4_a_single_texel_becomes_the_gaussian(place: tuple[int, int, int]) -> None:
    """On any face, edge and corner; errors relative to the height."""
    filtered = prefilter(light_up(place))
    mu, towards = cube_directions(N)[place], cube_directions(96).reshape(-1, 3)
    for sigma, level in zip(filtered.sigma[2:], filtered.levels[2:], strict=True):
        assert peak_error(level, mu, sigma) <= 0.02
        middle = (np.tile(cube_solid_angles(96).ravel(), 6) * filtered.lookup(towards, sigma)[:, 0]) @ towards
        assert np.linalg.norm(middle / np.linalg.norm(middle) - mu) <= 0.5 * texel_width(N)


def peak_error(level: np.ndarray, mu: np.ndarray, sigma: float) -> float:
    exact = gaussian(np.linalg.norm(node_directions(level) - mu, axis=-1), sigma)
    return float(np.abs(level[..., 0] - exact).max() * gaussian_integral(sigma))


@pytest.mark.parametrize(
    ("edge", "row", "column"),
    [
        (64, 1, 3),
        (64, 32, 32),
        (256, 1, 3),
        pytest.param(512, 1, 3, marks=pytest.mark.long),
        pytest.param(512, 256, 256, marks=pytest.mark.long),
    ],
)
def test_EN4_so_it_does_in_larger_maps(edge: int, row: int, column: int) -> None:
    """From two texels on; near a corner and in the middle of a face, where coarser texels are least and most exact."""
    filtered = prefilter(light_up((4, row, column), edge))
    mu = cube_directions(edge)[4, row, column]
    for sigma, level in zip(filtered.sigma, filtered.levels, strict=True):
        if sigma >= 4.0 / edge:
            assert peak_error(level, mu, sigma) <= 0.02
            cells = level.shape[1] - 1
            middle = np.einsum("fij,ij,fijk->k", level[..., 0], _node_weights(cells), node_directions(level))
            apart = np.linalg.norm(middle / np.linalg.norm(middle) - mu)
            assert apart <= max(0.5 * texel_width(edge), 0.02 * sigma)


@pytest.mark.parametrize(("row", "column"), [(0, 0), (0, 1), (1, 1), (0, 5), (2, 3), (1, 20), (9, 9)])
def test_EN4_halving_moves_no_light_even_at_a_corner(row: int, column: int) -> None:
    """All flux is kept, and its mean direction to a tenth of a texel."""
    edge = 64
    flux, coarse = np.zeros((4, 6, edge, edge), np.float32), np.empty((4, 6, edge // 2, edge // 2), np.float32)
    flux[:, 2, row, column] = 1.0
    halve(_pad(flux), coarse)
    assert coarse[0].sum() == pytest.approx(1.0, rel=1e-6)
    middle = np.einsum("fij,fijk->k", coarse[0], cube_directions(edge // 2))
    apart = np.linalg.norm(middle / np.linalg.norm(middle) - cube_directions(edge)[2, row, column])
    assert apart <= 0.1 * texel_width(edge)


def test_a_narrow_gaussian_over_noise_is_the_sum_over_all_texels() -> None:
    """Brute force at random nodes of the level that is summed over the texels themselves."""
    cube = CubeMap(np.random.default_rng(3).random((6, N, N, 3)).astype(np.float32))
    sigma = 2.0 / N
    level = prefilter(cube, [sigma]).levels[0]
    directions, values = node_directions(level).reshape(-1, 3)[::97], level.reshape(-1, 3)[::97]
    texels, area = cube_directions(N).reshape(-1, 3), np.tile(cube_solid_angles(N).ravel(), 6)
    weights = area * np.exp((directions @ texels.T - 1.0) / sigma**2)
    exact = weights @ cube.radiance.reshape(-1, 3) / weights.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(values, exact, atol=2e-3)


@cache
def wavy_map_and_rotated() -> tuple[PrefilteredCube, PrefilteredCube]:
    """A smooth map, and the same rotated by 26 of its 256 columns."""
    environment = EnvironmentMap((1.1 + np.sin(7 * texel_directions(128, 256)) ** 3).astype(np.float32))
    rotated = EnvironmentMap(np.ascontiguousarray(np.roll(environment.radiance, 26, axis=1)))
    return prefilter(cube_of(environment, 64)), prefilter(cube_of(rotated, 64))


@pytest.mark.parametrize("sigma", [0.05, 0.15, 0.5, 2.0])
def test_EN11_turning_the_direction_is_turning_the_map(sigma: float) -> None:
    """By 37°, which moves the texels of a cube."""
    angle = 2 * np.pi * 26 / 256
    direction = np.random.default_rng(1).normal(size=(500, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    cosine, sine = np.cos(angle), np.sin(angle)
    by_u = direction @ np.array([[cosine, 0, -sine], [0, 1, 0], [sine, 0, cosine]]).T  # u grows from −Z to +X
    one, other = wavy_map_and_rotated()
    a, b = one.lookup(direction, sigma), other.lookup(by_u, sigma)
    assert np.sqrt(np.mean((a - b) ** 2) / np.mean(a**2)) <= 0.02
    assert np.array_equal(one.lookup(direction, sigma), a)


def filter_sky() -> tuple[CubeMap, PrefilteredCube]:
    direction = texel_directions(64, 128)
    glow = np.exp(20 * (direction[..., 2:3] - 1))
    cube = cube_of(EnvironmentMap((0.2 + glow * (3.0, 2.0, 1.0)).astype(np.float32)), N)
    return cube, prefilter(cube)


def test_EN12_between_widths_look_ups_are_continuous_and_right() -> None:
    cube, filtered = filter_sky()
    direction = around(np.array([0.0, 0.0, 1.0]), 0.5, 100)
    texels, area = cube_directions(N).reshape(-1, 3), np.tile(cube_solid_angles(N).ravel(), 6)
    for low, high in zip(filtered.sigma[2:-1], filtered.sigma[3:], strict=True):
        sigma = np.sqrt(low * high)
        weights = area * np.exp((direction @ texels.T - 1.0) / sigma**2)
        exact = weights @ cube.radiance.reshape(-1, 3) / weights.sum(axis=1, keepdims=True)
        found = filtered.lookup(direction, sigma)
        assert np.sqrt(np.mean((found - exact) ** 2) / np.mean(exact**2)) <= 0.02
    for sigma in filtered.sigma:
        below, above = (filtered.lookup(direction, sigma * (1 + step)) for step in (-1e-9, 1e-9))
        np.testing.assert_allclose(below, above, rtol=1e-6)


def test_G17_widths_without_end_give_the_mean_and_the_first_moment() -> None:
    cube, filtered = filter_sky()
    direction = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    assert np.allclose(filtered.lookup(direction, 1e9), mean_radiance(cube), rtol=1e-12)
    moment = np.einsum("fijk,fijc,ij->kc", cube_directions(N), cube.radiance, cube_solid_angles(N)) / (4 * np.pi)
    np.testing.assert_allclose(filtered.lookup(direction, 20.0), mean_radiance(cube) + direction @ moment / 400, 1e-4)
    heights = filtered.lookup(np.tile([0.0, 0.0, 1.0], (300, 1)), np.geomspace(1e-3, 1e3, 300))
    assert (np.diff(heights[:, 0]) <= 1e-6).all()


def test_widths_start_at_half_a_texel_and_rise() -> None:
    sigmas = geometric_sigmas(512)
    assert sigmas[0] == pytest.approx(0.5 * np.pi / 2 / 512)
    assert np.allclose(np.diff(np.log(sigmas[3:])), np.log(2) / 2)
    assert (np.diff(sigmas) > 0).all()
    assert sigmas[-1] >= 2.0
    cube = light_up((0, 0, 0), 8)
    for wrong in ([], [0.5, 0.4], [0.5, np.inf], [[0.5]]):
        with pytest.raises(ValueError, match="rise"):
            prefilter(cube, wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="narrower"):
        prefilter(cube, [0.01])
    with pytest.raises(ValueError, match="negative"):
        prefilter(cube, [0.5]).lookup([0, 0, 1], -1.0)


def test_few_and_many_directions_find_the_same() -> None:
    filtered = prefilter(light_up((0, 3, 4)), [0.1, 0.2])
    directions = cube_directions(16).reshape(-1, 3)
    many = filtered.lookup(directions, 0.13)
    assert np.array_equal(many[:100], filtered.lookup(directions[:100], 0.13))
    assert filtered.lookup(directions[5], 0.13).shape == (3,)
