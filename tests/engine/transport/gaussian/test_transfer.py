"""Gaussian transport: between views and vertices, and under maps, rotated maps, lamps and discs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.core.directions import dot, normalize
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import plane
from engine.light.cube_map import CubeMap, cube_directions, cube_of, cube_solid_angles
from engine.light.environment import EnvironmentMap, texel_directions
from engine.light.gaussian_prefilter import (
    PrefilteredCube,
    _grid,
    gaussian_integral,
    prefilter,
    texel_width,
)
from engine.light.lamps import Lamp, lights_of
from engine.render.transported import image_of
from engine.transport.gaussian.fitting.lobes import Lobes, gaussian
from engine.transport.gaussian.fitting.views import VIEWS, nearest_views, view_directions
from engine.transport.gaussian.lighting import (
    MAX_EDGE,
    MIN_EDGE,
    RATIO,
    THRIFTY,
    GaussianLight,
    filter_for,
    levels_between,
    levels_for,
    levels_under,
    lobe_radiance,
    sigma_range,
)
from engine.transport.gaussian.transfer import (
    SeenLobes,
    diffuse_gain,
    diffuse_radiance,
    lobes_seen_from,
    lobes_towards,
    mix,
    radiance_towards,
)
from engine.transport.relight import RelightGaussians, relight_gaussians
from tests.engine.gl.relit_scenes import sphere
from tests.engine.transport.gaussian.synthetic_lobes import mirror_lobes, random_lobes, transport_of

FLAT = 2.0**-23


def one_vertex(normal: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Mesh:
    """A triangle whose vertices have this normal."""
    positions = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    normals = np.tile(np.array(normal, np.float32), (3, 1))
    return Mesh(positions, normals, np.zeros((3, 2), np.float32), np.array([[0, 1, 2]], np.int32), "triangle")


def smooth_sky(rows: int = 128) -> EnvironmentMap:
    """Bright on one side, with colours that tell the axes apart."""
    x, y, z = np.moveaxis(texel_directions(rows, 2 * rows), -1, 0)
    radiance = np.stack([1.0 + 0.8 * x, np.exp(2.0 * y), np.exp(6.0 * (0.6 * x + 0.8 * z - 1.0))], axis=-1)
    return EnvironmentMap(radiance.astype(np.float32), "smooth")


def unit(sigma: np.ndarray) -> np.ndarray:
    """(n, K, 3) energies of lobes whose weight is 1."""
    return np.repeat(gaussian_integral(sigma)[..., None], 3, axis=-1)


def cube_under_one() -> PrefilteredCube:
    return prefilter(CubeMap(np.ones((6, 32, 32, 3), np.float32)))


def weights(seen: SeenLobes) -> np.ndarray:
    return np.asarray(seen.energy / gaussian_integral(seen.sigma)[..., None])


def test_G12_at_a_view_the_lobes_are_its_own() -> None:
    transport = transport_of(one_vertex(), random_lobes(3, 2), random_lobes(3, 1, 5))
    views = np.flatnonzero(view_directions()[:, 2] > 0.0)
    for view in views:
        seen = lobes_towards(transport, view_directions()[view])
        first, second = transport.components
        for name, found in (("weight", weights(seen)), ("mean", seen.mean), ("sigma", seen.sigma)):
            expected = np.concatenate([getattr(lobes, name)[:, view] for lobes in (first, second)], axis=1)
            np.testing.assert_allclose(found, expected, rtol=4 * FLAT, atol=4 * FLAT)


def test_G12_at_a_corner_of_a_triangle_the_lobes_are_its_own() -> None:
    seen = lobes_towards(transport_of(one_vertex(), random_lobes(3, 2)), (0.3, 0.2, 0.9))
    at = mix(seen, np.array([[0, 1, 2]] * 3), np.eye(3))
    for name in ("energy", "mean", "sigma"):
        np.testing.assert_allclose(getattr(at, name), getattr(seen, name), rtol=4e-16, atol=4e-16)


def test_between_views_parameters_are_mixed() -> None:
    transport = transport_of(one_vertex(), random_lobes(3, 1))
    wo = normalize([0.2, 0.31, 0.8])
    index, share = nearest_views(wo)
    assert (view_directions()[index] @ [0.0, 0.0, 1.0] > 0.0).all()
    lobes = transport.components[0]
    seen = lobes_towards(transport, wo)
    energy = lobes.weight[1, index, 0] * gaussian_integral(lobes.sigma[1, index])
    np.testing.assert_allclose(seen.energy[1, 0], share @ energy, rtol=1e-6)
    np.testing.assert_allclose(seen.mean[1, 0], normalize(share @ lobes.mean[1, index, 0].astype(float)), rtol=1e-6)
    np.testing.assert_allclose(seen.sigma[1, 0], np.prod(lobes.sigma[1, index, 0] ** share), rtol=1e-6)


def opposite(share: float) -> tuple[SeenLobes, np.ndarray]:
    """A lobe between two corners whose means are opposite, and the means of the corners."""
    means = np.array([[[0.0, 0.6, 0.8]], [[0.0, -0.6, -0.8]], [[1.0, 0.0, 0.0]]])
    corners = SeenLobes(np.ones((3, 1, 3)), means, np.array([[0.1], [0.4], [0.2]]))
    return mix(corners, np.array([[0, 1, 2]]), np.array([[share, 1.0 - share, 0.0]])), means


def test_G11_opposite_means_in_a_triangle_fall_back_to_the_nearest() -> None:
    at_half, means = opposite(0.5)
    np.testing.assert_array_equal(at_half.mean[0], means[0])
    for share, nearest in ((0.5 + 1e-4, 0), (0.5 - 1e-4, 1), (0.9, 0), (0.1, 1)):
        np.testing.assert_allclose(opposite(share)[0].mean[0], means[nearest], atol=1e-9)
    assert all(np.isfinite(part).all() for part in (at_half.mean, at_half.energy, at_half.sigma))


def test_G11_opposite_means_between_views_do_so_too() -> None:
    lobes = mirror_lobes(np.tile([0.0, 0.0, 1.0], (3, 1)))
    wo = normalize([0.2, 0.31, 0.8])
    index, _ = nearest_views(wo)
    halfway = normalize(view_directions()[index[0]] + view_directions()[index[1]])
    index, share = nearest_views(halfway)
    assert sorted(share)[1:] == pytest.approx([0.5, 0.5])
    first, second = index[share > 0.1]
    lobes.mean[:, first], lobes.mean[:, second] = (0.0, 0.6, 0.8), (0.0, -0.6, -0.8)
    seen = lobes_towards(transport_of(one_vertex(), lobes), halfway)
    assert np.isfinite(seen.mean).all()
    np.testing.assert_allclose(np.abs(seen.mean[0, 0] @ [0.0, 0.6, 0.8]), 1.0, atol=1e-6)
    np.testing.assert_allclose(dot(seen.mean, seen.mean), 1.0, atol=1e-6)


def test_G13_nothing_shines_from_below_the_horizon() -> None:
    transport = transport_of(one_vertex(), mirror_lobes(np.tile([0.0, 0.0, 1.0], (3, 1))))
    wo = normalize(np.random.default_rng(0).normal(size=(3000, 3)))
    below = wo[wo[:, 2] <= 0.0]
    seen = lobes_towards(transport, below, np.zeros(len(below), np.int64))
    assert seen.energy.max() == 0.0


def test_G13_views_below_the_horizon_do_not_darken_those_above() -> None:
    """A model whose lobes weigh the same towards every view above the horizon does so right down to it."""
    normal = normalize([0.3, -0.2, 0.9])
    transport = transport_of(one_vertex(tuple(normal)), mirror_lobes(np.tile(normal, (3, 1))))
    wo = normalize(np.random.default_rng(0).normal(size=(3000, 3)))
    above = wo[wo @ normal > 1e-3]
    seen = lobes_towards(transport, above, np.zeros(len(above), np.int64))
    np.testing.assert_allclose(weights(seen)[:, 0], np.broadcast_to([1.0, 0.7, 0.4], (len(above), 3)), rtol=1e-6)


def test_G17_widths_rise_evenly_in_their_logarithms() -> None:
    shares = np.linspace(0.0, 1.0, 101)
    widths = np.array([opposite(share)[0].sigma[0, 0] for share in shares])
    np.testing.assert_allclose(np.log(widths), shares * np.log(0.1) + (1.0 - shares) * np.log(0.4), atol=1e-12)
    assert (np.diff(widths) < 0.0).all()


def test_an_even_sky_shows_the_energy_of_the_lobes() -> None:
    transport = transport_of(one_vertex(), random_lobes(3, 2), random_lobes(3, 1, 5))
    even = prefilter(CubeMap(np.full((6, 64, 64, 3), 2.0, np.float32)))
    view = int(np.argmax(view_directions()[:, 2]))
    seen = lobes_towards(transport, view_directions()[view])
    found = lobe_radiance(GaussianLight(even, 0.5), seen.energy, seen.mean, seen.sigma)
    expected = sum(lobes.energy()[:, view] for lobes in transport.components)
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_radiance_is_the_sum_of_the_map_times_the_lobes() -> None:
    """Against a plain sum over texels, without any filter."""
    environment = smooth_sky()
    transport = transport_of(one_vertex(), random_lobes(3, 2, narrow=0.15))
    view = int(np.argmax(view_directions()[:, 2]))
    seen = lobes_towards(transport, view_directions()[view])
    light = GaussianLight(filter_for(environment, levels_for(transport.components)), 1.5)
    found = lobe_radiance(light, seen.energy, seen.mean, seen.sigma)
    cube = cube_of(environment, 128)
    towards = cube_directions(128).reshape(-1, 3)
    area = np.tile(cube_solid_angles(128).ravel(), 6)
    highest = (
        1.5
        * lobe_radiance(GaussianLight(cube_under_one()), seen.energy, seen.mean, seen.sigma)
        * cube.radiance.max(axis=(0, 1, 2))
    )
    for vertex in range(3):
        sum_over_lobes = sum(
            gaussian(towards, seen.mean[vertex, k], seen.sigma[vertex, k])[:, None] * weights(seen)[vertex, k]
            for k in range(2)
        )
        expected = 1.5 * (sum_over_lobes * cube.radiance.reshape(-1, 3) * area[:, None]).sum(axis=0)
        assert (np.abs(found[vertex] - expected) <= 0.02 * highest[vertex]).all()


@pytest.mark.parametrize(
    "angle_deg", [*(pytest.param(angle, marks=pytest.mark.long) for angle in (30.0, 90.0)), -137.0]
)
def test_EN11_turning_the_light_is_turning_the_map(angle_deg: float) -> None:
    environment = smooth_sky()
    width = environment.radiance.shape[1]
    columns = round(angle_deg / 360.0 * width)
    angle = 2.0 * math.pi * columns / width
    moved = EnvironmentMap(np.roll(environment.radiance, -columns, axis=1))
    rng = np.random.default_rng(1)
    energy, mean = rng.random((400, 1, 3)), normalize(rng.normal(size=(400, 1, 3)))
    sigma = np.exp(rng.uniform(np.log(0.05), 0.0, (400, 1)))
    levels = levels_between(0.05, 1.0)
    one = lobe_radiance(GaussianLight(filter_for(environment, levels), rotation=angle), energy, mean, sigma)
    other = lobe_radiance(GaussianLight(filter_for(moved, levels)), energy, mean, sigma)
    highest = environment.radiance.max()
    assert np.abs(one - other).max() <= 0.02 * highest
    assert np.sqrt(np.mean((one - other) ** 2) / np.mean(other**2)) < 0.01


def test_EN11_a_light_that_is_not_turned_is_the_same_to_the_bit() -> None:
    filtered = filter_for(smooth_sky(32), levels_between(0.2, 0.6))
    rng = np.random.default_rng(1)
    energy, mean, sigma = rng.random((50, 1, 3)), normalize(rng.normal(size=(50, 1, 3))), np.full((50, 1), 0.3)
    still = lobe_radiance(GaussianLight(filtered, rotation=0.0), energy, mean, sigma)
    assert np.array_equal(still, np.einsum("nkc,nkc->nc", energy, filtered.lookup(mean, sigma)))


def test_EN12_between_levels_for_lobes_radiance_is_continuous_and_right() -> None:
    """A lone bright texel: the height of each lobe towards it, within 2 % of the highest."""
    levels = levels_between(0.1, 0.8)
    radiance = np.zeros((6, levels.edge, levels.edge, 3), np.float32)
    radiance[4, levels.edge // 2, levels.edge // 3] = 1.0
    filtered = prefilter(CubeMap(radiance), levels.sigma)
    towards = cube_directions(levels.edge)[4, levels.edge // 2, levels.edge // 3]
    area = cube_solid_angles(levels.edge)[levels.edge // 2, levels.edge // 3]
    sigma = np.linspace(0.1, 0.8, 400)[:, None]
    mean = np.broadcast_to(normalize(towards + np.array([0.1, 0.05, 0.0])), (400, 1, 3))
    found = lobe_radiance(GaussianLight(filtered), unit(sigma), mean, sigma)[:, 0]
    expected = area * gaussian(towards, mean, sigma)[:, 0]
    assert np.abs(found - expected).max() <= 0.02 * area
    assert np.abs(np.diff(found)).max() < 0.05 * area


def test_a_directional_lamp_shows_the_height_of_the_lobe() -> None:
    lamp = Lamp((0.2, 0.3, 0.9), (2.0, 1.0, 0.5))
    rng = np.random.default_rng(0)
    weight, mean = rng.random((200, 2, 3)), normalize(rng.normal(size=(200, 2, 3)))
    sigma = rng.uniform(0.1, 1.0, (200, 2))
    energy = weight * gaussian_integral(sigma)[..., None]
    found = lobe_radiance(GaussianLight(lamps=(lamp,)), energy, mean, sigma)
    height = gaussian(np.array(lamp.direction), mean, sigma)
    np.testing.assert_allclose(found, np.einsum("nk,nkc->nc", height, weight) * lamp.irradiance, rtol=1e-9)


@pytest.mark.parametrize("radius_deg", [0.5, 5.0, 20.0, 60.0])
@pytest.mark.parametrize("sigma", [0.02, 0.1, 0.4, 1.0])
def test_a_disc_shows_the_integral_of_the_lobe_over_it(radius_deg: float, sigma: float) -> None:
    """Against many directions in its place, for means from its middle to far outside."""
    lamp = Lamp((0.0, 0.0, 1.0), (1.0, 1.0, 1.0), math.radians(radius_deg))
    angle = np.linspace(0.0, math.radians(radius_deg) + 3.0 * sigma, 40)[:, None]
    mean = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=-1)
    widths = np.full((40, 1), sigma)
    found = lobe_radiance(GaussianLight(lamps=(lamp,)), unit(widths), mean, widths)[:, 0]
    lights = lights_of(lamp, 100_000)
    expected = np.array([np.sum(gaussian(lights.direction, one[0], sigma) * lights.irradiance[:, 0]) for one in mean])
    assert found[0] == pytest.approx(expected[0], rel=5e-3)
    assert np.abs(found - expected).max() <= (0.01 if radius_deg < 45.0 else 0.07) * expected.max()


def test_a_disc_that_shrinks_becomes_its_direction() -> None:
    rng = np.random.default_rng(0)
    lobes = rng.random((50, 1, 3)), normalize(rng.normal(size=(50, 1, 3))), rng.uniform(0.1, 1.0, (50, 1))
    small = lobe_radiance(GaussianLight(lamps=(Lamp((0, 0, 1), (1, 1, 1), 1e-4),)), *lobes)
    none = lobe_radiance(GaussianLight(lamps=(Lamp((0, 0, 1), (1, 1, 1)),)), *lobes)
    np.testing.assert_allclose(small, none, rtol=0.01, atol=5e-5)


def test_levels_are_those_that_lobes_need() -> None:
    diffuse, mirror = levels_between(0.3, 0.6), levels_between(0.0016, 0.01)
    assert diffuse.edge == MIN_EDGE
    assert mirror.edge == MAX_EDGE
    for levels, wide in (
        (diffuse, 0.6),
        (mirror, 0.01),
        (levels_between(0.1, 0.1), 0.1),
        (levels_between(0.2, 9.0), 2.0),
    ):
        ratio = np.array(levels.sigma[1:]) / levels.sigma[:-1]
        coarse = np.array(levels.sigma[:-1]) * levels.edge < 2.1
        np.testing.assert_allclose(ratio[~coarse], RATIO, rtol=1e-12)
        np.testing.assert_allclose(ratio[coarse], 2.0, rtol=1e-12)
        assert levels.sigma[-1] >= 0.999 * wide
        assert levels.sigma[-1] < 3.0
    assert not (np.array(diffuse.sigma) * diffuse.edge < 2.1).any()


@pytest.mark.parametrize("texels", [0.0, 0.79, 0.9, 1.7, 2.2, 3.0, 4.2, 5.5, 6.0, 9.0])
def test_levels_lie_where_they_are_cheapest_and_none_is_missing(texels: float) -> None:
    levels = levels_between(texels / MAX_EDGE, 0.1)
    sigma, half = np.array(levels.sigma), 0.5 * texel_width(levels.edge)
    assert half <= sigma[0] <= max(texels / MAX_EDGE, half) * (1.0 + 1e-9)
    assert (sigma[1:] / sigma[:-1]).max() < 2.1
    assert (sigma[1:] / sigma[:-1]).min() > 1.1
    if sigma[0] * levels.edge <= THRIFTY:
        grids = [_grid(width, levels.edge) for width in sigma]
        assert [grid.summed for width, grid in zip(sigma, grids, strict=True) if width == THRIFTY / levels.edge] == [
            levels.edge // 2
        ]
        whole = [grid for width, grid in zip(sigma, grids, strict=True) if 3.5 < width * levels.edge < THRIFTY]
        assert all(grid.dense == 1 for grid in whole)


def test_maps_are_cut_no_finer_than_their_texels() -> None:
    assert [levels_under(smooth_sky(rows), (0.002, 0.002)).edge for rows in (8, 64, 100, 512)] == [32, 32, 64, 256]
    assert levels_between(0.002, 0.002).edge == MAX_EDGE
    for rows in (8, 512):
        levels = levels_under(smooth_sky(rows), (0.002, 0.002))
        assert levels.sigma[0] >= 0.5 * texel_width(levels.edge)


def test_the_range_of_widths_is_that_of_lobes_that_carry_light() -> None:
    lobes = mirror_lobes(np.tile([0.0, 0.0, 1.0], (200, 1)), 0.2)
    lobes.sigma[:, view_directions()[:, 2] <= 0.0] = 0.0016  # black ones
    lobes.sigma[0, np.argmax(view_directions()[:, 2])] = 0.4
    assert sigma_range([lobes]) == pytest.approx((0.2, 0.2))
    assert sigma_range([]) == (0.5, 0.5)
    for share, narrowest in ((3e-4, 0.2), (3e-3, 0.05)):  # of the light, of which a thousandth may be left out
        energy = np.array([share, 1.0 - share])
        both = np.broadcast_to(np.array([0.05, 0.2], np.float32), (10, VIEWS, 2)).copy()
        weight = np.broadcast_to(energy / gaussian_integral(both), both.shape)[..., None].repeat(3, axis=-1)
        means = np.broadcast_to(np.array([0.0, 0.0, 1.0], np.float32), (10, VIEWS, 2, 3)).copy()
        assert sigma_range([Lobes(weight.astype(np.float32), means, both)])[0] == pytest.approx(narrowest)
    assert sigma_range([Lobes(0.0 * lobes.weight, lobes.mean, lobes.sigma)]) == (0.5, 0.5)


def test_the_diffuse_part_gives_way_towards_grazing_where_the_brdf_does() -> None:
    mesh = sphere(3)
    eye = np.array([0.0, 0.0, 4.0])
    lobes = mirror_lobes(normalize(mesh.normals), 0.2, 0.0)
    coefficients = np.zeros((25, 3))
    coefficients[0] = 2.0
    for grazing in (False, True):
        transport = transport_of(mesh, lobes, ground=Ground(albedo=0.5), grazing=grazing)
        diffuse = diffuse_radiance(transport, coefficients)
        gain = diffuse_gain(transport, eye)
        found = radiance_towards(transport, GaussianLight(), diffuse, eye)
        np.testing.assert_allclose(found, diffuse * gain[:, None], rtol=1e-12)
        cosine = dot(transport.normals, normalize(eye - transport.mesh.positions))[: transport.ground_vertex]
        seen = cosine > 0.05
        expected = 1.0 - (1.0 - 0.5 * cosine[seen]) ** 5 if grazing else 1.0
        np.testing.assert_allclose(gain[: transport.ground_vertex][seen], expected, rtol=1e-12)
        assert (gain[transport.ground_vertex :] == 1.0).all()


def test_highlights_are_finer_than_the_triangles() -> None:
    """Figure 2 of the paper: on a coarse ball a sun stays a round spot, because lobes and not colours are mixed."""
    images = []
    for halvings in (2, 5):
        mesh = sphere(halvings)
        transport = transport_of(mesh, mirror_lobes(normalize(mesh.normals), 0.08))
        light = GaussianLight(lamps=(Lamp((0.3, 0.4, 0.9), (1.0, 1.0, 1.0)),))
        relit = RelightGaussians(transport, light, np.zeros((len(mesh.positions), 3)))
        images.append(drain(image_of(relit, frame(sphere(5).positions), (96, 96), 1)).image[..., 0])
    coarse, fine = images
    assert coarse.max() == pytest.approx(fine.max(), rel=0.1)
    assert coarse.sum() == pytest.approx(fine.sum(), rel=0.15)


def test_images_are_finite_and_black_from_behind() -> None:
    mesh = plane()
    transport = transport_of(mesh, random_lobes(len(mesh.positions), 3))
    light = GaussianLight(filter_for(smooth_sky(16), levels_for(transport.components)))
    relit = RelightGaussians(transport, light, np.zeros((len(mesh.positions), 3)))
    for eye, lit_up in (((0.0, 0.0, 2.0), True), ((0.0, 0.0, -2.0), False)):
        camera = frame(mesh.positions)
        camera = type(camera)(eye, (0.0, 0.0, 0.0))
        image = drain(image_of(relit, camera, (40, 30), 2)).image
        assert np.isfinite(image).all()
        assert (image[..., 3].max(), image[..., :3].max() > 0.0) == (1.0, lit_up)


def test_lobes_seen_of_the_ground_are_black() -> None:
    mesh = plane()
    transport = transport_of(mesh, random_lobes(len(mesh.positions), 2), ground=Ground())
    seen = lobes_seen_from(transport, (0.3, 0.2, 3.0))
    assert len(seen.sigma) == len(transport.mesh.positions)
    assert seen.energy[transport.ground_vertex :].max() == 0.0
    assert np.isfinite(seen.mean).all()
    assert seen.sigma.min() > 0.0


def test_parts_that_do_not_belong_together_are_refused() -> None:
    mesh = plane()
    with pytest.raises(ValueError, match="do not belong"):
        transport_of(mesh, random_lobes(len(mesh.positions) - 1, 1))
    with pytest.raises(ValueError, match="not possible"):
        GaussianLight(factor=math.nan)
    transport = transport_of(mesh, random_lobes(len(mesh.positions), 1))
    with pytest.raises(ValueError, match="diffuse has the shape"):
        RelightGaussians(transport, GaussianLight(), np.zeros((1, 3)))


def test_all_views_are_stored() -> None:
    assert mirror_lobes(np.eye(3)).sigma.shape == (3, VIEWS, 1)


def test_all_light_of_a_scene_falls_on_lobes_and_the_diffuse_part() -> None:
    mesh = sphere(2)
    transport = transport_of(mesh, mirror_lobes(normalize(mesh.normals), 0.2), diffuse=True)
    sky, lamp = smooth_sky(32), Lamp((0.0, 0.0, 1.0), (1.0, 1.0, 1.0))
    eye = (0.0, 0.0, 4.0)

    def radiance(relit: RelightGaussians) -> np.ndarray:
        return radiance_towards(transport, relit.light, relit.diffuse, eye)

    both = radiance(relight_gaussians(transport, sky, rotation=0.5, factor=2.0, lamps=(lamp,)))
    apart = 2.0 * radiance(relight_gaussians(transport, sky, rotation=0.5)) + radiance(
        relight_gaussians(transport, None, lamps=(lamp,))
    )
    np.testing.assert_allclose(both, apart, rtol=1e-5, atol=1e-7)
    alone = transport_of(mesh, *transport.components)
    assert relight_gaussians(alone, sky).diffuse.max() == 0.0
